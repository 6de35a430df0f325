//! Marks the frames that a run is making, so that a second run in the same folder does not make them too.
//!
//! In: a sequence and frame numbers. Out: a [`RunLock`], or [`PipelineError::Busy`]. Each run holds a lock of the
//! operating system on a file of its own. The lock ends with the process, so an aborted run blocks nobody.

use crate::image::SequencePath;
use crate::pipeline::PipelineError;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use tempfile::NamedTempFile;

const PREFIX: &str = ".pinwarp-";
const ENDING: &str = ".lock";
/// Time for which an empty lock file counts as just being created.
const NEWBORN: Duration = Duration::from_secs(1);

/// The contents of a lock file.
#[derive(Deserialize, Serialize)]
struct Claim {
    process: u32,
    /// File name of frame 0; patterns that yield the same names are the same sequence.
    sequence: String,
    frames: Vec<i32>,
}

/// A lock on frames, which removes its file when dropped.
#[derive(Debug)]
pub(crate) struct RunLock {
    _file: NamedTempFile,
}

impl RunLock {
    /// Marks frames of `output`, whose folder must exist. `None` if there are no frames, or the file system supports no
    /// locks or no new files.
    ///
    /// # Errors
    /// [`PipelineError::Busy`] if a running process is making one of the frames.
    pub(crate) fn take(output: &SequencePath, frames: &[i32]) -> Result<Option<Self>, PipelineError> {
        let Some(&first) = frames.first() else { return Ok(None) };
        let path = output.path_of(first);
        let folder = folder_of(&path);
        let sequence = output.path_of(0).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let claim = Claim { process: std::process::id(), sequence, frames: frames.to_vec() };
        let Ok(file) = write(folder, &claim) else { return Ok(None) };
        let shared = others(folder, file.path()).find_map(|other| other.shares(&claim));
        match shared {
            None => Ok(Some(Self { _file: file })),
            Some(Shared { process, frame }) => Err(PipelineError::Busy { process, frame, folder: folder.to_owned() }),
        }
    }
}

/// Removes the lock files of aborted runs in the folder of a frame.
pub(crate) fn remove_dead(frame: &Path) {
    others(folder_of(frame), Path::new("")).for_each(drop);
}

fn folder_of(frame: &Path) -> &Path {
    frame.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn write(folder: &Path, claim: &Claim) -> std::io::Result<NamedTempFile> {
    let mut file = tempfile::Builder::new().prefix(PREFIX).suffix(ENDING).tempfile_in(folder)?;
    // The lock is free, except for a moment in which another run may be testing whether this process is alive.
    file.as_file().lock()?;
    file.write_all(serde_json::to_string(claim)?.as_bytes())?;
    Ok(file)
}

/// Returns the claims of other running processes, and removes lock files of aborted runs.
fn others<'a>(folder: &Path, own: &'a Path) -> impl Iterator<Item = Claim> + 'a {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_lock = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(PREFIX) && name.ends_with(ENDING) && path.symlink_metadata().is_ok_and(|file| file.is_file())
    };
    let locks =
        entries.map(|entry| entry.path()).filter(is_lock).filter(move |path| path.file_name() != own.file_name());
    locks.filter_map(|path| {
        if File::open(&path).ok()?.try_lock().is_ok() {
            if !is_newborn(&path) {
                let _ = std::fs::remove_file(&path);
            }
            return None;
        }
        // An unreadable claim is incomplete: the run that is writing it will find this run's claim.
        serde_json::from_slice(&std::fs::read(&path).ok()?).ok()
    })
}

/// Whether another run may just have created the file and not locked it yet; that run will find this run's claim, which
/// is complete.
fn is_newborn(path: &Path) -> bool {
    let age = |made: SystemTime| made.elapsed().unwrap_or_default();
    path.metadata().is_ok_and(|file| file.len() == 0 && file.modified().is_ok_and(|made| age(made) < NEWBORN))
}

struct Shared {
    process: u32,
    frame: i32,
}

impl Claim {
    /// Returns the first frame that both claims contain.
    fn shares(&self, other: &Self) -> Option<Shared> {
        if self.sequence != other.sequence {
            return None;
        }
        let theirs: HashSet<i32> = self.frames.iter().copied().collect();
        let frame = other.frames.iter().copied().find(|frame| theirs.contains(frame))?;
        Some(Shared { process: self.process, frame })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_share_a_frame_exclude_each_other_while_they_live() {
        let folder = tempfile::tempdir().expect("a folder");
        let sequence = |name: &str| SequencePath::parse(&folder.path().join(name)).expect("a name");
        let frames = |range: std::ops::RangeInclusive<i32>| range.collect::<Vec<_>>();
        let first = RunLock::take(&sequence("f.####.exr"), &frames(1..=10)).expect("free");
        assert!(first.is_some(), "temporary folders have locks");
        let busy = RunLock::take(&sequence("f.%04d.exr"), &frames(10..=20)).expect_err("frame 10 is shared");
        assert!(matches!(busy, PipelineError::Busy { frame: 10, .. }), "{busy}");
        for (name, range) in [("f.####.exr", 11..=20), ("g.####.exr", 1..=10)] {
            RunLock::take(&sequence(name), &frames(range)).expect("nothing is shared");
        }
        drop(first);
        // A killed process leaves a file that nobody locks.
        let claim = Claim { process: 1, sequence: "f.0000.exr".into(), frames: frames(1..=10) };
        let dead = folder.path().join(".pinwarp-dead01.lock");
        std::fs::write(&dead, serde_json::to_string(&claim).expect("JSON")).expect("written");
        RunLock::take(&sequence("f.####.exr"), &frames(1..=10)).expect("the other run is dead");
        assert_eq!(std::fs::read_dir(folder.path()).expect("listed").count(), 0, "no lock is left behind");
    }

    #[test]
    fn marks_that_are_just_being_made_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let newborn = folder.path().join(".pinwarp-new001.lock");
        let file = File::create(&newborn).expect("made");
        remove_dead(&folder.path().join("f.0001.exr"));
        assert!(newborn.exists());
        file.set_modified(SystemTime::now() - 2 * NEWBORN).expect("a time");
        drop(file);
        remove_dead(&folder.path().join("f.0001.exr"));
        assert!(!newborn.exists(), "its run died before it wrote");
    }
}
