//! Decides which frames of a run are made, which are kept, and why existing frames are rendered again.
//!
//! In: the requested frames, and a check of a single frame. Out: [`Todo`].

use super::output::prepare_folder;
use super::run_lock::{RunLock, remove_dead};
use crate::image::{Existing, SequencePath, StaleReason, is_there, remove_stale};
use crate::pipeline::{PipelineError, Redone};
use crate::spelling::{pluralised, ranges};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The work of a run.
#[derive(Debug)]
pub(crate) struct Todo {
    /// Frames to make, in the order requested.
    pub(crate) frames: Vec<i32>,
    /// Number of frames that are kept.
    pub(crate) kept: usize,
    /// Frames to make that exist already.
    pub(crate) redone: Vec<Redone>,
    /// All requested frames.
    wanted: Vec<i32>,
    /// Held while the frames are made.
    lock: Option<RunLock>,
}

impl Todo {
    /// Sorts the requested frames. `check` returns the reason why an existing frame has to be rendered again; it is called
    /// only if existing frames may be kept.
    pub(crate) fn of(
        wanted: Vec<i32>,
        output: &SequencePath,
        existing: Existing,
        check: impl Fn(i32) -> Result<(), StaleReason>,
    ) -> Self {
        let (mut frames, mut redone, mut kept) = (Vec::new(), Vec::new(), 0);
        for &frame in &wanted {
            let outcome = if existing.is_resume() { check(frame) } else { Err(StaleReason::Missing) };
            match outcome {
                Ok(()) => kept += 1,
                Err(StaleReason::Missing) => frames.push(frame),
                Err(reason) => {
                    redone.push(Redone { frame, path: output.path_of(frame), reason: reason.to_string() });
                    frames.push(frame);
                }
            }
        }
        Self { frames, kept, redone, wanted, lock: None }
    }

    /// Creates the folder of the frames, marks them as being made, and removes what aborted runs left beside any
    /// requested frame, including kept ones, because a run may be aborted after its last frame.
    ///
    /// # Errors
    /// [`PipelineError`] if the folder cannot be written, or another run is making one of the frames.
    pub(crate) fn begin(mut self, output: &SequencePath) -> Result<Self, PipelineError> {
        if let Some(&first) = self.frames.first() {
            prepare_folder(&output.path_of(first))?;
        }
        self.lock = RunLock::take(output, &self.frames)?;
        if let Some(&first) = self.wanted.first().filter(|_| self.lock.is_none()) {
            remove_dead(&output.path_of(first));
        }
        let paths = self.wanted.iter().map(|&frame| output.path_of(frame));
        let stale = remove_stale(paths.flat_map(|path| [path.with_extension("png"), path]));
        if stale > 0 {
            tracing::info!("{} of runs that died removed", pluralised(stale, "temporary file", "temporary files"));
        }
        Ok(self)
    }

    /// Returns one line for each reason to render frames again.
    pub(crate) fn notes(&self) -> impl Iterator<Item = String> {
        let mut by_reason: BTreeMap<&str, Vec<i32>> = BTreeMap::new();
        for redone in &self.redone {
            by_reason.entry(&redone.reason).or_default().push(redone.frame);
        }
        let note = |(reason, frames): (&str, Vec<i32>)| {
            let count = pluralised(frames.len(), "frame is rendered again", "frames are rendered again");
            format!("{count} ({}): {reason}", ranges(&frames))
        };
        by_reason.into_iter().map(note).collect::<Vec<_>>().into_iter()
    }
}

/// Refuses existing frames.
pub(crate) fn refuse_existing(paths: impl IntoIterator<Item = PathBuf>) -> Result<(), PipelineError> {
    let mut there = paths.into_iter().filter(|path| is_there(path));
    match there.next() {
        None => Ok(()),
        Some(first) => Err(PipelineError::Exists { count: 1 + there.count(), first }),
    }
}
