//! Renders frames: the geometry of the next frame is built while the current one is drawn and the previous one is written.
//!
//! ```text
//! thread 1: pose, solve, build geometry ──Job──▶ this thread: draw ──Drawn──▶ thread 2: encode, write
//! ```
//! The channels are short, so memory does not grow with the length of the sequence.

use super::output::input_files;
use super::resume::{Todo, refuse_existing};
use super::write::{Writer, preview_hash};
use crate::image::{Depth, Expected, ImageError, PictureKind, SequencePath, StaleReason, check_kept};
use crate::memory;
use crate::pipeline::draw::geometry_thread::GeometryThread;
use crate::pipeline::draw::{draw_all, tiles};
use crate::pipeline::pictures::{Wanted, render_pictures};
use crate::pipeline::trajectories::solve_ahead::solve_before_frames;
use crate::pipeline::{Event, Existing, JerkMeter, PipelineError, PreparedShot, RenderOptions, Summary};
use crate::raster::{self, ChannelGroup, DeviceClass, Raster};
use crate::shot::{Shot, Source};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::time::Instant;

/// Number of frames that may wait in each channel between threads.
const QUEUED_FRAMES: usize = 1;

/// Renders the requested frames on the requested device.
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
    let work = Work::plan(prepared, options)?;
    if prepared.gallery.is_some() {
        let todo = work.todo(DeviceClass::Cpu)?;
        return Ok(work.paint(todo, cancel, on_event));
    }
    let (mut device, fallback) = raster::open(&options.device, &prepared.scene)?;
    if let Some(reason) = fallback {
        on_event(Event::Note { text: format!("the CPU draws: {reason}") });
    }
    let todo = work.todo(device.class())?;
    Ok(work.run(todo, device.as_mut(), (cancel, on_event)))
}

/// Renders as [`render`] does, on a device that the caller opened for the prepared shot; `options.device` is ignored.
///
/// # Errors
/// As [`render`].
#[cfg(test)]
pub(crate) fn render_on(
    device: &mut dyn Raster,
    prepared: &PreparedShot,
    options: &RenderOptions,
    cancel: &AtomicBool,
    on_event: &(dyn Fn(Event) + Sync),
) -> Result<Summary, PipelineError> {
    let work = Work::plan(prepared, options)?;
    let todo = work.todo(device.class())?;
    Ok(work.run(todo, device, (cancel, on_event)))
}

/// A planned render.
struct Work<'a> {
    begun: Instant,
    prepared: &'a PreparedShot,
    options: &'a RenderOptions,
    output: SequencePath,
    wanted: Vec<i32>,
    /// Digest of the shot and of the contents of its files.
    digest: String,
}

impl<'a> Work<'a> {
    /// Plans the render, and refuses at once what would fail at every frame.
    fn plan(prepared: &'a PreparedShot, options: &'a RenderOptions) -> Result<Self, PipelineError> {
        let begun = Instant::now();
        if prepared.shot.source == Source::Frame {
            let what = "there is no scene to render: this shot warps finished frames";
            return Err(PipelineError::mismatch(&prepared.shot, "plate", what, "run `pinwarp warp --shot` on it"));
        }
        check_memory(&prepared.shot)?;
        let output = SequencePath::parse(&prepared.shot.output.path)?;
        let wanted = if options.frames.is_empty() {
            (prepared.shot.frames.first..=prepared.shot.frames.last).collect()
        } else {
            options.frames.clone()
        };
        check_extension(&prepared.shot.output.path)?;
        output.check_frame_count(wanted.len())?;
        let mut inputs = input_files(prepared)?;
        options.inputs.iter().for_each(|path| inputs.add(path));
        let files: Vec<_> = wanted.iter().flat_map(|&frame| files_of(&output, options, frame)).collect();
        files.iter().try_for_each(|path| inputs.refuse(path))?;
        if options.existing == Existing::Refuse {
            refuse_existing(files)?;
        }
        Ok(Self { begun, prepared, options, output, wanted, digest: prepared.digest() })
    }

    /// Returns the frames to render on a device of the given class.
    fn todo(&self, device: DeviceClass) -> Result<Todo, PipelineError> {
        let device = &device.to_string();
        let (shot_hash, options) = (&self.digest, self.options);
        let depth = if options.existing == Existing::Verify { Depth::Pixels } else { Depth::Head };
        let preview_hash = preview_hash(shot_hash, options);
        let todo = Todo::of(self.wanted.clone(), &self.output, options.existing, |frame| {
            let expected = Expected { frame, shot_hash, size: Some(self.prepared.shot.size), device };
            let path = self.output.path_of(frame);
            check_kept(&path, &expected, depth)?;
            if options.has_preview || options.has_overlay {
                let expected = Expected { shot_hash: &preview_hash, ..expected };
                check_kept(&path.with_extension("png"), &expected, depth).map_err(|_| StaleReason::Preview)?;
            }
            Ok(())
        });
        todo.begin(&self.output)
    }

    /// Renders a shot of pictures, which are warped on the CPU instead of being drawn by a device.
    fn paint(self, todo: Todo, cancel: &AtomicBool, on_event: &(dyn Fn(Event) + Sync)) -> Summary {
        let Self { begun, prepared, options, output, digest, .. } = self;
        emit_notes(prepared, &todo, on_event);
        let wanted = Wanted { options, output, digest, frames: todo.frames.clone(), kept: todo.kept };
        let summary = render_pictures(prepared, wanted, cancel, on_event);
        finished(Summary { wall_secs: begun.elapsed().as_secs_f64(), ..summary }, &todo, (cancel, on_event))
    }

    fn run(
        self,
        todo: Todo,
        device: &mut dyn Raster,
        (cancel, on_event): (&AtomicBool, &(dyn Fn(Event) + Sync)),
    ) -> Summary {
        let Self { begun, prepared, options, output, digest, .. } = self;
        emit_notes(prepared, &todo, on_event);
        on_event(Event::Started { device: device.name(), frames: todo.frames.len(), kept: todo.kept });
        if !todo.frames.is_empty() {
            solve_before_frames(prepared, cancel);
        }
        let mut writer = Writer::new(prepared, options, (output, digest), device.class());
        let tiles = tiles(prepared.shot.size.window(), device.max_side());
        let mut raster_ms = 0.0;
        std::thread::scope(|scope| {
            let (job, jobs) = sync_channel(QUEUED_FRAMES);
            let (drawn, drawns) = sync_channel(QUEUED_FRAMES);
            let (tile_count, has_overlay) = (tiles.len(), options.has_overlay);
            let mut producer = GeometryThread { prepared, tile_count, has_overlay, cancel, jerk: JerkMeter::default() };
            let frames = &todo.frames;
            scope.spawn(move || producer.run(frames, &job));
            let writing = scope.spawn(|| writer.run(drawns, on_event));
            raster_ms = draw_all(device, prepared, &tiles, (jobs, drawn));
            // Propagates a panic in the writer.
            writing.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        });
        let summary = Summary { raster_ms, wall_secs: begun.elapsed().as_secs_f64(), ..writer.summary() };
        finished(summary, &todo, (cancel, on_event))
    }
}

/// Returns the path of a frame, and of its preview if there is one.
fn files_of(output: &SequencePath, options: &RenderOptions, frame: i32) -> impl Iterator<Item = std::path::PathBuf> {
    let path = output.path_of(frame);
    let preview = (options.has_preview || options.has_overlay).then(|| path.with_extension("png"));
    std::iter::once(path).chain(preview)
}

/// Sends the notes and the list of frames to render again.
fn emit_notes(prepared: &PreparedShot, todo: &Todo, on_event: &(dyn Fn(Event) + Sync)) {
    prepared.notes.iter().cloned().chain(todo.notes()).for_each(|text| on_event(Event::Note { text }));
    todo.redone.iter().cloned().for_each(|redone| on_event(Event::FrameRedone(redone)));
}

/// Completes the summary of a render and sends it.
fn finished(summary: Summary, todo: &Todo, (cancel, on_event): (&AtomicBool, &(dyn Fn(Event) + Sync))) -> Summary {
    let is_cancelled = summary.rendered + summary.failed < todo.frames.len() && cancel.load(Ordering::Relaxed);
    let summary = Summary { is_cancelled, kept: todo.kept, redone: todo.redone.len(), ..summary };
    on_event(Event::Finished(summary.clone()));
    summary
}

/// Checks that frames are EXR files; previews are named after them.
fn check_extension(pattern: &Path) -> Result<(), ImageError> {
    if PictureKind::of(pattern) == Some(PictureKind::Exr) {
        return Ok(());
    }
    let exr = pattern.with_extension("exr");
    let what = format!(
        "is not the name of an EXR file; write -o {}, and --preview for a PNG picture beside every frame",
        exr.display()
    );
    Err(ImageError::Pattern { pattern: pattern.to_owned(), what })
}

/// Checks the memory for a frame: each sample is held up to four times while one frame is drawn, gathered from its
/// passes, and encoded during the drawing of the next.
fn check_memory(shot: &Shot) -> Result<(), PipelineError> {
    let pixels = u128::from(shot.size.width) * u128::from(shot.size.height);
    let channels: u128 = shot.output.channels.iter().map(|group| group_channels(*group)).sum();
    memory::check(pixels * channels.max(4) * 16).map_err(|source| {
        let what = format!("a frame of {} x {} pixels {source}", shot.size.width, shot.size.height);
        PipelineError::mismatch(shot, "size", what, "or render it smaller (--scale)")
    })
}

/// Returns the number of channels of a group.
fn group_channels(group: ChannelGroup) -> u128 {
    match group {
        // Six ranks of three Cryptomattes, with an id and a coverage each.
        ChannelGroup::Cryptomatte => 36,
        planar => planar.channels().len() as u128,
    }
}
