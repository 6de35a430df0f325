//! First thread of a warp: reads and decodes the input pictures of each frame.
//!
//! In: a [`Plan`]. Out: [`Loaded`] frames, one after the other.

use super::needed_memory::{held_bytes, warped_bytes};
use super::plan::Plan;
use crate::image::{ImageError, Plate, SequencePath, picture_extent, read_any, read_numbers};
use crate::memory::{self, Reservation};
use crate::pipeline::PipelineError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Instant;

/// The input of one frame.
pub(super) struct Loaded {
    pub(super) frame: i32,
    pub(super) pictures: Result<Pictures, PipelineError>,
    pub(super) read_ms: f64,
}

/// The pictures of a frame, and the memory reserved for it until it has been written.
pub(super) struct Pictures {
    pub(super) plate: Plate,
    /// The clean plate that fills holes.
    pub(super) clean: Option<Plate>,
    /// The STMap.
    pub(super) map: Option<Plate>,
    pub(super) memory: Reservation,
}

/// Reads frames.
pub(super) struct Reader<'a> {
    pub(super) plan: &'a Plan,
    pub(super) cancel: &'a AtomicBool,
}

impl Reader<'_> {
    /// Reads all frames; stops early if cancelled or if the warping thread has ended.
    pub(super) fn run(&self, loaded: &SyncSender<Loaded>) {
        for &frame in &self.plan.todo.frames {
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
        let Plan { plate, clean, maps, digests, .. } = self.plan;
        let path = |path: &Option<SequencePath>| path.as_ref().map(|path| path.path_of(frame));
        // The digest is taken before the files are read, so that a file modified meanwhile makes the frame outdated.
        digests.of(frame);
        let (plate, clean, map) = (plate.path_of(frame), path(clean), path(maps));
        let others = [&clean, &map].into_iter().flatten();
        let needed = warped_bytes(picture_extent(&plate)?)
            + others.map(|path| Ok(held_bytes(picture_extent(path)?))).sum::<Result<u128, ImageError>>()?;
        let memory = memory::reserve(needed).map_err(|source| ImageError::TooLarge { path: plate.clone(), source })?;
        Ok(Pictures {
            plate: read_any(&plate)?,
            clean: clean.as_deref().map(read_any).transpose()?,
            map: map.as_deref().map(read_numbers).transpose()?,
            memory,
        })
    }
}
