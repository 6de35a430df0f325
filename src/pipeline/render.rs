//! Renders frames: geometry of the next frame, drawing of this one and writing of the last go on at the same time.
//!
//! ```text
//! thread 1: pose, solve, build geometry ──Job──▶ this thread: draw ──Drawn──▶ thread 2: encode, write
//! ```
//! The channels are short, so memory does not grow with the length of the sequence.

use super::draw::{draw_all, tiles};
use super::output::{frames_to_do, prepare_folder, stale_note};
use super::pictures::{Wanted, render_pictures};
use super::produce::Producer;
use super::write::Writer;
use super::{Event, JerkMeter, PipelineError, RenderOptions, Setup, Summary};
use crate::image::{ImageError, PictureKind, SequencePath, is_complete};
use crate::raster::{self, Raster};
use crate::shot::Source;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::Instant;

/// Frames that may wait at either border between threads.
const QUEUED_FRAMES: usize = 1;

/// Renders the frames asked for, on the device asked for.
///
/// `tell` is called from several threads. `cancel` ends the render after the frames in flight.
///
/// # Errors
/// [`PipelineError`] where nothing can be rendered at all; single frames that fail are events and counted.
pub fn render(
    setup: &Setup,
    options: &RenderOptions,
    cancel: &AtomicBool,
    tell: &(dyn Fn(Event) + Sync),
) -> Result<Summary, PipelineError> {
    let work = Work::plan(setup, options)?;
    if setup.gallery.is_some() {
        return Ok(work.paint(cancel, tell));
    }
    let (mut device, fallback) = raster::open(&options.device, &setup.scene)?;
    if let Some(reason) = fallback {
        tell(Event::Note { text: format!("the CPU draws: {reason}") });
    }
    Ok(work.run(device.as_mut(), cancel, tell))
}

/// As [`render`], on a device that the caller opened for the setup's scene; `options.device` is not looked at.
///
/// # Errors
/// As [`render`].
pub fn render_on(
    device: &mut dyn Raster,
    setup: &Setup,
    options: &RenderOptions,
    cancel: &AtomicBool,
    tell: &(dyn Fn(Event) + Sync),
) -> Result<Summary, PipelineError> {
    Ok(Work::plan(setup, options)?.run(device, cancel, tell))
}

/// What is to be done.
struct Work<'a> {
    begun: Instant,
    setup: &'a Setup,
    options: &'a RenderOptions,
    output: SequencePath,
    frames: Vec<i32>,
    /// Frames that stay as they are.
    kept: Vec<PathBuf>,
}

impl<'a> Work<'a> {
    /// Refuses at once what would fail at every frame.
    fn plan(setup: &'a Setup, options: &'a RenderOptions) -> Result<Self, PipelineError> {
        let begun = Instant::now();
        if setup.shot.source == Source::Frame {
            let what = "there is no scene to render: this shot warps finished frames";
            return Err(PipelineError::mismatch(&setup.shot, "plate", what, "run `pinwarp warp --shot` on it"));
        }
        let output = SequencePath::parse(&setup.shot.output.path)?;
        let wanted = if options.frames.is_empty() {
            (setup.shot.frames.first..=setup.shot.frames.last).collect()
        } else {
            options.frames.clone()
        };
        output.check_frame_count(wanted.len())?;
        check_extension(&setup.shot.output.path)?;
        let inputs = setup.inputs()?;
        for path in wanted.iter().map(|&frame| output.path_of(frame)) {
            inputs.refuse(&path)?;
            if options.has_preview || options.has_overlay {
                inputs.refuse(&path.with_extension("png"))?;
            }
        }
        let has_preview =
            |path: &Path| !(options.has_preview || options.has_overlay) || path.with_extension("png").exists();
        let is_done = |path: &Path| is_complete(path) && has_preview(path);
        let (frames, kept) = frames_to_do(wanted, &output, (options.existing, &is_done))?;
        if let Some(&first) = frames.first() {
            prepare_folder(&output.path_of(first))?;
        }
        let kept = kept.into_iter().map(|frame| output.path_of(frame)).collect();
        Ok(Self { begun, setup, options, output, frames, kept })
    }

    /// Pictures are warped as pictures; no device draws them.
    fn paint(self, cancel: &AtomicBool, tell: &(dyn Fn(Event) + Sync)) -> Summary {
        let Self { begun, setup, options, output, frames, kept } = self;
        tell_notes(setup, &kept, tell);
        let count = frames.len();
        let wanted = Wanted { options, output, frames, kept: kept.len() };
        let summary = render_pictures(setup, wanted, cancel, tell);
        finished(Summary { wall_secs: begun.elapsed().as_secs_f64(), ..summary }, count, (cancel, tell))
    }

    fn run(self, device: &mut dyn Raster, cancel: &AtomicBool, tell: &(dyn Fn(Event) + Sync)) -> Summary {
        let Self { begun, setup, options, output, frames, kept } = self;
        tell_notes(setup, &kept, tell);
        let (wanted, kept) = (frames.len(), kept.len());
        tell(Event::Started { device: device.name(), frames: wanted, kept });
        let mut writer = Writer::new(setup, options, output, device.name());
        let tiles = tiles(setup.shot.size.window(), device.max_side());
        let mut raster_ms = 0.0;
        std::thread::scope(|scope| {
            let (job, jobs) = sync_channel(QUEUED_FRAMES);
            let (drawn, drawns) = sync_channel(QUEUED_FRAMES);
            let (tile_count, has_overlay) = (tiles.len(), options.has_overlay);
            let mut producer = Producer { setup, tile_count, has_overlay, cancel, jerk: JerkMeter::default() };
            scope.spawn(move || producer.run(&frames, &job));
            let writing = scope.spawn(|| writer.run(drawns, tell));
            raster_ms = draw_all(device, setup, &tiles, (jobs, drawn));
            // A panic in the writer is passed on, not swallowed.
            writing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        });
        let summary = Summary { kept, raster_ms, wall_secs: begun.elapsed().as_secs_f64(), ..writer.summary() };
        finished(summary, wanted, (cancel, tell))
    }
}

/// What the user should know before it begins.
fn tell_notes(setup: &Setup, kept: &[PathBuf], tell: &(dyn Fn(Event) + Sync)) {
    for text in setup.notes.iter().cloned().chain(stale_note(kept, &setup.shot.hash())) {
        tell(Event::Note { text });
    }
}

/// Tells the end of a render of `wanted` frames.
fn finished(summary: Summary, wanted: usize, (cancel, tell): (&AtomicBool, &(dyn Fn(Event) + Sync))) -> Summary {
    let is_cancelled = summary.rendered + summary.failed < wanted && cancel.load(Ordering::Relaxed);
    let summary = Summary { is_cancelled, ..summary };
    tell(Event::Finished(summary.clone()));
    summary
}

/// Frames are EXR files, and previews are named after them.
fn check_extension(pattern: &Path) -> Result<(), ImageError> {
    if PictureKind::of(pattern) == Some(PictureKind::Exr) {
        return Ok(());
    }
    let what = "is not the name of an EXR file; let it end in .exr (--preview writes PNG files beside it)";
    Err(ImageError::Pattern { pattern: pattern.to_owned(), what: what.into() })
}
