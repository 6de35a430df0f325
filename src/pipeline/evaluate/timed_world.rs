//! Evaluates world layers at one time, from their trajectories or by separate solves, and moves the meshes.
//!
//! In: a pose and its camera. Out: the lattice of each world layer, and a [`TimeSample`] with deformed meshes.

use super::layer_solve::solve_layer;
use super::moved_meshes::move_meshes;
use super::world_layer::WorldLayer;
use crate::lattice::SceneLattice;
use crate::pipeline::trajectories::layer_timeline::Watcher;
use crate::pipeline::trajectories::watched_trajectory::Outcome;
use crate::pipeline::trajectories::{has_trajectory, world_trajectory};
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample, WorldSolution};
use crate::pose::Pose;
use crate::screen::{Camera, project};
use crate::solve::{Cancel, Problem, Solution, Solver, Targets};

/// What a time does if the trajectory of a layer is not solved yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::pipeline) enum Unsolved {
    /// Solves the trajectory, over all frames.
    Wait,
    /// Solves the layer for this time alone.
    #[cfg_attr(not(any(test, feature = "editor")), expect(dead_code, reason = "only the editor solves frames alone"))]
    Alone,
}

impl PreparedShot {
    /// Poses and projects a (fractional) frame with its world layers solved and its screen layers unsolved.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a world layer cannot be solved.
    pub(crate) fn unsolved_at(&self, frame: f64) -> Result<TimeSample, PipelineError> {
        self.world_solved_at(frame, Unsolved::Wait)
    }

    /// As [`Self::unsolved_at`]; `unsolved` says whether world layers wait for their trajectories.
    pub(in crate::pipeline) fn world_solved_at(
        &self,
        frame: f64,
        unsolved: Unsolved,
    ) -> Result<TimeSample, PipelineError> {
        let (mut pose, camera) = self.view(frame);
        let layers = solve_all(self, (frame, unsolved), &pose, &camera)?;
        move_meshes((&self.scene, &self.assignment), &mut pose, &layers);
        let mesh = Some(project(&pose, &camera));
        Ok(TimeSample { frame, pose, camera, mesh, layers })
    }
}

/// Returns one state per layer, solved for world layers.
fn solve_all(
    prepared: &PreparedShot,
    (frame, unsolved): (f64, Unsolved),
    pose: &Pose,
    camera: &Camera,
) -> Result<Vec<LayerState>, PipelineError> {
    let solve = |index: usize| match WorldLayer::at(prepared, index, frame, (pose, camera)) {
        Some(layer) => layer.solve(frame, unsolved),
        None => Ok(LayerState::default()),
    };
    (0..prepared.shot.layers.len()).map(solve).collect()
}

impl WorldLayer<'_> {
    fn solve(&self, frame: f64, unsolved: Unsolved) -> Result<LayerState, PipelineError> {
        let (pins, goal) = self.goal(frame);
        if goal.pins.is_empty() && goal.handles.is_empty() {
            return Ok(LayerState::default());
        }
        let presence = pins.iter().map(|pin| pin.state.presence).fold(0.0, f64::max);
        let Solution { lattice, branches, report } = self.solution((frame, unsolved), &goal, presence)?;
        let in_scene = pins.iter().map(|pin| pin.in_scene).collect();
        let lattice = SceneLattice { frame: self.frame, lattice };
        let world = Some(WorldSolution { lattice, branches, report, pins: in_scene });
        let pins = pins.into_iter().map(|pin| pin.state).collect();
        Ok(LayerState { world, pins, starts: self.starts.clone(), ..LayerState::default() })
    }

    /// Returns the solution from the layer's trajectory, or solved for this time alone. If no handle is moved, the
    /// latter fades with the largest presence of the pins.
    fn solution(
        &self,
        (time, unsolved): (f64, Unsolved),
        goal: &Targets<3>,
        presence: f64,
    ) -> Result<Solution<3>, PipelineError> {
        let layer = &self.prepared.shot.layers[self.index];
        let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame: time, source };
        let never = Cancel::never();
        let is_fading = goal.handles.is_empty() && presence < 1.0;
        let is_known = || self.prepared.cache.world_trajectories.is_known(self.index);
        if !is_fading
            && has_trajectory(self.prepared, self.index)
            && (unsolved == Unsolved::Wait || is_known())
            && let Outcome::Solved(kept) = world_trajectory(self.prepared, self.index, Watcher::NONE)?
            && let Some(problem) = self.timed_problem(time, &kept.points)
        {
            return kept.trajectory.solve_at(time, problem, &layer.settings, &never).map_err(fault);
        }
        let Targets { pins, handles } = goal;
        let problem = Problem { grid: &self.grid, shape: &self.shape(), pins, handles, settings: &layer.settings };
        let solver = Solver::build(&problem, &never).map_err(fault)?;
        solve_layer(&solver, &[], goal, std::iter::once(presence), &never).map_err(fault)
    }
}
