//! Marks the frames that a run is making, so that a second run in the same folder does not make them too.
//!
//! In: a sequence and frame numbers. Out: a [`RunLock`], or [`PipelineError::Busy`]. Each run holds an operating system's
//! lock on a file of its own: it ends with the process, so a run that died blocks nobody.

use super::PipelineError;
use crate::image::SequencePath;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use tempfile::NamedTempFile;

const PREFIX: &str = ".pinwarp-";
const ENDING: &str = ".lock";
/// How long an empty mark counts as one that is being made.
const NEWBORN: Duration = Duration::from_secs(1);

/// What a run says about itself.
#[derive(Deserialize, Serialize)]
struct Claim {
    process: u32,
    /// Name of frame 0: patterns that give the same names are one.
    sequence: String,
    frames: Vec<i32>,
}

/// Held while frames are made; removed with the run.
#[derive(Debug)]
pub(crate) struct RunLock {
    _file: NamedTempFile,
}

impl RunLock {
    /// Marks frames of `output`, whose folder is there. `None` where the file system has no locks, or takes no files.
    ///
    /// # Errors
    /// [`PipelineError::Busy`] where a run that lives is making one of them.
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

/// Removes the marks of dead runs beside a frame.
pub(crate) fn remove_dead(frame: &Path) {
    others(folder_of(frame), Path::new("")).for_each(drop);
}

fn folder_of(frame: &Path) -> &Path {
    frame.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn write(folder: &Path, claim: &Claim) -> std::io::Result<NamedTempFile> {
    let mut file = tempfile::Builder::new().prefix(PREFIX).suffix(ENDING).tempfile_in(folder)?;
    // Nobody else holds it, but for the moment in which another run asks whether we live.
    file.as_file().lock()?;
    file.write_all(serde_json::to_string(claim)?.as_bytes())?;
    Ok(file)
}

/// The claims of other runs that live; those of dead ones are removed.
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
        // A claim that cannot be read was not written to its end: its run will find ours.
        serde_json::from_slice(&std::fs::read(&path).ok()?).ok()
    })
}

/// Whether a run may just have made the file and be about to lock it: then it finds our claim, which is written already.
fn is_newborn(path: &Path) -> bool {
    let age = |made: SystemTime| made.elapsed().unwrap_or_default();
    path.metadata().is_ok_and(|file| file.len() == 0 && file.modified().is_ok_and(|made| age(made) < NEWBORN))
}

struct Shared {
    process: u32,
    frame: i32,
}

impl Claim {
    /// The first frame that both make.
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
        // What a killed run leaves: a file that nobody locks.
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
        remove_dead(&folder.path().join("f.0001.exr"));
        assert!(!newborn.exists(), "its run died before it wrote");
    }
}
