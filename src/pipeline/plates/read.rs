//! First thread of a warp: reads and decodes what a frame is made of.
//!
//! In: a [`Plan`]. Out: a [`Loaded`] frame after the other.

use super::super::PipelineError;
use super::plan::Plan;
use crate::image::{Plate, SequencePath, read_any};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Instant;

/// What a frame is made of.
pub(super) struct Loaded {
    pub(super) frame: i32,
    pub(super) pictures: Result<Pictures, PipelineError>,
    pub(super) read_ms: f64,
}

/// The pictures of a frame.
pub(super) struct Pictures {
    pub(super) plate: Plate,
    /// What lies behind.
    pub(super) clean: Option<Plate>,
    /// The STMap.
    pub(super) map: Option<Plate>,
}

/// Reads frames.
pub(super) struct Reader<'a> {
    pub(super) plan: &'a Plan,
    pub(super) cancel: &'a AtomicBool,
}

impl Reader<'_> {
    /// Reads all frames; ends early when cancelled or when nobody warps any more.
    pub(super) fn run(&self, loaded: &SyncSender<Loaded>) {
        for &frame in &self.plan.frames {
            if self.cancel.load(Ordering::Relaxed) {
                return;
            }
            let begun = Instant::now();
            let pictures = self.pictures(frame);
            let read_ms = begun.elapsed().as_secs_f64() * 1e3;
            if loaded.send(Loaded { frame, pictures, read_ms }).is_err() {
                return;
            }
        }
    }

    fn pictures(&self, frame: i32) -> Result<Pictures, PipelineError> {
        let Plan { plate, clean, maps, .. } = self.plan;
        let read = |path: &Option<SequencePath>| path.as_ref().map(|path| read_any(&path.path_of(frame))).transpose();
        Ok(Pictures { plate: read_any(&plate.path_of(frame))?, clean: read(clean)?, map: read(maps)? })
    }
}
