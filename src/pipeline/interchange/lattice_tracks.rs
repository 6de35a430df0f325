//! Collects the solved lattices of a shot over its frames, for other shots and programs.
//!
//! In: a [`PreparedShot`] and frames. Out: a [`LatticeFile`].

use crate::export::{LatticeBranches, LatticeFile, LatticeTrack, Track};
use crate::lattice::{BoxFrame, Lattice};
use crate::pipeline::{LayerState, PipelineError, PreparedShot};
use crate::plate::WholeWarp;
use std::collections::BTreeMap;

/// The lattices of a layer by frame, on the screen or in the scene.
#[derive(Clone, Default)]
struct Solved {
    screen: BTreeMap<i32, Lattice<2>>,
    world: BTreeMap<i32, Lattice<3>>,
    placements: BTreeMap<i32, BoxFrame>,
    branches: BTreeMap<i32, LatticeBranches>,
    has_branches_in_scene: bool,
    wholes: BTreeMap<i32, WholeWarp>,
}

impl Solved {
    fn add(&mut self, frame: i32, (state, branches): (&LayerState, Option<LatticeBranches>)) {
        self.branches.extend(branches.map(|branches| (frame, branches)));
        self.screen.extend(state.solution.as_ref().map(|solution| (frame, solution.lattice.clone())));
        self.wholes.extend(state.whole.as_ref().map(|whole| (frame, whole.clone())));
        self.has_branches_in_scene |= state.world.as_ref().is_some_and(|world| world.branches.is_some());
        let world = state.world.as_ref().map(|world| &world.lattice);
        self.world.extend(world.map(|placed| (frame, placed.lattice.clone())));
        self.placements.extend(world.map(|placed| (frame, placed.frame)));
    }

    /// Returns `None` if the layer is never warped.
    fn track(self, name: &str) -> Option<LatticeTrack> {
        let Self { screen, world, placements, branches, has_branches_in_scene, wholes } = self;
        let track = match (screen.is_empty(), world.is_empty()) {
            (true, true) => return None,
            (_, true) => Track::Screen(screen),
            (_, false) => Track::World(world),
        };
        Some(LatticeTrack { name: name.to_owned(), track, placements, branches, has_branches_in_scene, wholes })
    }
}

/// Returns the solved lattices of the given frames, each at the frame's own time; layers that are never warped are left
/// out. `on_frame` is called after every frame.
///
/// # Errors
/// [`PipelineError::Solve`] if a layer cannot be solved; [`PipelineError::Mismatch`] if no layer is warped at all.
pub fn lattices(
    prepared: &PreparedShot,
    frames: &[i32],
    mut on_frame: impl FnMut(i32),
) -> Result<LatticeFile, PipelineError> {
    let shot = &prepared.shot;
    let mut solved = vec![Solved::default(); shot.layers.len()];
    for &frame in frames {
        // Solved at the frame's own time instead of mid-exposure, because readers of the file choose the time of their samples.
        let sample = prepared.sample_at(f64::from(frame))?;
        for (layer, (solved, state)) in solved.iter_mut().zip(&sample.layers).enumerate() {
            solved.add(frame, (state, prepared.file_branches(layer, &sample)));
        }
        on_frame(frame);
    }
    let tracks = shot.layers.iter().zip(solved);
    let layers: Vec<LatticeTrack> = tracks.filter_map(|(layer, solved)| solved.track(&layer.name)).collect();
    if layers.is_empty() {
        let what = "no layer is warped in these frames: there is nothing to export";
        return Err(PipelineError::mismatch(shot, "layer", what, "add pins, or choose other frames"));
    }
    Ok(LatticeFile { frame_aspect: shot.size.aspect(), rate: shot.frames.rate, layers })
}
