//! The inputs of geometry assembly, and its parts before they are joined.
//!
//! In: nothing. Out: the types shared by the steps of [`assemble`](super::assemble).

use super::part_warp::PartWarp;
use crate::image::cryptomatte::MatteId;
use crate::pose::{Pose, PosedLight};
use crate::raster::{Draw, MATTE_LAYERS, RasterVertex};
use crate::scene::Scene;
use crate::screen::Camera;
use std::sync::OnceLock;

/// The scene as projected at one time, with its solved lattices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PosedScene<'a> {
    /// The pose.
    pub pose: &'a Pose,
    /// The camera.
    pub camera: &'a Camera,
    /// The warp of each part of the pose.
    pub warps: &'a [PartWarp<'a>],
}

/// The inputs of [`assemble`](super::assemble).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Assembly<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The time to draw.
    pub now: PosedScene<'a>,
    /// One frame later, then one frame earlier; `None` if motion is not requested (it is then zero).
    pub neighbours: Option<[PosedScene<'a>; 2]>,
    /// Per part, the warp for which long edges are split; `None`: that of `now`.
    pub split_for: Option<&'a [PartWarp<'a>]>,
    /// Per part: its submeshes with different ids.
    pub submeshes: &'a [Vec<Submesh>],
    /// All lights.
    pub lights: &'a [PosedLight],
    /// Strength of the neutral environment.
    pub environment: f32,
    /// Width of lines in frame heights.
    pub line_width: f64,
}

/// Triangles of a part with common ids.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Submesh {
    /// Indices of its triangles; `None`: all of the part, or its lines.
    pub triangles: Option<Vec<u32>>,
    /// 1 + index of the layer, 0 for none.
    pub layer_id: u32,
    /// Ids in the Cryptomattes, in the order of [`MATTE_LAYERS`].
    pub mattes: [MatteId; MATTE_LAYERS.len()],
}

/// One part, ready to be joined with the others.
#[derive(Clone, Debug)]
pub(super) struct BuiltPart {
    pub(super) vertices: Vec<RasterVertex>,
    /// The triangles of all submeshes, consecutively.
    pub(super) triangles: Vec<[u32; 3]>,
    /// One draw per submesh, and the end of its triangles. Index ranges are filled in when the parts are joined.
    pub(super) draws: Vec<(Draw, usize)>,
    pub(super) is_blended: bool,
}

/// Parts that stay the same from one assembly of a time to the next; they are built once.
#[derive(Debug, Default)]
pub(crate) struct KeptParts {
    /// #parts: the built part; `None` for parts that are built again each time.
    pub(super) parts: Vec<Option<OnceLock<BuiltPart>>>,
}

impl KeptParts {
    /// `is_kept`: #parts, whether a part stays the same.
    #[cfg(any(test, feature = "editor"))]
    pub(crate) fn new(is_kept: impl IntoIterator<Item = bool>) -> Self {
        Self { parts: is_kept.into_iter().map(|is_kept| is_kept.then(OnceLock::new)).collect() }
    }
}
