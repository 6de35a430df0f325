//! What geometry is assembled from, and its parts before they are joined.
//!
//! In: nothing. Out: the types that the steps of [`assemble`](super::assemble) share.

use super::part_warp::PartWarp;
use crate::image::cryptomatte::MatteId;
use crate::pose::{Pose, PosedLight};
use crate::raster::{Draw, MATTE_LAYERS, RasterVertex};
use crate::scene::Scene;
use crate::screen::Camera;

/// The scene on the screen at one time, with its solved lattices.
#[derive(Clone, Copy, Debug)]
pub struct PosedScene<'a> {
    /// The pose.
    pub pose: &'a Pose,
    /// The camera that sees it.
    pub camera: &'a Camera,
    /// Per part of the pose: what warps it.
    pub warps: &'a [PartWarp<'a>],
}

/// What [`assemble`](super::assemble) needs.
#[derive(Clone, Copy, Debug)]
pub struct Assembly<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The time to draw.
    pub now: PosedScene<'a>,
    /// One frame later, then one frame earlier; `None` where motion is not wanted (it is then zero).
    pub neighbours: Option<[PosedScene<'a>; 2]>,
    /// Per part: what it is told apart by.
    pub pieces: &'a [Vec<Piece>],
    /// All lights.
    pub lights: &'a [PosedLight],
    /// Strength of the neutral surroundings.
    pub environment: f32,
    /// Width of lines, frame heights.
    pub line_width: f64,
}

/// Triangles of a part that share their ids.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Piece {
    /// Which triangles, by their numbers; `None`: all of the part, or its lines.
    pub triangles: Option<Vec<u32>>,
    /// 1 + index of the layer, 0 for none.
    pub layer_id: u32,
    /// Ids in the Cryptomattes, in the order of [`MATTE_LAYERS`].
    pub mattes: [MatteId; MATTE_LAYERS.len()],
}

/// One part, ready to be joined with the others.
pub(super) struct BuiltPart {
    pub(super) vertices: Vec<RasterVertex>,
    /// Of all pieces, one after the other.
    pub(super) triangles: Vec<[u32; 3]>,
    /// One a piece: how it is drawn, and where its triangles end. Indices are filled in when the parts are joined.
    pub(super) draws: Vec<(Draw, usize)>,
    pub(super) is_blended: bool,
}
