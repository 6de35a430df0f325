//! Runs all stages for a shot over a range of frames: concurrent threads, progress events, cancellation, and errors per frame.
//!
//! In: a [`crate::shot::Shot`] and [`RenderOptions`]. Out: files, [`Event`]s during the run, and a [`Summary`]. Frame N depends
//! on the shot and on N alone: the caches that frames share hold only values that recomputation would reproduce bit for bit.

mod prepare;

mod evaluate;
mod trajectories;

mod draw;

mod branches;
mod pictures;
mod plates;
mod run;

mod interchange;
mod viewer;

mod error;

use crate::raster;
use draw::FramesToDraw;
use run::render_plan::RenderPlan;
use run::renderer::Renderer;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::sync_channel;

pub(crate) use branches::{BranchPart, BranchView, Exposure, SampleInMotion, fields_of, parts_of_file};
#[cfg(feature = "cli")]
pub(crate) use draw::frame_checks::FrameChecks;
pub(crate) use draw::jerk::JerkMeter;
pub(crate) use draw::passes::{PassPlan, plan_passes};
pub use draw::report::report;
pub(crate) use draw::report::warnings_of_layer;
pub use error::PipelineError;
pub(crate) use evaluate::screen_layer::{LayerSolver, LayerTask};
pub use evaluate::time_sample::{LayerState, TimeSample, WorldSolution};
pub(crate) use evaluate::time_sample::{PinState, ScenePin};
pub(crate) use evaluate::topology::branching_key;
#[cfg(any(test, feature = "cli"))]
pub(crate) use interchange::bake::BakeTimes;
pub use interchange::lattice_tracks::lattices;
#[cfg(any(test, feature = "cli"))]
pub(crate) use interchange::layer_problem::layer_problem;
#[cfg(any(test, feature = "cli"))]
pub(crate) use interchange::registration::layer_shape;
pub use interchange::registration::{Registration, picture_shape, register};
#[cfg(any(test, feature = "cli"))]
pub(crate) use plates::Silhouette;
pub use plates::{PlateWarp, SurfaceMaps, WarpDirection, WarpEvent, WarpJob, WarpReport, WarpSummary, warp_frames};
pub use prepare::anchors::PinAnchor;
pub(crate) use prepare::anchors::RestPoint;
pub(crate) use prepare::branch_lattices::lattices_of_file;
pub use prepare::layer_assignment::LayerAssignment;
pub use prepare::prepared_shot::PreparedShot;
#[cfg(feature = "cli")]
pub(crate) use run::contents::digest_with;
pub use run::events::{Event, FrameReport, Redone, Summary};
pub(crate) use run::events::{Jerk, LayerNote, LayerReport};
pub use run::options::Existing;
pub use run::options::RenderOptions;
#[cfg(any(test, feature = "cli", feature = "ofx"))]
pub(crate) use run::output::input_files;
pub use run::pause::Pause;
#[cfg(feature = "cli")]
pub(crate) use run::resume::{Todo, refuse_existing};
#[cfg(feature = "cli")]
pub(crate) use run::sequence_report::{LayerPeaks, Peak, SequenceReport};
#[cfg(feature = "cli")]
pub(crate) use trajectories::solve_ahead::solve_before_frames;
#[cfg(any(test, feature = "cli"))]
pub(crate) use trajectories::solve_ahead::{BakeEvent, BakeSummary, BakedLayer, solve_ahead};
#[cfg(any(test, feature = "cli"))]
pub(crate) use trajectories::trajectory_files::Keeping;
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::brush_point::{BrushPoint, PaintedPlace};
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::draft::Draft;
#[cfg(feature = "editor")]
pub(crate) use viewer::held_points::PinTurn;
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::layer_marks::{LayerMarks, PinMark};
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::layer_marks::{layer_marks, resting_marks};
#[cfg(feature = "editor")]
pub(crate) use viewer::layer_offers::LayerOffer;
#[cfg(feature = "editor")]
pub(crate) use viewer::layer_shift::LayerShift;
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(crate) use viewer::new_shot::{NewShot, new_shot, path_between};
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::open_shot::{OpenShot, Rework};
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(crate) use viewer::picked_point::PickedPoint;
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::problem_shot::{ProblemShot, problem_shot};
#[cfg(any(test, feature = "editor"))]
pub(crate) use viewer::stiff_triangles::StiffTriangle;
#[cfg(any(test, feature = "editor", feature = "python"))]
pub(crate) use viewer::still::Device;
#[cfg(feature = "editor")]
pub(crate) use viewer::warped_still::WarpedStill;

/// Number of drawn frames that may wait to be written.
const QUEUED_FRAMES: usize = 1;

/// Renders the requested frames on the requested device.
///
/// ```text
/// once per shot   Shot ─prepare─▶ PreparedShot: scene, layer assignment, pin anchors, camera, clip
/// once per time   PreparedShot ─evaluate─▶ TimeSample: pose ─▶ world layers ─▶ projection ─▶ screen layers
/// once per layer  shape, pins ─factor─▶ Solver ─solve─▶ lattice         (the same for screen and world layers)
/// once per frame  TimeSamples ─geometry thread─▶ passes ─draw─▶ Frame ─write─▶ files
/// ```
///
/// `on_event` is called from several threads. `cancel` ends the render after the frames in flight.
///
/// # Errors
/// [`PipelineError`] if nothing can be rendered at all; frames that fail individually are reported as events and counted.
pub fn render(
    prepared: &PreparedShot,
    options: &RenderOptions,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(Event) + Sync),
) -> Result<Summary, PipelineError> {
    let plan = RenderPlan::new(prepared, options)?;
    if let Some(gallery) = &prepared.gallery {
        return run_plan(&plan, Renderer::Pictures(gallery), (cancel, on_event));
    }
    let (mut device, fallback) = raster::open(&options.device, &prepared.scene)?;
    if let Some(reason) = fallback {
        on_event(Event::Note { text: format!("the CPU draws: {reason}") });
    }
    run_plan(&plan, Renderer::Scene(device.as_mut()), (cancel, on_event))
}

/// Renders as [`render`] does, on a device that the caller opened for the prepared shot; `options.device` is ignored.
///
/// # Errors
/// As [`render`].
#[cfg(test)]
pub(crate) fn render_on(
    device: &mut dyn raster::Raster,
    prepared: &PreparedShot,
    options: &RenderOptions,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(Event) + Sync),
) -> Result<Summary, PipelineError> {
    run_plan(&RenderPlan::new(prepared, options)?, Renderer::Scene(device), (cancel, on_event))
}

/// Runs the stages of a planned render. While this thread draws a frame, another builds the geometry of the next, and a third writes
/// the previous one; the channels between them are short, so memory does not grow with the length of the sequence.
fn run_plan(
    plan: &RenderPlan,
    renderer: Renderer,
    (cancel, on_event): (&AtomicBool, &(dyn Fn(Event) + Sync)),
) -> Result<Summary, PipelineError> {
    let todo = plan.todo(renderer.class())?;
    plan.announce(&todo, &renderer, on_event);
    if !todo.frames.is_empty() {
        trajectories::solve_ahead::solve_before_frames(plan.prepared, cancel);
    }
    let mut writer = plan.writer(renderer.class());
    let raster_ms = std::thread::scope(|scope| {
        let (drawn, drawns) = sync_channel(QUEUED_FRAMES);
        let writing = scope.spawn(|| writer.run(drawns, on_event));
        let frames = FramesToDraw { frames: &todo.frames, options: plan.options, cancel };
        let raster_ms = renderer.draw(plan.prepared, frames, drawn);
        // Propagates a panic in the writer.
        writing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        raster_ms
    });
    let summary = plan.finished(&todo, Summary { raster_ms, ..writer.summary() }, cancel);
    on_event(Event::Finished(summary.clone()));
    Ok(summary)
}
