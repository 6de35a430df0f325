//! The one rule for everything that is written: no input, nothing special, nothing that is there unless it may be replaced.
//!
//! In: the files that a job reads, and a path that it wants to write. Out: leave, or [`ImageError::Refused`].

use super::atomic::{check_replaceable, folder_of};
use super::{ImageError, SequencePath};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What happens to files that are already there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Nothing is written.
    #[default]
    Refuse,
    /// They are replaced.
    Overwrite,
    /// Frames that the same job would write again are kept by what their heads say, all others are written.
    Resume,
    /// As [`Self::Resume`], and the pixels of kept frames match their checksums.
    Verify,
}

impl Existing {
    /// Finished frames are kept.
    #[must_use]
    pub const fn is_resume(self) -> bool {
        matches!(self, Self::Resume | Self::Verify)
    }
}

/// Everything that a job reads, so that nothing of it is written over.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inputs {
    /// As they are named, and where they lie.
    paths: BTreeSet<PathBuf>,
    /// Device and file number: they see through hard links and names in other letter case.
    files: BTreeSet<(u64, u64)>,
    sequences: Vec<SequencePath>,
}

impl Inputs {
    /// Adds a file, whether it is there or not.
    pub(crate) fn add(&mut self, path: &Path) {
        self.paths.extend(path.canonicalize());
        self.paths.insert(path.to_owned());
        self.files.extend(file_number(path));
    }

    /// Adds a sequence: the frames that are there, and every name that its pattern gives.
    ///
    /// # Errors
    /// [`ImageError::Io`] where the folder cannot be listed.
    pub(crate) fn add_sequence(&mut self, sequence: &SequencePath) -> Result<(), ImageError> {
        match sequence.frames_on_disk()? {
            Some(frames) => frames.into_iter().for_each(|frame| self.add(&sequence.path_of(frame))),
            None => self.add(&sequence.path_of(0)),
        }
        self.sequences.push(sequence.clone());
        Ok(())
    }

    /// Refuses an input, by whatever name, and what is no regular file.
    ///
    /// # Errors
    /// [`ImageError::Refused`].
    pub(crate) fn refuse(&self, output: &Path) -> Result<(), ImageError> {
        let is_input = self.paths.contains(output)
            || output.canonicalize().is_ok_and(|path| self.paths.contains(&path))
            || file_number(output).is_some_and(|file| self.files.contains(&file))
            || self.sequences.iter().any(|sequence| is_frame_of(sequence, output));
        if is_input {
            return Err(ImageError::Refused {
                path: output.to_owned(),
                what: "is read by this job and would be written over".to_owned(),
                hint: "give another output path (-o)".to_owned(),
            });
        }
        check_replaceable(output)
    }

    /// As [`Self::refuse`]; and refuses what is there unless it may be replaced.
    ///
    /// # Errors
    /// [`ImageError::Refused`].
    #[cfg(feature = "cli")]
    pub(crate) fn allow(&self, output: &Path, existing: Existing) -> Result<(), ImageError> {
        self.refuse(output)?;
        if existing == Existing::Overwrite || !is_there(output) {
            return Ok(());
        }
        Err(ImageError::Refused {
            path: output.to_owned(),
            what: "exists already".to_owned(),
            hint: "use --overwrite to replace it or -o to write another".to_owned(),
        })
    }
}

/// Something has this name, be it a link to nowhere.
#[must_use]
pub(crate) fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Whether the pattern gives this name in this folder.
fn is_frame_of(sequence: &SequencePath, path: &Path) -> bool {
    let Some(frame) = path.file_name().and_then(|name| sequence.frame_named(name.to_str()?)) else { return false };
    let [ours, theirs] = [&sequence.path_of(frame), path].map(|path| folder_of(path).canonicalize().ok());
    ours.is_some() && ours == theirs
}

#[cfg(unix)]
fn file_number(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|file| (file.dev(), file.ino()))
}

/// Elsewhere the path with all links resolved decides alone.
#[cfg(not(unix))]
fn file_number(_path: &Path) -> Option<(u64, u64)> {
    None
}
