//! The JSON structure of lattice files.
//!
//! In: JSON. Out: lists of numbers, before cross-validation; see [`super::lattice_file`].

use crate::lattice::Basis;
use serde::{Deserialize, Serialize};

/// A lattice file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFile {
    /// Version of the format.
    pub(super) pinwarp_lattice: u32,
    /// Name and version of the program that wrote the file; not used on reading.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) generator: Option<String>,
    /// Width of the frame in frame heights.
    pub(super) frame_aspect: f64,
    /// Frame rate, in frames per second.
    pub(super) rate: f64,
    /// One per layer.
    pub(super) layers: Vec<RawTrack>,
}

/// The lattices of a layer.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTrack {
    /// Name of the layer.
    pub(super) name: String,
    /// Space of the coordinates.
    pub(super) space: RawSpace,
    /// Basis functions.
    pub(super) basis: Basis,
    /// Handles per axis: two axes on the screen, three in the scene.
    pub(super) dims: Vec<usize>,
    /// Frames, increasing.
    pub(super) frames: Vec<RawFrame>,
}

/// Space of the coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawSpace {
    /// Frame heights, x right, y up, from the lower left corner of the display window.
    Screen,
    /// Scene units, as in glTF: y up.
    World,
}

/// The lattice of a frame.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFrame {
    /// Frame number.
    pub(super) frame: i32,
    /// Lower and upper corner of the rest box.
    #[serde(rename = "box")]
    pub(super) bounds: [Vec<f64>; 2],
    /// Scene space only: x, y and z axis and origin of the box's own frame, in scene units; if missing, those of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) placement: Option<[[f64; 3]; 4]>,
    /// Rotation of the box about its centre, counter-clockwise, in radians; default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) angle: Option<f64>,
    /// Moved handles, x fastest.
    pub(super) handles: Vec<Vec<f64>>,
    /// Screen space only: the branches of the lattice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) branches: Option<RawBranches>,
}

/// The branches of a lattice.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBranches {
    /// Corners of the regions.
    pub(super) points: Vec<[f64; 2]>,
    /// Branches from back to front.
    pub(super) list: Vec<RawBranch>,
}

/// A branch.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBranch {
    /// The handles that influence the branch: index, x, y.
    pub(super) handles: Vec<(u32, f64, f64)>,
    /// Convex polygons, as indices of points.
    pub(super) region: Vec<Vec<u32>>,
}
