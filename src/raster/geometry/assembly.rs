//! What geometry is assembled from, and its parts before they are joined.
//!
//! In: nothing. Out: the types that the steps of [`assemble`](super::assemble) share.

use crate::image::cryptomatte::MatteId;
use crate::lattice::ScreenLattice;
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
    /// Per part of the pose: the lattice that warps it, if any.
    pub lattices: &'a [Option<&'a ScreenLattice>],
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
    /// Per part: 1 + index of the layer, 0 for none.
    pub layer_ids: &'a [u32],
    /// Per part: its ids in the Cryptomattes, in the order of [`MATTE_LAYERS`]; empty: none.
    pub mattes: &'a [[MatteId; MATTE_LAYERS.len()]],
    /// All lights.
    pub lights: &'a [PosedLight],
    /// Strength of the neutral surroundings.
    pub environment: f32,
    /// Width of lines, frame heights.
    pub line_width: f64,
}

/// One part, ready to be joined with the others.
pub(super) struct BuiltPart {
    pub(super) vertices: Vec<RasterVertex>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Its indices are filled in when the parts are joined.
    pub(super) draw: Draw,
    pub(super) is_blended: bool,
}
