//! Warps finished frames: one plate is read while the previous one is warped and the one before that is written.
//!
//! In: a [`WarpJob`]. Out: files, [`WarpEvent`]s during the run, and a [`WarpSummary`]. The channels between the threads
//! have no buffer, so at most four plates are in memory, however long the sequence is.

mod at_rest;
mod default_mattes;
mod fill;
mod fronts;
mod headers;
mod job;
mod needed_memory;
mod plan;
mod read;
mod shared_meshes;
#[cfg(any(test, feature = "cli"))]
mod silhouette;
mod stage;
mod surface_maps;
mod whole_scene;
mod write;

pub use job::{PlateWarp, WarpDirection, WarpEvent, WarpJob, WarpReport, WarpSummary};
#[cfg(any(test, feature = "cli"))]
pub(crate) use silhouette::Silhouette;
pub use surface_maps::SurfaceMaps;

use crate::pipeline::PipelineError;
use crate::pipeline::run::resume::Todo;
use crate::pipeline::trajectories::solve_ahead::solve_before_frames;
use crate::plate::Warper;
use crate::raster;
use plan::Plan;
use read::Reader;
use stage::Stage;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::Instant;
use write::Writer;

/// Warps the requested frames.
///
/// `on_event` is called from several threads. `cancel` ends the work after the frames in flight.
///
/// # Errors
/// [`PipelineError`] if nothing can be warped at all; frames that fail individually are reported as events and counted.
pub fn warp_frames(
    job: &WarpJob,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(WarpEvent) + Sync),
) -> Result<WarpSummary, PipelineError> {
    let begun = Instant::now();
    let warper = raster::resampler(&job.device)?.map_or_else(Warper::default, Warper::on);
    let plan = Plan::of(job, &warper.device().unwrap_or_else(|| "CPU".into()))?;
    if let Some(name) = warper.device() {
        on_event(WarpEvent::Note { text: format!("{name} resamples colour") });
    }
    for text in plan.notes.iter().cloned() {
        on_event(WarpEvent::Note { text });
    }
    let Todo { frames, kept, redone, .. } = &plan.todo;
    redone.iter().cloned().for_each(|redone| on_event(WarpEvent::FrameRedone(redone)));
    let wanted = frames.len();
    on_event(WarpEvent::Started { frames: wanted, kept: *kept });
    if let PlateWarp::Shot(prepared) = &job.warp
        && wanted > 0
    {
        solve_before_frames(prepared, cancel);
    }
    let mut stage = Stage::of(job, &plan, warper);
    let mut writer = Writer::of(job, &plan);
    std::thread::scope(|scope| {
        let (loaded, loads) = sync_channel(0);
        let (warped, warps) = sync_channel(0);
        let reader = Reader { plan: &plan, cancel };
        scope.spawn(move || reader.run(&loaded));
        let writing = scope.spawn(|| writer.run(warps, on_event));
        stage.run(loads, &warped);
        drop(warped);
        // Propagates a panic in the writer.
        writing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    });
    let mut summary = writer.summary();
    (summary.kept, summary.redone) = (*kept, redone.len());
    summary.wall_secs = begun.elapsed().as_secs_f64();
    summary.is_cancelled = summary.warped + summary.failed < wanted && cancel.load(Ordering::Relaxed);
    on_event(WarpEvent::Finished(summary.clone()));
    Ok(summary)
}
