//! Renders the frames of a shot of pictures: one frame is solved and drawn while the previous one is written.
//!
//! In: the options of a render. Out: files, events, and a [`Summary`], as from any render.

use super::paint::Painter;
use crate::image::{Frame, SequencePath};
use crate::pipeline::draw::geometry_thread::facts;
use crate::pipeline::draw::passes::{PassPlan, mid_shutter, plan_passes};
use crate::pipeline::run::write::{Drawn, Writer};
use crate::pipeline::trajectories::solve_ahead::solve_before_frames;
use crate::pipeline::{Event, JerkMeter, PipelineError, PreparedShot, RenderOptions, Summary, TimeSample};
use crate::raster::{ChannelGroup, DeviceClass, PassRole};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::Instant;

/// Name of the device in events and metadata.
const DEVICE: &str = "the CPU, as pictures";

/// The frames to render and their destination.
pub(in crate::pipeline) struct Wanted<'a> {
    pub(in crate::pipeline) options: &'a RenderOptions,
    pub(in crate::pipeline) output: SequencePath,
    /// Digest of the shot and of the contents of its files.
    pub(in crate::pipeline) digest: String,
    pub(in crate::pipeline) frames: Vec<i32>,
    /// Number of frames that are kept.
    pub(in crate::pipeline) kept: usize,
}

/// Renders the frames.
pub(in crate::pipeline) fn render_pictures(
    prepared: &PreparedShot,
    wanted: Wanted,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(Event) + Sync),
) -> Summary {
    let Wanted { options, output, digest, frames, kept } = wanted;
    let Some(gallery) = &prepared.gallery else { return Summary { kept, ..Summary::default() } };
    emit_left_out(prepared, on_event);
    on_event(Event::Started { device: DEVICE.to_owned(), frames: frames.len(), kept });
    if !frames.is_empty() {
        solve_before_frames(prepared, cancel);
    }
    let mut writer = Writer::new(prepared, options, (output, digest), DeviceClass::Cpu);
    let mut painting = Painting {
        prepared,
        painter: Painter::new(gallery, prepared),
        options,
        jerk: JerkMeter::default(),
        busy_ms: 0.0,
    };
    std::thread::scope(|scope| {
        let (drawn, drawns) = sync_channel(1);
        let writing = scope.spawn(|| writer.run(drawns, on_event));
        for &frame in &frames {
            if cancel.load(Ordering::Relaxed) || drawn.send(painting.draw(frame)).is_err() {
                break;
            }
        }
        drop(drawn);
        // Propagates a panic in the writer.
        writing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    });
    Summary { kept, raster_ms: painting.busy_ms, ..writer.summary() }
}

/// Reports channels that pictures do not provide.
fn emit_left_out(prepared: &PreparedShot, on_event: &(dyn Fn(Event) + Sync)) {
    let is_left_out = |group: &&ChannelGroup| !matches!(group, ChannelGroup::Beauty | ChannelGroup::Id);
    let names: Vec<String> = prepared
        .shot
        .output
        .channels
        .iter()
        .filter(is_left_out)
        .map(|group| format!("{group:?}").to_lowercase())
        .collect();
    if !names.is_empty() {
        let text = format!(
            "pictures have colour and ids only: {} is not written; take it out of `channels`",
            names.join(", ")
        );
        on_event(Event::Note { text });
    }
}

/// The state of the thread that solves and draws.
struct Painting<'a> {
    prepared: &'a PreparedShot,
    painter: Painter<'a>,
    options: &'a RenderOptions,
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
        let mut facts = facts(prepared, (frame, &middle), self.options.has_overlay, &mut self.jerk);
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
