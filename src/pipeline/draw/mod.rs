//! Second stage of a render: draws jobs, tile by tile.
//!
//! In: [`FrameJob`]s. Out: [`Drawn`] frames, cropped to the covered pixels.

#[cfg(feature = "cli")]
pub(super) mod frame_checks;
pub(super) mod geometry_thread;
pub(super) mod jerk;
pub(super) mod overlaps;
pub(super) mod overlay;
pub(super) mod overlay_branches;
pub(super) mod overlay_legend;
pub(super) mod passes;
pub(super) mod report;
pub(super) mod shared_cells;

use crate::image::Frame;
use crate::pipeline::run::write::Drawn;
use crate::pipeline::{JerkMeter, PassPlan, Pause, PipelineError, PreparedShot, RenderOptions, plan_passes};
use crate::raster::{Pass, PassRole, Raster, Target};
use crate::space::{FrameWindow, PixelRect};
use geometry_thread::{BuiltPass, FrameFacts, FrameJob, GeometryThread};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

/// Maximum side of a tile in pixels, even if the device supports larger ones; this bounds its memory.
const MAX_TILE_SIDE: u32 = 8192;

/// Number of frames whose geometry may wait to be drawn.
const QUEUED_JOBS: usize = 1;

/// Splits a window into tiles that the device can draw.
pub(in crate::pipeline) fn tiles(window: PixelRect, max_side: u32) -> Vec<PixelRect> {
    window.tiles(max_side.min(MAX_TILE_SIDE))
}

/// Draws the tiles of a window of a display window, and joins them to one frame.
pub(in crate::pipeline) fn draw_tiles(
    FrameWindow { frame, window }: FrameWindow,
    tiles: &[PixelRect],
    mut draw: impl FnMut(PixelRect) -> Result<Frame, PipelineError>,
) -> Result<Frame, PipelineError> {
    if let [only] = tiles {
        return draw(*only);
    }
    let mut whole = Frame { pixel_aspect: frame.pixel_aspect, ..Frame::blank(frame.window(), window, &[]) };
    for &tile in tiles {
        let drawn = draw(tile)?;
        if whole.channels.is_empty() {
            let channels: Vec<_> = drawn.channels.iter().map(|c| (c.name.as_str(), c.storage)).collect();
            whole.channels = Frame::blank(frame.window(), window, &channels).channels;
        }
        whole.paste(&drawn);
    }
    Ok(whole)
}

/// The frames that a render draws.
#[derive(Clone, Copy)]
pub(in crate::pipeline) struct FramesToDraw<'a> {
    pub(in crate::pipeline) frames: &'a [i32],
    /// Whether pictures of the lattices are wanted, and where the render waits.
    pub(in crate::pipeline) options: &'a RenderOptions,
    /// Ends the render.
    pub(in crate::pipeline) cancel: &'a AtomicBool,
}

/// Draws frames, the geometry of the next one being built meanwhile, until the render is cancelled or the receiver is gone. Returns the
/// milliseconds for which the raster was busy.
pub(in crate::pipeline) fn draw_frames(
    device: &mut dyn Raster,
    prepared: &PreparedShot,
    FramesToDraw { frames, options, cancel }: FramesToDraw,
    drawn: SyncSender<Drawn>,
) -> f64 {
    let tiles = tiles(prepared.shot.size.window(), device.max_side());
    let jerk = JerkMeter::default();
    let mut producer = GeometryThread { prepared, tile_count: tiles.len(), options, cancel, jerk };
    std::thread::scope(|scope| {
        let (job, jobs) = sync_channel(QUEUED_JOBS);
        scope.spawn(move || producer.run(frames, &job));
        let plan = plan_passes(prepared.shot.samples, prepared.shot.shutter);
        let renderer = FrameRenderer { device, prepared, plan, pause: &options.pause, busy_ms: 0.0 };
        draw_all(renderer, &tiles, (jobs, drawn))
    })
}

/// Draws all jobs and returns the time for which the raster was busy, milliseconds.
fn draw_all(
    mut renderer: FrameRenderer,
    tiles: &[PixelRect],
    (jobs, drawn): (Receiver<FrameJob>, SyncSender<Drawn>),
) -> f64 {
    for job in jobs {
        let before_ms = renderer.busy_ms;
        let done = match renderer.draw(&job, tiles) {
            Ok((frame, mut facts)) => {
                facts.report.raster_ms = renderer.busy_ms - before_ms;
                Drawn::Frame(Box::new(frame), Box::new(facts))
            }
            Err(error) => Drawn::Failed(job.frame, error),
        };
        if drawn.send(done).is_err() {
            break;
        }
    }
    renderer.busy_ms
}

/// Draws a single frame.
pub(in crate::pipeline) fn draw_frame(
    device: &mut dyn Raster,
    prepared: &PreparedShot,
    frame: i32,
) -> Result<Frame, PipelineError> {
    let (drawn, drawns) = sync_channel(1);
    let (options, cancel) = (&RenderOptions::default(), &AtomicBool::new(false));
    draw_frames(device, prepared, FramesToDraw { frames: &[frame], options, cancel }, drawn);
    match drawns.recv() {
        Ok(Drawn::Frame(frame, _)) => Ok(*frame),
        Ok(Drawn::Failed(_, error)) => Err(error),
        Err(_) => Err(PipelineError::Interrupted { frame }),
    }
}

/// Draws the frames of a shot on one device.
struct FrameRenderer<'a> {
    device: &'a mut dyn Raster,
    prepared: &'a PreparedShot,
    plan: Vec<PassPlan>,
    pause: &'a Pause,
    busy_ms: f64,
}

impl FrameRenderer<'_> {
    fn draw(&mut self, job: &FrameJob, tiles: &[PixelRect]) -> Result<(Frame, FrameFacts), PipelineError> {
        let whole = draw_tiles(self.prepared.shot.size.whole(), tiles, |window| self.tile(job, window))?;
        let begun = Instant::now();
        let frame = whole.crop_to_covered();
        self.busy_ms += begun.elapsed().as_secs_f64() * 1e3;
        Ok((frame, job.facts.recv().map_err(|_| lost(job))?))
    }

    fn tile(&mut self, job: &FrameJob, window: PixelRect) -> Result<Frame, PipelineError> {
        let is_beauty = |pass: &&PassPlan| pass.role != PassRole::Data;
        let target = Target {
            frame: self.prepared.shot.size,
            window,
            channels: self.prepared.shot.output.channels.clone(),
            beauty_passes: self.plan.iter().filter(is_beauty).count() as u32,
        };
        // The clock starts after the first pass has arrived, because building its geometry is not the raster's work.
        let mut next = Some(receive(job)?);
        self.timed(|device| device.start(&target))?;
        for remaining in (0..self.plan.len()).rev() {
            let Some(pass) = next.take() else { break };
            let BuiltPass { geometry, jitter_px, role } = pass;
            self.pause.wait();
            self.timed(|device| device.draw(&Pass { geometry: &geometry, jitter_px, role }))?;
            next = if remaining > 0 { Some(receive(job)?) } else { None };
        }
        self.timed(|device| device.finish())
    }

    /// Runs a step on the device and adds its duration to the busy time.
    fn timed<T, E: Into<PipelineError>>(
        &mut self,
        step: impl FnOnce(&mut dyn Raster) -> Result<T, E>,
    ) -> Result<T, PipelineError> {
        let begun = Instant::now();
        let outcome = step(self.device);
        self.busy_ms += begun.elapsed().as_secs_f64() * 1e3;
        outcome.map_err(Into::into)
    }
}

/// Returns the next pass of a job, or the error that ended the job.
fn receive(job: &FrameJob) -> Result<BuiltPass, PipelineError> {
    job.passes.recv().map_err(|_| lost(job))?
}

/// The error for a geometry thread that ended in the middle of a frame.
fn lost(job: &FrameJob) -> PipelineError {
    PipelineError::Interrupted { frame: job.frame }
}
