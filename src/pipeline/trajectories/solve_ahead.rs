//! Solves the layers of a shot over time before any frame is made, so that render farms and restarted runs find the trajectories.
//!
//! In: a [`PreparedShot`] whose trajectories are stored in files. Out: those files, and [`BakeEvent`]s during the run.

use super::layer_timeline::Watcher;
use super::watched_trajectory::Facts;
use super::{facts, has_trajectory};
use crate::pipeline::{PipelineError, PreparedShot};
use crate::solve::{SolveError, Spread};
use serde::{Serialize, Serializer};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Number of progress events per layer.
const PROGRESS_STEPS: usize = 100;

/// An event of a running bake.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub(crate) enum BakeEvent {
    /// Baking starts.
    Started {
        /// Number of layers solved over time.
        layers: usize,
        /// First and last frame of the range.
        solve_range: [i32; 2],
    },
    /// A note about the shot as a whole.
    Note {
        /// The note.
        text: String,
    },
    /// Progress of one layer.
    Progress {
        /// Layer name.
        layer: String,
        /// Number of completed steps.
        done: usize,
        /// Total number of steps.
        of: usize,
    },
    /// The trajectory of a layer has been solved or found on disk.
    LayerDone(BakedLayer),
    /// A layer could not be solved over time, or its trajectory could not be written.
    LayerFailed {
        /// Layer name.
        layer: String,
        /// The cause.
        error: String,
    },
    /// All layers have been attempted.
    Finished(BakeSummary),
}

/// Report of one layer.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BakedLayer {
    /// Layer name.
    pub layer: String,
    /// The file that stores the trajectory; `None` if the shot stores no trajectories.
    #[serde(serialize_with = "lossy")]
    pub path: Option<PathBuf>,
    /// Whether the trajectory existed already, from the same shot and scene.
    pub is_kept: bool,
    /// Number of knots: times solved together with their neighbours.
    pub knots: usize,
    /// Frames over which a sudden jump is spread.
    pub spreads: Vec<Spread>,
    /// Wall time, seconds.
    pub wall_secs: f64,
}

/// Summary of a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct BakeSummary {
    /// Number of layers solved by this run.
    pub solved: usize,
    /// Number of layers whose trajectories existed.
    pub kept: usize,
    /// Number of layers that could not be solved or stored.
    pub failed: usize,
    /// Whether the bake was cancelled.
    pub is_cancelled: bool,
    /// Wall time, seconds.
    pub wall_secs: f64,
}

fn lossy<S: Serializer>(path: &Option<PathBuf>, to: S) -> Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(to)
}

/// Solves every layer with a temporal weight over the shot's range, unless its trajectory exists. `on_event` is called from
/// several threads; `cancel` ends the bake within milliseconds, and finished trajectories are kept.
pub(crate) fn solve_ahead(
    prepared: &PreparedShot,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(BakeEvent) + Sync),
) -> BakeSummary {
    let begun = Instant::now();
    let layers: Vec<usize> = (0..prepared.shot.layers.len()).filter(|&index| has_trajectory(prepared, index)).collect();
    prepared.notes.iter().for_each(|text| on_event(BakeEvent::Note { text: text.clone() }));
    on_event(BakeEvent::Started { layers: layers.len(), solve_range: prepared.shot.solve_range });
    let next = AtomicUsize::new(0);
    let summary = Mutex::new(BakeSummary::default());
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(layers.len());
    std::thread::scope(|scope| {
        let work = || {
            while let Some(&index) = layers.get(next.fetch_add(1, Ordering::Relaxed)) {
                let outcome = solve_layer(prepared, index, (cancel, on_event));
                let mut summary = summary.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                match outcome {
                    Ended::Solved => summary.solved += 1,
                    Ended::Kept => summary.kept += 1,
                    Ended::Failed => summary.failed += 1,
                    Ended::Cancelled => summary.is_cancelled = true,
                }
            }
        };
        (0..threads).for_each(|_| _ = scope.spawn(work));
    });
    let summary = summary.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let summary = BakeSummary { wall_secs: begun.elapsed().as_secs_f64(), ..summary };
    on_event(BakeEvent::Finished(summary));
    summary
}

/// Solves all layers over time before the first frame needs them; a cancelled run solves fewer.
pub(crate) fn solve_before_frames(prepared: &PreparedShot, cancel: &AtomicBool) {
    let has_any = (0..prepared.shot.layers.len()).any(|index| has_trajectory(prepared, index));
    if has_any {
        let BakeSummary { solved, kept, wall_secs, .. } = solve_ahead(prepared, cancel, &|_| ());
        tracing::info!("layers over time: {solved} solved, {kept} read in {wall_secs:.1} s");
    }
}

/// The outcome of one layer.
enum Ended {
    Solved,
    Kept,
    Failed,
    Cancelled,
}

fn solve_layer(
    prepared: &PreparedShot,
    index: usize,
    (cancel, on_event): (&AtomicBool, &(dyn Fn(BakeEvent) + Sync)),
) -> Ended {
    let begun = Instant::now();
    let layer = &prepared.shot.layers[index].name;
    let reported = AtomicUsize::new(0);
    let progress = |done: usize, of: usize| {
        let step = PROGRESS_STEPS * done / of.max(1);
        if reported.fetch_max(step, Ordering::Relaxed) < step {
            on_event(BakeEvent::Progress { layer: layer.clone(), done, of });
        }
    };
    let is_cancelled = || cancel.load(Ordering::Relaxed);
    let failed = |error: String| {
        on_event(BakeEvent::LayerFailed { layer: layer.clone(), error });
        Ended::Failed
    };
    match facts(prepared, index, Watcher { is_cancelled: &is_cancelled, progress: &progress }) {
        Ok(Ok(Facts { knots, spreads, file, is_read: is_kept })) => {
            let path = match file {
                Ok(path) => path,
                Err(error) => return failed(format!("its trajectory could not be written: {error}")),
            };
            let wall_secs = begun.elapsed().as_secs_f64();
            on_event(BakeEvent::LayerDone(BakedLayer {
                layer: layer.clone(),
                path,
                is_kept,
                knots,
                spreads,
                wall_secs,
            }));
            if is_kept { Ended::Kept } else { Ended::Solved }
        }
        Ok(Err(error)) => failed(error.to_string()),
        Err(PipelineError::Solve { source: SolveError::Cancelled, .. }) => Ended::Cancelled,
        Err(error) => failed(error.to_string()),
    }
}
