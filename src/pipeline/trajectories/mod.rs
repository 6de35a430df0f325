//! Provides the trajectories of layers with a temporal weight, which are solved over a range of frames instead of frame by frame.
//!
//! In: a [`PreparedShot`] and a layer. Out: its [`Trajectory`], solved once or read from its file. The range is fixed
//! by the shot, so a frame depends on the shot and its number alone.

pub(super) mod layer_timeline;
pub(super) mod solve_ahead;
pub(super) mod trajectory_files;
pub(super) mod trajectory_key;
pub(super) mod watched_points;
pub(super) mod watched_trajectory;
pub(super) mod world_timeline;

use crate::pipeline::evaluate::screen_layer::border_rests;
use crate::pipeline::{PinAnchor, PipelineError, PreparedShot};
use crate::shot::LayerSpace;
use crate::solve::{Cancel, Coupling, SolveError, Spread, Timeline, Trajectory};
use layer_timeline::{KNOTS_PER_FRAME, LayerTimeline, Watcher, first_knot};
use std::path::Path;
use std::sync::Arc;
use trajectory_files::{Keeping, TrajectoryFiles};
use watched_points::watched_points;
use watched_trajectory::{Facts, Outcome, StoredIn, WatchedTrajectory};
use world_timeline::WorldTimeline;

/// Speed that never counts as a jump, even if pins and model are at rest: one pixel per frame at 1080 lines, in frame heights.
const MIN_SPEED: f64 = 1.0 / 1080.0;

impl PreparedShot {
    /// Returns the same shot with trajectories stored in files beside the frames of `outputs` (path patterns). They are
    /// read from all of these places, and written to the first if `keeping` permits it.
    #[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands call it"))]
    #[must_use]
    pub(crate) fn keeping_trajectories<'a>(
        mut self,
        outputs: impl IntoIterator<Item = &'a Path>,
        keeping: Keeping,
    ) -> Self {
        self.trajectory_files = Some(TrajectoryFiles::beside(outputs, keeping));
        self
    }
}

/// Whether the frames of a layer are solved together.
pub(in crate::pipeline) fn has_trajectory(prepared: &PreparedShot, index: usize) -> bool {
    let layer = &prepared.shot.layers[index];
    let is_moved = !layer.pins.is_empty() || !layer.handles.is_empty();
    layer.settings.temporal > 0.0
        && is_moved
        && prepared.layer_inputs.loaded[index].is_none()
        // Layers with a resting border use compliant settings and a correction that depends on the pins of one frame.
        && !border_rests(&prepared.shot.source, layer)
}

/// Information for the user on a layer that is solved over time.
pub(in crate::pipeline) enum TimedNote {
    /// A sudden jump is spread over several frames, including this one.
    Spread(Spread),
    /// The reason why its frames are solved one by one nevertheless.
    Alone(Arc<str>),
    /// The frame lies outside the given range, over which the layer is solved.
    Outside([i32; 2]),
}

/// Returns the information on a layer in a frame.
pub(in crate::pipeline) fn note_at(prepared: &PreparedShot, index: usize, frame: i32) -> Option<TimedNote> {
    if !has_trajectory(prepared, index) {
        return None;
    }
    let range = prepared.shot.solve_range;
    match facts(prepared, index, Watcher::NONE).ok()? {
        Err(why) => Some(TimedNote::Alone(why)),
        Ok(_) if !(range[0]..=range[1]).contains(&frame) => Some(TimedNote::Outside(range)),
        Ok(facts) => {
            let holds = |spread: &Spread| (spread.frames[0]..=spread.frames[1]).contains(&f64::from(frame));
            facts.spreads.into_iter().find(holds).map(TimedNote::Spread)
        }
    }
}

/// Returns figures of a layer's trajectory, for screen and world layers, or the reason why there is none.
///
/// # Errors
/// As [`trajectory`].
pub(in crate::pipeline) fn facts(
    prepared: &PreparedShot,
    index: usize,
    watcher: Watcher,
) -> Result<Result<Facts, Arc<str>>, PipelineError> {
    Ok(match prepared.shot.layers[index].space {
        LayerSpace::Screen { .. } => trajectory(prepared, index, watcher)?.facts(),
        LayerSpace::World { .. } => world_trajectory(prepared, index, watcher)?.facts(),
    })
}

/// Returns the trajectory of a screen layer, from the cache, from its file, or solved.
///
/// # Errors
/// [`PipelineError::Solve`] if the watcher cancels it.
pub(in crate::pipeline) fn trajectory(
    prepared: &PreparedShot,
    index: usize,
    watcher: Watcher,
) -> Result<Outcome<2>, PipelineError> {
    let first = f64::from(prepared.shot.solve_range[0]);
    let made = prepared.cache.trajectories.of(index, || {
        let points = watched_points(prepared, index, first);
        let timeline = LayerTimeline { prepared, index, points: &points, watcher };
        let found = read_or_solve(prepared, index, || {
            solve_on_own_pool(&timeline, coupling(prepared, index, MIN_SPEED), watcher)
        });
        outcome(found, points)
    });
    made.map_err(|source| cancelled(prepared, index, source))
}

/// Returns the trajectory of a world layer.
///
/// # Errors
/// As [`trajectory`].
pub(in crate::pipeline) fn world_trajectory(
    prepared: &PreparedShot,
    index: usize,
    watcher: Watcher,
) -> Result<Outcome<3>, PipelineError> {
    let first = f64::from(prepared.shot.solve_range[0]);
    let made = prepared.cache.world_trajectories.of(index, || {
        let points = watched_points(prepared, index, first);
        let timeline = WorldTimeline { prepared, index, points: &points, watcher };
        let least_speed = MIN_SPEED * timeline.size(first);
        let found = read_or_solve(prepared, index, || {
            solve_on_own_pool(&timeline, coupling(prepared, index, least_speed), watcher)
        });
        outcome(found, points)
    });
    made.map_err(|source| cancelled(prepared, index, source))
}

fn cancelled(prepared: &PreparedShot, index: usize, source: SolveError) -> PipelineError {
    let frame = f64::from(prepared.shot.solve_range[0]);
    PipelineError::Solve { layer: prepared.shot.layers[index].name.clone(), frame, source }
}

/// Passes on cancellation as an error; all other outcomes, including failures, are cached.
fn outcome<const D: usize>(
    found: Result<Kept<D>, SolveError>,
    points: Vec<PinAnchor>,
) -> Result<Outcome<D>, SolveError> {
    match found {
        Ok(Kept { trajectory, file, is_read }) => {
            Ok(Outcome::Solved(Arc::new(WatchedTrajectory { trajectory, points, file, is_read })))
        }
        Err(SolveError::Cancelled) => Err(SolveError::Cancelled),
        Err(error) => Ok(Outcome::Failed(error.to_string().into())),
    }
}

fn coupling(prepared: &PreparedShot, index: usize, least_speed: f64) -> Coupling {
    let first = first_knot(prepared, index);
    let [from, to] = prepared.shot.solve_range.map(f64::from);
    let weight = prepared.shot.layers[index].settings.temporal;
    Coupling { first, last: first + to - from, knots_per_frame: KNOTS_PER_FRAME, weight, least_speed }
}

/// A trajectory and its file.
struct Kept<const D: usize> {
    trajectory: Trajectory<D>,
    file: StoredIn,
    is_read: bool,
}

/// Reads the trajectory of a layer from its file, or solves it and writes the file.
fn read_or_solve<const D: usize>(
    prepared: &PreparedShot,
    index: usize,
    solve: impl FnOnce() -> Result<Trajectory<D>, SolveError>,
) -> Result<Kept<D>, SolveError> {
    let Some(files) = &prepared.trajectory_files else {
        return Ok(Kept { trajectory: solve()?, file: Ok(None), is_read: false });
    };
    let key = prepared.trajectory_key(index);
    let read = files.read(&key).and_then(|(bytes, path)| Some((Trajectory::from_bytes(&bytes)?, path)));
    if let Some((trajectory, path)) = read {
        return Ok(Kept { trajectory, file: Ok(Some(path)), is_read: true });
    }
    let trajectory = solve()?;
    // Other runs can solve it again, so a frame does not fail for it.
    let file = files.write(&key, &trajectory.to_bytes()).map_err(|error| {
        tracing::warn!("a trajectory is not kept: {error}");
        error.to_string().into()
    });
    Ok(Kept { trajectory, file, is_read: false })
}

/// Solves on a separate thread pool. The caller may be a worker of a pool; if it waited there, it would take up other
/// tasks, some of which wait for this very trajectory.
fn solve_on_own_pool<const D: usize>(
    timeline: &(impl Timeline<D, Error = SolveError> + Sync),
    coupling: Coupling,
    watcher: Watcher,
) -> Result<Trajectory<D>, SolveError> {
    let solve = || Trajectory::solve(timeline, coupling, &Cancel::when(&|| (watcher.is_cancelled)()));
    std::thread::scope(|scope| {
        let own = scope.spawn(|| match rayon::ThreadPoolBuilder::new().build() {
            Ok(pool) => pool.install(solve),
            Err(_) => solve(),
        });
        own.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })
}
