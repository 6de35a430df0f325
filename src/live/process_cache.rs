//! Everything that is cached for the process, and why.
//!
//! Hosts create instances at will (MLT: one per frame) and render from many threads, so instances cannot hold state.
//! All values are keyed by content (files by path, time and length; alpha by its samples) and would be recomputed
//! bit-identically: hosts that are short of memory may purge them at any time. Buffers are kept in
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

/// Number of shot files, and of file lists of scenes.
const SHOTS: usize = 16;
/// Number of scenes; those of shots may be large.
const SCENES: usize = 8;
/// Bytes of prefactored solvers: about 64 of 10 x 10 handles.
pub(super) const SOLVER_BYTES: usize = 1 << 27;
/// Number of sets of pins cast onto a surface.
const CASTS: usize = 256;
/// Total weight of solved warps: a few KB each; those with parts weigh more.
const WARPS: usize = 4096;
/// Number of most recent warps over alphas.
const SHOWN_WARPS: usize = 64;
/// Bytes of maps: eight frames of 1080p.
const MAP_BYTES: usize = 1 << 27;
/// Number of regions, which hosts request repeatedly.
const REGIONS: usize = 4096;
/// Number of warps with parts.
const PART_WINDOWS: usize = 256;

/// The caches of the process.
pub(super) static CACHE: LazyLock<ProcessCache> = LazyLock::new(ProcessCache::new);

/// The caches, in the order in which a frame uses them.
pub(super) struct ProcessCache {
    /// Shot files: all instances of a host name few different ones.
    pub(super) shots: Cache<Shot>,
    /// Buffer and image files of scenes: their times are part of every key, and finding them requires parsing the scene.
    pub(super) files_beside: Cache<Vec<PathBuf>>,
    /// Loaded scenes, which take seconds each.
    pub(super) scenes: Cache<BaseScene>,
    /// Factored solvers: a drag changes only targets.
    pub(super) solvers: Cache<PreparedSolver>,
    /// Pins cast onto the model, which are the same for all frames.
    pub(super) casts: Cache<Vec<Option<PinAnchor>>>,
    /// Solved warps: hosts request each several times per frame, for regions, tiles and overlays.
    pub(super) warps: Cache<Warp>,
    /// The most recent warps over a picture's alpha, keyed by the controls alone: hosts have no pixels while they draw handles.
    pub(super) shown_warps: Cache<Warp>,
    /// Maps of tiles: tiles of one frame are rendered by many calls.
    pub(super) maps: Cache<Vec<WarpMap>>,
    /// Regions of definition and interest.
    pub(super) regions: Cache<PixelRect>,
    /// Windows in which the parts of a picture are visible.
    pub(super) part_windows: Cache<Vec<PixelRect>>,
}

impl ProcessCache {
    fn new() -> Self {
        Self {
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
        }
    }

    /// Frees everything except the few warps used to draw handles, which cannot be recomputed without a render.
    #[cfg(any(test, feature = "ofx"))]
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

#[cfg(test)]
mod tests {
    use super::super::LiveError;
    use super::super::key::KeyWriter;
    use super::*;

    #[test]
    fn a_purge_lets_go_of_shots_and_of_what_lies_beside_scenes() {
        // Not those of the process, which other tests use meanwhile.
        let caches = ProcessCache::new();
        let key = KeyWriter::new().finish();
        let text = "version = 1\nscene = \"scene.gltf\"\nframes = { first = 1, last = 1 }\nsize = [16, 9]\n";
        caches.shots.get(key, || Ok::<_, LiveError>(Shot::parse(text, "shot.toml".as_ref())?)).expect("a shot");
        caches.files_beside.get(key, || Ok::<_, LiveError>(vec!["points.bin".into()])).expect("a list");
        let kept = || (caches.files_beside.peek(key).is_some(), caches.shots.peek(key).is_some());
        assert_eq!(kept(), (true, true));
        caches.purge();
        assert_eq!(kept(), (false, false));
    }
}
