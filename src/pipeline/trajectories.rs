//! Screen layers with a temporal weight: solved over a range of frames instead of frame by frame.
//!
//! In: a [`PreparedShot`], a layer. Out: its [`Trajectory`], solved once or read from its file; the layer's state at any time. The range is
//! the shot's own, so a frame depends on the shot and its number alone.

use super::layer_pins::fade;
use super::layer_timeline::{LayerTimeline, Watcher};
use super::screen_layer::border_rests;
use super::trajectory_files::{Keeping, TrajectoryFiles};
use super::watched_points::watched_points;
use super::watched_trajectory::{Outcome, WatchedTrajectory};
use super::{LayerState, PipelineError, PreparedShot, TimeSample, screen_layer};
use crate::shot::{BoxRule, LayerSpace};
use crate::solve::{Cancel, Coupling, Guard, Problem, Settings, SolveError, Solver, Spread, Targets, Trajectory};
use std::path::Path;
use std::sync::Arc;

/// Knots a frame.
const KNOTS_PER_FRAME: u32 = 2;

/// A speed that needs no reason: a pixel of 1080 lines a frame, in frame heights.
const LEAST_SPEED: f64 = 1.0 / 1080.0;

impl PreparedShot {
    /// The same, with trajectories kept in files beside the frames of `outputs` (path patterns): read from all of these places, and
    /// where they may be written, written to the first.
    #[must_use]
    pub fn keeping_trajectories<'a>(mut self, outputs: impl IntoIterator<Item = &'a Path>, keeping: Keeping) -> Self {
        self.trajectory_files = Some(TrajectoryFiles::beside(outputs, keeping));
        self
    }
}

/// Whether the frames of a layer are solved together.
pub(super) fn has_trajectory(prepared: &PreparedShot, index: usize) -> bool {
    let layer = &prepared.shot.layers[index];
    let is_moved = !layer.pins.is_empty() || !layer.handles.is_empty();
    let is_screen = matches!(layer.space, LayerSpace::Screen { .. });
    let Settings { temporal, guard, .. } = layer.settings;
    // A layer on twos jumps because it is asked to.
    temporal > 0.0
        && guard == Guard::Report
        && layer.step <= 1
        && is_moved
        && is_screen
        && prepared.layer_inputs.loaded[index].is_none()
        // Its lattice is compliant, and what is left depends on this frame's pins.
        && !border_rests(&prepared.shot.source, layer)
}

/// The state of a layer of the screen: from its trajectory, or of this time alone.
pub(super) fn solve(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
    bounds: BoxRule,
) -> Result<LayerState, PipelineError> {
    if has_trajectory(prepared, index)
        && let Outcome::Solved(kept) = trajectory(prepared, index, Watcher::PATIENT)?
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
    let timeline = LayerTimeline { prepared, index, points: &kept.points, watcher: Watcher::PATIENT };
    let Some((solver, targets)) = timeline.unfactored(sample) else { return Ok(LayerState::default()) };
    let (states, goal) = solver.targets(layer, &targets);
    let Some(problem) = timeline.problem(sample, &solver, &targets) else { return Ok(LayerState::default()) };
    let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame: sample.frame, source };
    let shape = problem.shape.clone();
    let solved = kept.trajectory.solve_at(sample.frame, problem, &layer.settings, &Cancel::never());
    let mut solution = solved.map_err(fault)?;
    let presence = states.iter().map(|pin| pin.presence).fold(0.0, f64::max);
    if goal.handles.is_empty() && presence < 1.0 {
        let Targets { pins, handles } = &goal;
        let (grid, settings) = (solver.grid(), &layer.settings);
        let solver = Solver::new(&Problem { grid, shape: &shape, pins, handles, settings }).map_err(fault)?;
        fade(&mut solution, (&solver, pins), presence);
    }
    Ok(LayerState { solution: Some(solution), pins: states, ..LayerState::default() })
}

/// What the user should know of a layer that is solved over time.
pub(super) enum Told {
    /// A snap is spread over the frame.
    Spread(Spread),
    /// Why its frames are solved alone all the same.
    Alone(Arc<str>),
}

/// What is to be told of a layer in a frame.
pub(super) fn told_at(prepared: &PreparedShot, index: usize, frame: i32) -> Option<Told> {
    if !has_trajectory(prepared, index) {
        return None;
    }
    match trajectory(prepared, index, Watcher::PATIENT).ok()? {
        Outcome::Failed(why) => Some(Told::Alone(why)),
        Outcome::Solved(kept) => {
            let holds = |spread: &&Spread| (spread.frames[0]..=spread.frames[1]).contains(&f64::from(frame));
            kept.trajectory.spreads().iter().find(holds).copied().map(Told::Spread)
        }
    }
}

/// The trajectory of a layer: known, read, or solved.
///
/// # Errors
/// [`PipelineError::Solve`] where the watcher no longer wants it.
pub(super) fn trajectory(prepared: &PreparedShot, index: usize, watcher: Watcher) -> Result<Outcome<2>, PipelineError> {
    prepared.cache.trajectories.of(index, || {
        let points = watched_points(prepared, index, f64::from(prepared.shot.solve_range[0]));
        let solve =
            || solve_apart(&LayerTimeline { prepared, index, points: &points, watcher }, coupling(prepared, index));
        match kept_or(prepared, index, solve) {
            Ok(Kept { trajectory, file, is_read }) => {
                Ok(Outcome::Solved(Arc::new(WatchedTrajectory { trajectory, points, file, is_read })))
            }
            Err(source @ SolveError::Cancelled) => {
                let (layer, frame) =
                    (prepared.shot.layers[index].name.clone(), f64::from(prepared.shot.solve_range[0]));
                Err(PipelineError::Solve { layer, frame, source })
            }
            Err(error) => Ok(Outcome::Failed(error.to_string().into())),
        }
    })
}

fn coupling(prepared: &PreparedShot, index: usize) -> Coupling {
    let [first, last] = prepared.shot.solve_range.map(f64::from);
    let weight = prepared.shot.layers[index].settings.temporal;
    Coupling { first, last, knots_per_frame: KNOTS_PER_FRAME, weight, least_speed: LEAST_SPEED }
}

/// A trajectory and its file.
struct Kept<const D: usize> {
    trajectory: Trajectory<D>,
    file: Option<std::path::PathBuf>,
    is_read: bool,
}

/// The trajectory of a layer from its file, or else solved and written there.
fn kept_or<const D: usize>(
    prepared: &PreparedShot,
    index: usize,
    solve: impl FnOnce() -> Result<Trajectory<D>, SolveError>,
) -> Result<Kept<D>, SolveError> {
    let Some(files) = &prepared.trajectory_files else {
        return Ok(Kept { trajectory: solve()?, file: None, is_read: false });
    };
    let key = prepared.trajectory_key(index);
    let read = files.read(&key).and_then(|(bytes, path)| Some((Trajectory::from_bytes(&bytes)?, path)));
    if let Some((trajectory, path)) = read {
        return Ok(Kept { trajectory, file: Some(path), is_read: true });
    }
    let trajectory = solve()?;
    let file = files.write(&key, &trajectory.to_bytes());
    Ok(Kept { trajectory, file, is_read: false })
}

/// Solves on threads of its own. The caller may be one of a pool: waiting there it would take up other work, some of which waits for
/// this very trajectory.
fn solve_apart(timeline: &LayerTimeline, coupling: Coupling) -> Result<Trajectory<2>, SolveError> {
    let solve = || Trajectory::solve(timeline, coupling, &Cancel::when(&|| (timeline.watcher.is_cancelled)()));
    std::thread::scope(|scope| {
        let own = scope.spawn(|| match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(solve),
            Err(_) => solve(),
        });
        own.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
