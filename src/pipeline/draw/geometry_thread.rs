//! Geometry thread of a render: poses, solves, and builds the geometry of every pass.
//!
//! In: frame numbers. Out: a [`FrameJob`] for each frame, whose passes are built while the frame is being drawn, several times of the
//! exposure at once.

use super::overlay;
use super::report::report;
use crate::image::CameraMatrices;
use crate::pipeline::evaluate::camera_cuts::{exposure_time, take_at};
use crate::pipeline::prepare::lighting;
use crate::pipeline::{
    FrameReport, JerkMeter, PassPlan, PipelineError, PreparedShot, RenderOptions, TimeSample, plan_passes,
};
use crate::raster::geometry::{self, Assembly, IsCancelled, KeptParts, PartWarp, assemble_keeping};
use crate::raster::{ChannelGroup, Geometry, PassRole};
use glam::Vec2;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

/// Least number of finished passes that may wait to be drawn.
const MIN_QUEUED_PASSES: usize = 2;

/// Number of triangles of all times that are built at once. Larger scenes are built time by time, each when the one before is drawn.
const MANY_TRIANGLES: usize = 500_000;

/// Width of lines in frame heights: two pixels at 1080 lines. Smaller frames draw lines at least one pixel wide.
const LINE_WIDTH: f64 = 1.0 / 540.0;

/// One frame to draw.
pub(in crate::pipeline) struct FrameJob {
    /// Frame number.
    pub(in crate::pipeline) frame: i32,
    /// All passes in the order of the plan, repeated for every tile; or the error that ended the frame.
    pub(in crate::pipeline) passes: Receiver<Result<BuiltPass, PipelineError>>,
    /// The results of solving, for the frame's file and the user; sent after the last pass.
    pub(in crate::pipeline) facts: Receiver<FrameFacts>,
}

/// The results of solving a frame.
pub(in crate::pipeline) struct FrameFacts {
    pub(in crate::pipeline) report: FrameReport,
    pub(in crate::pipeline) picture: Option<overlay::Picture>,
    pub(in crate::pipeline) camera: CameraMatrices,
}

/// One pass to draw.
pub(in crate::pipeline) struct BuiltPass {
    pub(in crate::pipeline) geometry: Arc<Geometry>,
    pub(in crate::pipeline) jitter_px: Vec2,
    pub(in crate::pipeline) role: PassRole,
}

/// Builds the jobs of a render.
pub(in crate::pipeline) struct GeometryThread<'a> {
    pub(in crate::pipeline) prepared: &'a PreparedShot,
    pub(in crate::pipeline) tile_count: usize,
    pub(in crate::pipeline) options: &'a RenderOptions,
    pub(in crate::pipeline) cancel: &'a AtomicBool,
    pub(in crate::pipeline) jerk: JerkMeter,
}

impl GeometryThread<'_> {
    /// Builds the jobs of all frames; stops early if cancelled or if drawing has ended.
    pub(in crate::pipeline) fn run(&mut self, frames: &[i32], jobs: &SyncSender<FrameJob>) {
        for &frame in frames {
            let (pass, passes) = sync_channel(self.queued_passes());
            let (fact, facts) = sync_channel(1);
            let is_over = self.cancel.load(Ordering::Relaxed) || jobs.send(FrameJob { frame, passes, facts }).is_err();
            if is_over {
                return;
            }
            // The receiver is gone if the raster failed; the next frame may succeed.
            if let Err(error) = self.frame(frame, (&pass, &fact)) {
                let _ = pass.send(Err(error));
            }
        }
    }

    fn frame(
        &mut self,
        frame: i32,
        (pass, fact): (&SyncSender<Result<BuiltPass, PipelineError>>, &SyncSender<FrameFacts>),
    ) -> Result<(), PipelineError> {
        let begun = Instant::now();
        let shot = &self.prepared.shot;
        let middle = self.prepared.mid_exposure(frame)?;
        let mut facts = facts(self.prepared, (frame, &middle), self.options.has_overlay, &mut self.jerk);
        let mut busy = begun.elapsed();
        let plan = plan_passes(shot.samples, shot.shutter);
        let has_motion = shot.output.channels.contains(&ChannelGroup::Motion);
        let passes: Vec<PassPlan> = (0..self.tile_count).flat_map(|_| plan.iter().copied()).collect();
        let runs: Vec<&[PassPlan]> = passes.chunk_by(|a, b| a.time_frames == b.time_frames).collect();
        let build = |run: &&[PassPlan]| {
            let needs_motion = has_motion && run.iter().any(|planned| planned.role != PassRole::Beauty);
            let time = exposure_time(self.prepared, frame, f64::from(frame) + run[0].time_frames);
            self.geometry(time, needs_motion)
        };
        for times in runs.chunks(self.parallel_times()) {
            self.options.pause.wait();
            let begun = Instant::now();
            let built: Vec<Result<Geometry, PipelineError>> = times.par_iter().map(build).collect();
            busy += begun.elapsed();
            for (run, geometry) in times.iter().zip(built) {
                let geometry = Arc::new(geometry?);
                for planned in *run {
                    let geometry = Arc::clone(&geometry);
                    let built = BuiltPass { geometry, jitter_px: planned.jitter_px, role: planned.role };
                    if pass.send(Ok(built)).is_err() {
                        // The raster failed and reports the cause itself.
                        return Ok(());
                    }
                }
            }
        }
        facts.report.geometry_ms = busy.as_secs_f64() * 1e3;
        let _ = fact.send(facts);
        Ok(())
    }

    /// Returns the number of times whose geometry is built at once.
    fn parallel_times(&self) -> usize {
        (MANY_TRIANGLES / self.triangle_count().max(1)).clamp(1, rayon::current_num_threads())
    }

    /// Returns the number of passes of a frame that may wait, so that the next times are built while these are drawn.
    fn queued_passes(&self) -> usize {
        if self.triangle_count() > MANY_TRIANGLES { 0 } else { self.parallel_times().max(MIN_QUEUED_PASSES) }
    }

    fn triangle_count(&self) -> usize {
        let primitives = self.prepared.scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
        primitives.map(|primitive| primitive.triangles.len()).sum()
    }

    /// Builds the geometry of one time, including positions in the neighbouring frames if motion is wanted. No motion leads across a
    /// cut of the camera.
    fn geometry(&self, frame: f64, has_motion: bool) -> Result<Geometry, PipelineError> {
        let prepared = self.prepared;
        let now = prepared.sample_at(frame)?;
        let take = take_at(prepared, frame);
        let beside = |time: f64| {
            if take_at(prepared, time) == take { prepared.sample_at(time) } else { Ok(Arc::clone(&now)) }
        };
        let around = if has_motion { Some([beside(frame + 1.0)?, beside(frame - 1.0)?]) } else { None };
        Ok(geometry_of(prepared, &now, around.as_ref().map(|samples| samples.each_ref().map(|sample| &**sample))))
    }
}

/// What the geometry of a solved time is built from.
struct GeometryInputs<'a> {
    now: &'a TimeSample,
    /// The samples one frame later and one earlier, if motion is wanted.
    around: Option<[&'a TimeSample; 2]>,
    /// Warps that edges are split for, if not those of `now`.
    split_for: Option<&'a [PartWarp<'a>]>,
    /// Parts that have been built for this time before.
    kept: &'a KeptParts,
}

/// Builds the geometry of a solved time; `around`: the samples one frame later and one earlier, if motion is wanted.
pub(in crate::pipeline) fn geometry_of(
    prepared: &PreparedShot,
    now: &TimeSample,
    around: Option<[&TimeSample; 2]>,
) -> Geometry {
    let inputs = GeometryInputs { now, around, split_for: None, kept: &KeptParts::default() };
    built(prepared, inputs, &|| false).unwrap_or_default()
}

/// Builds the geometry of one time with its motion to another, and edges split for the warps of `curved`, one of the two:
/// seen from either side, the same points of the surface move.
pub(in crate::pipeline) fn geometry_between(
    prepared: &PreparedShot,
    [now, other]: [&TimeSample; 2],
    curved: &TimeSample,
) -> Geometry {
    let warps = curved.warps(&prepared.assignment, |_| true);
    let inputs = GeometryInputs { now, around: Some([other; 2]), split_for: Some(&warps), kept: &KeptParts::default() };
    built(prepared, inputs, &|| false).unwrap_or_default()
}

/// Builds the geometry of a solved time without motion, with parts that have been built before. `None` if it was cancelled.
#[cfg(any(test, feature = "editor"))]
pub(in crate::pipeline) fn geometry_keeping(
    prepared: &PreparedShot,
    now: &TimeSample,
    kept: &KeptParts,
    is_cancelled: &IsCancelled,
) -> Option<Geometry> {
    built(prepared, GeometryInputs { now, around: None, split_for: None, kept }, is_cancelled)
}

fn built(prepared: &PreparedShot, inputs: GeometryInputs, is_cancelled: &IsCancelled) -> Option<Geometry> {
    let GeometryInputs { now, around, split_for, kept } = inputs;
    let warps = now.warps(&prepared.assignment, |_| true);
    let around_warps = around.map(|samples| samples.map(|sample| sample.warps(&prepared.assignment, |_| true)));
    let neighbours = around
        .zip(around_warps.as_ref())
        .map(|(samples, warps)| [view_of(samples[0], &warps[0]), view_of(samples[1], &warps[1])]);
    let assembly = Assembly {
        scene: &prepared.scene,
        now: view_of(now, &warps),
        neighbours,
        split_for,
        submeshes: &prepared.draw_inputs.submeshes,
        lights: &lighting::lights(&prepared.shot, &now.pose, &prepared.draw_inputs.rig),
        environment: lighting::environment(&prepared.shot, &now.pose),
        line_width: LINE_WIDTH.max(1.0 / f64::from(prepared.shot.size.height)),
    };
    let mut geometry = assemble_keeping(&assembly, kept, is_cancelled)?;
    geometry
        .draws
        .retain(|draw| prepared.draw_inputs.hidden_layers.iter().all(|&layer| draw.layer_id != layer as u32 + 1));
    Some(geometry)
}

/// Collects the report, overlay and camera of a solved frame.
pub(in crate::pipeline) fn facts(
    prepared: &PreparedShot,
    (frame, middle): (i32, &TimeSample),
    has_overlay: bool,
    jerk: &mut JerkMeter,
) -> FrameFacts {
    let mut report = report(prepared, frame, middle);
    jerk.watch(prepared, middle, &mut report);
    FrameFacts {
        report,
        picture: has_overlay.then(|| overlay::Picture::of(prepared, middle)),
        camera: CameraMatrices {
            camera_from_scene: middle.camera.view_from_scene(),
            screen_from_scene: middle.camera.screen_from_scene(),
        },
    }
}

/// Converts a sample to the input of the geometry stage.
fn view_of<'a>(sample: &'a TimeSample, warps: &'a [PartWarp<'a>]) -> geometry::PosedScene<'a> {
    geometry::PosedScene { pose: &sample.pose, camera: &sample.camera, warps }
}
