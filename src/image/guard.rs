//! The rule for all output files: never an input, only regular files, and existing files only if permitted.
//!
//! In: the files that a job reads, and an output path. Out: permission, or [`ImageError::Refused`].

use super::atomic::{check_replaceable, folder_of};
use super::{ImageError, SequencePath};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Treatment of existing files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Refuse to write.
    #[default]
    Refuse,
    /// Replace them.
    Overwrite,
    /// Keep frames whose headers show that the same job would write them again; write all others.
    Resume,
    /// As [`Self::Resume`], and also verify the checksums of the pixels of kept frames.
    Verify,
}

impl Existing {
    /// Whether finished frames are kept.
    #[must_use]
    pub(crate) const fn is_resume(self) -> bool {
        matches!(self, Self::Resume | Self::Verify)
    }
}

/// All inputs of a job, which must not be overwritten.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inputs {
    /// Paths as given, and their canonical forms.
    paths: BTreeSet<PathBuf>,
    /// Device and inode numbers, to recognise hard links and names in other letter case.
    files: BTreeSet<(u64, u64)>,
    sequences: Vec<SequencePath>,
}

impl Inputs {
    /// Adds a file, whether it exists or not.
    pub(crate) fn add(&mut self, path: &Path) {
        self.paths.extend(path.canonicalize());
        self.paths.insert(path.to_owned());
        self.files.extend(file_number(path));
    }

    /// Adds a sequence: its existing frames, and every name that matches its pattern.
    ///
    /// # Errors
    /// [`ImageError::Io`] if the directory cannot be listed.
    pub(crate) fn add_sequence(&mut self, sequence: &SequencePath) -> Result<(), ImageError> {
        match sequence.frames_on_disk()? {
            Some(frames) => frames.into_iter().for_each(|frame| self.add(&sequence.path_of(frame))),
            None => self.add(&sequence.path_of(0)),
        }
        self.sequences.push(sequence.clone());
        Ok(())
    }

    /// Refuses inputs, under any name, and anything but regular files.
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
                what: "is an input of this job and would be overwritten".to_owned(),
                hint: "give another output path (-o)".to_owned(),
            });
        }
        check_replaceable(output)
    }

    /// As [`Self::refuse`]; also refuses existing files unless they may be replaced.
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

/// Whether the path exists, including dangling symbolic links.
#[must_use]
pub(crate) fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Whether the path is a frame of the sequence.
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

/// On other systems only canonical paths are compared.
#[cfg(not(unix))]
fn file_number(_path: &Path) -> Option<(u64, u64)> {
    None
}
