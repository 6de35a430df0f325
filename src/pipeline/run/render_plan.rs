//! Plans a render: the frames, their files, and what would fail at every frame.
//!
//! In: a [`PreparedShot`] and [`RenderOptions`]. Out: a [`RenderPlan`].

use super::output::input_files;
use super::renderer::Renderer;
use super::resume::{Todo, refuse_existing};
use super::write::{Writer, preview_hash};
use crate::image::{Depth, Expected, ImageError, PictureKind, SequencePath, StaleReason, check_kept};
use crate::memory;
use crate::pipeline::{Event, Existing, PipelineError, PreparedShot, RenderOptions, Summary};
use crate::raster::{ChannelGroup, DeviceClass};
use crate::shot::{Shot, Source};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A planned render.
pub(in crate::pipeline) struct RenderPlan<'a> {
    begun: Instant,
    pub(in crate::pipeline) prepared: &'a PreparedShot,
    pub(in crate::pipeline) options: &'a RenderOptions,
    output: SequencePath,
    wanted: Vec<i32>,
    /// Digest of the shot and of the contents of its files.
    digest: String,
}

impl<'a> RenderPlan<'a> {
    /// Plans the render, and refuses at once what would fail at every frame.
    ///
    /// # Errors
    /// [`PipelineError`] if no frame can be rendered.
    pub(in crate::pipeline) fn new(
        prepared: &'a PreparedShot,
        options: &'a RenderOptions,
    ) -> Result<Self, PipelineError> {
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
    ///
    /// # Errors
    /// [`PipelineError`] if the folder of the frames is in use or cannot be written.
    pub(in crate::pipeline) fn todo(&self, device: DeviceClass) -> Result<Todo, PipelineError> {
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

    /// Sends the notes, the frames to render again, and the start.
    pub(in crate::pipeline) fn announce(&self, todo: &Todo, renderer: &Renderer, on_event: &(dyn Fn(Event) + Sync)) {
        let notes = self.prepared.notes.iter().cloned().chain(todo.notes()).chain(renderer.note(self.prepared));
        notes.for_each(|text| on_event(Event::Note { text }));
        todo.redone.iter().cloned().for_each(|redone| on_event(Event::FrameRedone(redone)));
        on_event(Event::Started { device: renderer.name(), frames: todo.frames.len(), kept: todo.kept });
    }

    /// Returns the writer of its frames.
    pub(in crate::pipeline) fn writer(&self, device: DeviceClass) -> Writer<'a> {
        Writer::new(self.prepared, self.options, (self.output.clone(), self.digest.clone()), device)
    }

    /// Completes the summary of a render.
    pub(in crate::pipeline) fn finished(&self, todo: &Todo, summary: Summary, cancel: &AtomicBool) -> Summary {
        let is_cancelled = summary.rendered + summary.failed < todo.frames.len() && cancel.load(Ordering::Relaxed);
        let wall_secs = self.begun.elapsed().as_secs_f64();
        Summary { wall_secs, is_cancelled, kept: todo.kept, redone: todo.redone.len(), ..summary }
    }
}

/// Returns the path of a frame, and of its preview if there is one.
fn files_of(output: &SequencePath, options: &RenderOptions, frame: i32) -> impl Iterator<Item = std::path::PathBuf> {
    let path = output.path_of(frame);
    let preview = (options.has_preview || options.has_overlay).then(|| path.with_extension("png"));
    std::iter::once(path).chain(preview)
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
