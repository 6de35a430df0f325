//! Last thread of a render: encodes and writes frames and previews.
//!
//! In: [`Drawn`] frames. Out: files, events, counts.

use super::frame_record::FrameRecord;
use crate::image::{Destination, Frame, FrameMetadata, SequencePath, preview, write_exr, write_frame_preview};
use crate::pipeline::draw::geometry_thread::FrameFacts;
use crate::pipeline::{Event, PipelineError, PreparedShot, RenderOptions, Summary};
use crate::raster::{ChannelGroup, DeviceClass};
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// The message from the drawing thread to the writer.
pub(in crate::pipeline) enum Drawn {
    /// A complete frame.
    Frame(Box<Frame>, Box<FrameFacts>),
    /// A frame that failed, and the error.
    Failed(i32, PipelineError),
}

/// Writes frames and counts them.
pub(in crate::pipeline) struct Writer<'a> {
    prepared: &'a PreparedShot,
    options: &'a RenderOptions,
    output: SequencePath,
    device: DeviceClass,
    shot_hash: String,
    summary: Summary,
}

impl<'a> Writer<'a> {
    /// Creates the writer; `shot_hash`: digest of the shot and of the contents of its files.
    pub(in crate::pipeline) fn new(
        prepared: &'a PreparedShot,
        options: &'a RenderOptions,
        (output, shot_hash): (SequencePath, String),
        device: DeviceClass,
    ) -> Self {
        Self { prepared, options, output, device, shot_hash, summary: Summary::default() }
    }

    /// Writes all frames that arrive; one failed frame does not stop the others.
    pub(in crate::pipeline) fn run(&mut self, drawns: Receiver<Drawn>, on_event: &(dyn Fn(Event) + Sync)) {
        for drawn in drawns {
            let (number, outcome) = match drawn {
                Drawn::Frame(frame, facts) => (facts.report.frame, self.write(&frame, *facts)),
                Drawn::Failed(number, error) => (number, Err(error)),
            };
            match outcome {
                Ok(done) => {
                    self.summary.rendered += 1;
                    on_event(done);
                }
                Err(error) => {
                    self.summary.failed += 1;
                    on_event(Event::FrameFailed { frame: number, error: error.to_string() });
                }
            }
        }
    }

    /// Returns the number of frames and the times.
    pub(in crate::pipeline) fn summary(self) -> Summary {
        self.summary
    }

    fn write(&mut self, frame: &Frame, facts: FrameFacts) -> Result<Event, PipelineError> {
        let begun = Instant::now();
        let FrameFacts { mut report, picture, camera } = facts;
        report.path = self.output.path_of(report.frame);
        let has_mattes =
            self.prepared.gallery.is_none() && self.prepared.shot.output.channels.contains(&ChannelGroup::Cryptomatte);
        if frame.data_window.area() == 0 {
            report.warnings.push("the picture is empty: the camera sees nothing".into());
        }
        let metadata = FrameMetadata {
            frame: report.frame,
            frames_per_second: self.prepared.shot.frames.rate,
            shot_hash: self.shot_hash.clone(),
            device: self.device.to_string(),
            camera: Some(camera),
            mattes: if has_mattes { self.prepared.draw_inputs.mattes.clone() } else { Vec::new() },
            report: FrameRecord::of_render(&report).to_json(),
        };
        let to = |path| Destination { path, durability: self.options.durability };
        write_exr(to(&report.path), frame, &metadata, self.prepared.shot.output.compression)?;
        if self.options.has_preview || picture.is_some() {
            let mut shown = preview(frame);
            if let Some(picture) = picture {
                picture.draw(&mut shown);
            }
            let shot_hash = preview_hash(&self.shot_hash, self.options);
            let metadata = FrameMetadata { shot_hash, ..metadata };
            write_frame_preview(to(&report.path.with_extension("png")), &shown, &metadata)?;
        }
        report.write_ms = begun.elapsed().as_secs_f64() * 1e3;
        self.summary.geometry_ms += report.geometry_ms;
        self.summary.write_ms += report.write_ms;
        Ok(Event::FrameDone(report))
    }
}

/// Returns the digest of a preview, which differs with and without the overlay.
pub(in crate::pipeline) fn preview_hash(shot_hash: &str, options: &RenderOptions) -> String {
    let overlay = if options.has_overlay { "+overlay" } else { "" };
    format!("{shot_hash}{overlay}")
}
