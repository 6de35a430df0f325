//! Lattice files as they stand in JSON.
//!
//! In: JSON. Out: lists of numbers, not yet compared with each other; see [`super::lattice_file`].

use crate::lattice::Basis;
use serde::{Deserialize, Serialize};

/// A lattice file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFile {
    /// Version of the format.
    pub(super) pinwarp_lattice: u32,
    /// Width of the frame in frame heights.
    pub(super) frame_aspect: f64,
    /// Frames a second.
    pub(super) rate: f64,
    /// One a layer.
    pub(super) layers: Vec<RawTrack>,
}

/// The lattices of a layer.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTrack {
    /// Name of the layer.
    pub(super) name: String,
    /// What the coordinates are.
    pub(super) space: RawSpace,
    /// How handles are blended.
    pub(super) basis: Basis,
    /// Handles an axis: two on the screen, three in the world.
    pub(super) dims: Vec<usize>,
    /// Frames, increasing.
    pub(super) frames: Vec<RawFrame>,
}

/// What the coordinates are.
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
    /// In the world: x, y and z axis and origin of the box's own frame, scene units; left out: the scene's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) placement: Option<[[f64; 3]; 4]>,
    /// Angle by which the box is turned about its middle, counter-clockwise, degrees; kept free for boxes that turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) angle: Option<f64>,
    /// Moved handles, x fastest.
    pub(super) handles: Vec<Vec<f64>>,
    /// On the screen: the branches of the lattice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) branches: Option<RawBranches>,
}

/// The branches of a lattice.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBranches {
    /// Corners of the regions.
    pub(super) points: Vec<[f64; 2]>,
    /// From back to front.
    pub(super) list: Vec<RawBranch>,
}

/// A branch.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBranch {
    /// The handles that act on it: index, x, y.
    pub(super) handles: Vec<(u32, f64, f64)>,
    /// Convex polygons, as indices of points.
    pub(super) region: Vec<Vec<u32>>,
}
