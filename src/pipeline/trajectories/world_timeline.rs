//! A world layer as a function of time, from which its trajectory is solved.
//!
//! In: a [`PreparedShot`] and a layer. Out: the layer's problem at any time.

use super::layer_timeline::Watcher;
use crate::lattice::Grid;
use crate::pipeline::evaluate::world_layer::WorldLayer;
use crate::pipeline::{PinAnchor, PreparedShot};
use crate::shot::{Layer, LayerSpace};
use crate::solve::{Settings, SolveError, TimedProblem, Timeline, knots_per_gib};

/// A world layer as a function of time.
pub(in crate::pipeline) struct WorldTimeline<'a> {
    pub(in crate::pipeline) prepared: &'a PreparedShot,
    pub(in crate::pipeline) index: usize,
    pub(in crate::pipeline) points: &'a [PinAnchor],
    pub(in crate::pipeline) watcher: Watcher<'a>,
}

impl WorldTimeline<'_> {
    fn layer(&self) -> &Layer {
        &self.prepared.shot.layers[self.index]
    }

    /// Returns the diagonal of the box at a time, metres; 1 if there is no box.
    pub(in crate::pipeline) fn size(&self, time: f64) -> f64 {
        let (pose, camera) = self.prepared.view(time);
        WorldLayer::at(self.prepared, self.index, time, (&pose, &camera)).map_or(1.0, |layer| layer.grid.diagonal())
    }
}

impl Timeline<3> for WorldTimeline<'_> {
    type Error = SolveError;

    fn settings(&self) -> &Settings {
        &self.layer().settings
    }

    fn at(&self, time: f64) -> Result<Option<TimedProblem<3>>, SolveError> {
        if (self.watcher.is_cancelled)() {
            return Err(SolveError::Cancelled);
        }
        let (pose, camera) = self.prepared.view(time);
        let layer = WorldLayer::at(self.prepared, self.index, time, (&pose, &camera));
        Ok(layer.and_then(|layer| layer.timed_problem(time, self.points)))
    }

    fn window(&self) -> usize {
        match self.layer().space {
            LayerSpace::World { dims, .. } => {
                knots_per_gib(&Grid { dims, basis: self.layer().basis, lo: [0.0; 3], hi: [1.0; 3], angle: 0.0 }, None)
            }
            LayerSpace::Screen { .. } => usize::MAX,
        }
    }

    fn progress(&self, done: usize, of: usize) {
        (self.watcher.progress)(done, of);
    }
}
