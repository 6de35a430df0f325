//! Evaluates screen layers at one time, from their trajectories or by separate solves.
//!
//! In: a projected [`TimeSample`] and a layer. Out: the layer's state.

use super::layer_pins::fade;
use super::screen_layer;
use crate::pipeline::trajectories::layer_timeline::{LayerTimeline, Watcher};
use crate::pipeline::trajectories::watched_trajectory::{Outcome, WatchedTrajectory};
use crate::pipeline::trajectories::{has_trajectory, trajectory};
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample};
use crate::shot::BoxRule;
use crate::solve::{Cancel, Problem, Solver, Targets};

/// Returns the state of a screen layer, from its trajectory if it has one, and otherwise solved for this time alone.
pub(in crate::pipeline) fn solve(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
    bounds: BoxRule,
) -> Result<LayerState, PipelineError> {
    if has_trajectory(prepared, index)
        && let Outcome::Solved(kept) = trajectory(prepared, index, Watcher::NONE)?
    {
        return solve_on(prepared, sample, index, &kept);
    }
    screen_layer::solve(prepared, sample, index, bounds)
}

fn solve_on(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
    kept: &WatchedTrajectory<2>,
) -> Result<LayerState, PipelineError> {
    let layer = &prepared.shot.layers[index];
    let timeline = LayerTimeline { prepared, index, points: &kept.points, watcher: Watcher::NONE };
    let Some((mut solver, targets)) = timeline.unfactored(sample) else { return Ok(LayerState::default()) };
    let Some(problem) = timeline.problem(sample, &mut solver, &targets) else { return Ok(LayerState::default()) };
    let (states, goal) = solver.targets(layer, &targets);
    let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame: sample.frame, source };
    let shape = problem.shape.clone();
    let solved = kept.trajectory.solve_at(sample.frame, problem, &layer.settings, &Cancel::never());
    let mut solution = solved.map_err(fault)?;
    let presence = states.iter().map(|pin| pin.presence).fold(0.0, f64::max);
    let starts = solver.starts().to_vec();
    if goal.handles.is_empty() && presence < 1.0 {
        let Targets { pins, handles } = &goal;
        let (grid, settings) = (solver.grid(), &layer.settings);
        let solver = Solver::new(&Problem { grid, shape: &shape, pins, handles, settings }).map_err(fault)?;
        fade(&mut solution, (&solver, pins), presence);
    }
    Ok(LayerState { solution: Some(solution), pins: states, starts, is_on_trajectory: true, ..LayerState::default() })
}
