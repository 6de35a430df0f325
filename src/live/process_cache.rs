//! All that is kept for the process, and why.
//!
//! Hosts make instances as they like (MLT: one a frame) and render from many threads, so an instance can keep nothing.
//! Everything here is kept by content (files by path, time and length; alpha by its samples), and would be computed again
//! to the same bits: a host that is short of memory may purge it at any time. Buffers are kept in
//! [`buffer_pool`](super::buffer_pool).

use super::Warp;
use super::base_scene::BaseScene;
use super::cache::Cache;
use super::prepared_solver::PreparedSolver;
use crate::pipeline::PinAnchor;
use crate::plate::WarpMap;
use crate::shot::Shot;
use crate::space::PixelRect;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Shot files, and lists of files beside scenes.
const SHOTS: usize = 16;
/// Scenes; those of shots may be large.
const SCENES: usize = 8;
/// Bytes of prefactored solvers: about 64 of 10 x 10 handles.
pub(super) const SOLVER_BYTES: usize = 1 << 27;
/// Sets of pins that were cast onto a surface.
const CASTS: usize = 256;
/// Solved warps: a few KB each; those with parts weigh more.
const WARPS: usize = 4096;
/// Last warps over alphas.
const SHOWN_WARPS: usize = 64;
/// Bytes of maps: eight frames of 1080p.
const MAP_BYTES: usize = 1 << 27;
/// Regions: hosts ask for the same one many times.
const REGIONS: usize = 4096;
/// Warps with parts.
const PART_WINDOWS: usize = 256;

/// What is kept.
pub(super) static CACHE: LazyLock<ProcessCache> = LazyLock::new(|| ProcessCache {
    shots: Cache::new(SHOTS, |_| 1),
    files_beside: Cache::new(SHOTS, |_| 1),
    scenes: Cache::new(SCENES, |_| 1),
    solvers: Cache::new(SOLVER_BYTES, PreparedSolver::bytes),
    casts: Cache::new(CASTS, |_| 1),
    warps: Cache::new(WARPS, Warp::weight),
    shown_warps: Cache::new(SHOWN_WARPS, |_| 1),
    maps: Cache::new(MAP_BYTES, |maps: &Vec<WarpMap>| bytes_of_maps(maps)),
    regions: Cache::new(REGIONS, |_| 1),
    part_windows: Cache::new(PART_WINDOWS, |_| 1),
});

/// The caches, in the order in which a frame asks for them.
pub(super) struct ProcessCache {
    /// Shot files: every instance of a host names one, few are different.
    pub(super) shots: Cache<Shot>,
    /// Buffers and images of scenes: their times are part of every key, finding them takes a parse of the scene.
    pub(super) files_beside: Cache<Vec<PathBuf>>,
    /// Loaded scenes: seconds each.
    pub(super) scenes: Cache<BaseScene>,
    /// Factored solvers: a drag changes targets only.
    pub(super) solvers: Cache<PreparedSolver>,
    /// Pins cast onto the model: the same for all frames.
    pub(super) casts: Cache<Vec<Option<PinAnchor>>>,
    /// Solved warps: hosts ask for one several times a frame, for regions, tiles and overlays.
    pub(super) warps: Cache<Warp>,
    /// The last warp over a picture's alpha, by the controls alone: hosts have no pixels while they draw handles.
    pub(super) shown_warps: Cache<Warp>,
    /// Where pixels come from, tile by tile: tiles of one frame are rendered by many calls.
    pub(super) maps: Cache<Vec<WarpMap>>,
    /// Regions of definition and interest.
    pub(super) regions: Cache<PixelRect>,
    /// Where the parts of a picture can be seen.
    pub(super) part_windows: Cache<Vec<PixelRect>>,
}

impl ProcessCache {
    /// Lets go of all but the few warps that handles are drawn with: without a render they cannot be computed again.
    pub(super) fn purge(&self) {
        let Self { shots, files_beside, scenes, solvers, casts, warps, shown_warps: _, maps, regions, part_windows } =
            self;
        shots.clear();
        files_beside.clear();
        scenes.clear();
        solvers.clear();
        casts.clear();
        warps.clear();
        maps.clear();
        regions.clear();
        part_windows.clear();
    }
}

fn bytes_of_maps(maps: &[WarpMap]) -> usize {
    maps.iter().map(|map| std::mem::size_of_val(&map.offsets[..]) + 4 * map.folded_pixels.len()).sum()
}
