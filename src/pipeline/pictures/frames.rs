//! Draws the frames of a shot of pictures.
//!
//! In: frame numbers. Out: [`Drawn`] frames.

use super::Gallery;
use super::paint::Painter;
use crate::image::Frame;
use crate::pipeline::draw::FramesToDraw;
use crate::pipeline::draw::geometry_thread::facts;
use crate::pipeline::draw::passes::{PassPlan, mid_shutter, plan_passes};
use crate::pipeline::run::write::Drawn;
use crate::pipeline::{JerkMeter, PipelineError, PreparedShot, TimeSample};
use crate::raster::{ChannelGroup, PassRole};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::SyncSender;
use std::time::Instant;

/// Solves and draws frames until the render is cancelled or the receiver is gone. Returns the milliseconds spent drawing.
pub(in crate::pipeline) fn paint_frames(
    gallery: &Gallery,
    prepared: &PreparedShot,
    FramesToDraw { frames, options, cancel }: FramesToDraw,
    drawn: SyncSender<Drawn>,
) -> f64 {
    let painter = Painter::new(gallery, prepared);
    let has_overlay = options.has_overlay;
    let mut painting = Painting { prepared, painter, has_overlay, jerk: JerkMeter::default(), busy_ms: 0.0 };
    for &frame in frames {
        options.pause.wait();
        if cancel.load(Ordering::Relaxed) || drawn.send(painting.draw(frame)).is_err() {
            break;
        }
    }
    painting.busy_ms
}

/// Returns the note that pictures do not provide some of the channels; `None` if they provide all.
pub(in crate::pipeline) fn left_out_channels(prepared: &PreparedShot) -> Option<String> {
    let is_left_out = |group: &&ChannelGroup| !matches!(group, ChannelGroup::Beauty | ChannelGroup::Id);
    let left_out = prepared.shot.output.channels.iter().filter(is_left_out);
    let names: Vec<String> = left_out.map(|group| format!("{group:?}").to_lowercase()).collect();
    let names = (!names.is_empty()).then(|| names.join(", "))?;
    Some(format!("pictures have colour and ids only: {names} is not written; take it out of `channels`"))
}

/// The state of the thread that solves and draws.
struct Painting<'a> {
    prepared: &'a PreparedShot,
    painter: Painter<'a>,
    has_overlay: bool,
    jerk: JerkMeter,
    busy_ms: f64,
}

impl Painting<'_> {
    fn draw(&mut self, frame: i32) -> Drawn {
        self.try_draw(frame).unwrap_or_else(|error| Drawn::Failed(frame, error))
    }

    fn try_draw(&mut self, frame: i32) -> Result<Drawn, PipelineError> {
        let begun = Instant::now();
        let prepared = self.prepared;
        let middle = prepared.mid_exposure(frame)?;
        let mut facts = facts(prepared, (frame, &middle), self.has_overlay, &mut self.jerk);
        facts.report.geometry_ms = begun.elapsed().as_secs_f64() * 1e3;
        let begun = Instant::now();
        let picture = self.painter.frame(&times(prepared, frame), &middle, |time| prepared.sample_at(time))?;
        facts.report.raster_ms = begun.elapsed().as_secs_f64() * 1e3;
        facts.report.warnings.extend(self.painter.warnings());
        self.busy_ms += facts.report.raster_ms;
        Ok(Drawn::Frame(Box::new(picture), Box::new(facts)))
    }
}

/// Draws the mean of the pictures at some times; `middle` gives the ids.
#[cfg_attr(
    not(any(test, feature = "editor", feature = "python")),
    expect(dead_code, reason = "only the editor and the Python package call it")
)]
pub(in crate::pipeline) fn paint_frame(
    prepared: &PreparedShot,
    middle: &TimeSample,
    times: &[f64],
    sample_at: &dyn Fn(f64) -> Result<Arc<TimeSample>, PipelineError>,
) -> Result<Frame, PipelineError> {
    let missing = || PipelineError::Interrupted { frame: middle.frame as i32 };
    let gallery = prepared.gallery.as_ref().ok_or_else(missing)?;
    Painter::new(gallery, prepared).frame(times, middle, sample_at)
}

/// Returns the sample times of a frame's exposure; without a shutter, the frame's own time.
pub(in crate::pipeline) fn times(prepared: &PreparedShot, frame: i32) -> Vec<f64> {
    let shutter = prepared.shot.shutter;
    if shutter.angle <= 0.0 {
        return vec![f64::from(frame) + mid_shutter(shutter)];
    }
    let is_beauty = |pass: &PassPlan| pass.role != PassRole::Data;
    let passes = plan_passes(prepared.shot.samples, shutter).into_iter().filter(is_beauty);
    passes.map(|pass| f64::from(frame) + pass.time_frames).collect()
}
