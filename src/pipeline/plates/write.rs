//! Last thread of a warp: encodes and writes plates.
//!
//! In: [`Warped`] plates. Out: files, events, counts.

use super::plan::Plan;
use super::{PlateWarp, WarpEvent, WarpJob, WarpReport, WarpSummary};
use crate::image::{Destination, Durability, FrameMetadata, Plate, write_any};
use crate::memory::Reservation;
use crate::pipeline::PipelineError;
use crate::pipeline::run::frame_record::FrameRecord;
use crate::plate::ChannelReport;
use crate::raster::DeviceClass;
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// A warped frame, or the error that prevented it.
pub(super) struct Warped {
    pub(super) frame: i32,
    pub(super) outcome: Result<(Plate, WarpReport, Reservation), PipelineError>,
}

/// Writes plates and counts them.
pub(super) struct Writer<'a> {
    plan: &'a Plan,
    rate: f64,
    durability: Durability,
    /// Channel semantics of the previous frame.
    told: Vec<ChannelReport>,
    /// Source of the previous frame's mattes.
    mattes_told: String,
    /// Parts of the plates that were not read, as reported so far.
    left_out: Vec<String>,
    summary: WarpSummary,
}

impl<'a> Writer<'a> {
    pub(super) fn of(job: &WarpJob, plan: &'a Plan) -> Self {
        let rate = match &job.warp {
            PlateWarp::Shot(prepared) => prepared.shot.frames.rate,
            PlateWarp::Lattices { file, .. } => file.rate,
            PlateWarp::Maps(_) => 0.0,
        };
        let durability = job.durability;
        Self {
            plan,
            rate,
            durability,
            told: Vec::new(),
            mattes_told: String::new(),
            left_out: Vec::new(),
            summary: WarpSummary::default(),
        }
    }

    /// Writes all frames that arrive; one failed frame does not stop the others.
    pub(super) fn run(&mut self, warps: Receiver<Warped>, on_event: &(dyn Fn(WarpEvent) + Sync)) {
        for Warped { frame, outcome } in warps {
            if let Ok((plate, _, _)) = &outcome {
                self.emit_left_out(frame, plate, on_event);
            }
            match outcome.and_then(|(plate, report, _memory)| self.write(plate, report)) {
                Ok(report) => {
                    self.summary.warped += 1;
                    on_event(WarpEvent::FrameDone(report));
                }
                Err(error) => {
                    self.summary.failed += 1;
                    on_event(WarpEvent::FrameFailed { frame, error: error.to_string() });
                }
            }
        }
    }

    /// Reports contents of a plate that the warped plate lacks, each only once, because the frames of a sequence mostly agree.
    fn emit_left_out(&mut self, frame: i32, plate: &Plate, on_event: &(dyn Fn(WarpEvent) + Sync)) {
        for what in &plate.left_out {
            if !self.left_out.contains(what) {
                on_event(WarpEvent::Note { text: format!("left out of the plate from frame {frame} on: {what}") });
                self.left_out.push(what.clone());
            }
        }
    }

    /// Returns the number of frames and the times.
    pub(super) fn summary(self) -> WarpSummary {
        self.summary
    }

    fn write(&mut self, mut plate: Plate, mut report: WarpReport) -> Result<WarpReport, PipelineError> {
        let begun = Instant::now();
        report.path = self.plan.output.path_of(report.frame);
        plate.set_metadata(&FrameMetadata {
            frame: report.frame,
            frames_per_second: self.rate,
            shot_hash: self.plan.digests.of(report.frame),
            device: class_of(&report.device).to_string(),
            report: FrameRecord::of_warp(&report).to_json(),
            ..FrameMetadata::default()
        });
        write_any(Destination { path: &report.path, durability: self.durability }, &plate)?;
        report.write_ms = begun.elapsed().as_secs_f64() * 1e3;
        self.summary.read_ms += report.read_ms;
        self.summary.warp_ms += report.warp_ms;
        self.summary.write_ms += report.write_ms;
        if report.channels == self.told {
            report.channels.clear();
        } else {
            self.told.clone_from(&report.channels);
        }
        if report.mattes == self.mattes_told {
            report.mattes.clear();
        } else if !report.mattes.is_empty() {
            self.mattes_told.clone_from(&report.mattes);
        }
        Ok(report)
    }
}

/// Returns the class of the device that resampled; files name the class, not the device.
fn class_of(device: &str) -> DeviceClass {
    if device == DeviceClass::Cpu.to_string() { DeviceClass::Cpu } else { DeviceClass::Vulkan }
}
