//! What can go wrong while pictures are read and written.

use crate::memory::OverBudget;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// A picture that cannot be read or written. Each message says what, where and how to fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file system said no.
    #[error("cannot {action} {}: {source}{}", path.display(), remedy(source.kind()))]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: Error,
    },
    /// The frame cannot be stored as asked.
    #[error("cannot write {}: {what}", path.display())]
    Frame {
        /// The file that was to be written.
        path: PathBuf,
        /// What is wrong with the frame, and what to do.
        what: String,
    },
    /// The file breaks its format, or ends too early.
    #[error("{} is damaged: {what}; render or export it again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The file is sound, but holds something that pinwarp does not read.
    #[error("{} cannot be used: {what}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it holds, and what to export instead.
        what: String,
    },
    /// A file that must not be written.
    #[error("{} {what}; {hint}", path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// Why.
        what: String,
        /// What to do instead.
        hint: String,
    },
    /// The file is sound, but decoding it would take more memory than may be used.
    #[error("{} {source}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What it needs.
        source: OverBudget,
    },
    /// A path that does not name a frame or a sequence.
    #[error("the path {} {what}", pattern.display())]
    Pattern {
        /// The path as given.
        pattern: PathBuf,
        /// What is wrong with it, and what to write.
        what: String,
    },
}

impl ImageError {
    pub(super) fn reading(path: &Path, source: Error) -> Self {
        Self::Io { action: "read", path: path.to_owned(), source }
    }

    pub(super) fn writing(path: &Path, source: Error) -> Self {
        Self::Io { action: "write", path: path.to_owned(), source }
    }

    pub(super) fn frame(path: &Path, what: impl Into<String>) -> Self {
        Self::Frame { path: path.to_owned(), what: what.into() }
    }

    pub(super) fn damaged(path: &Path, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), what: what.into() }
    }

    pub(super) fn unsupported(path: &Path, what: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), what: what.into() }
    }
}

/// What the user can do about it; starts with `; `, or is empty.
fn remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space or choose another output folder (frames already written are whole)"
        }
        ErrorKind::PermissionDenied => "; check who may write there, or choose another output folder",
        ErrorKind::ReadOnlyFilesystem => "; the disk is mounted read-only, choose another output folder",
        ErrorKind::NotFound => "; check the path for typing errors",
        ErrorKind::NotADirectory => "; a part of the path is a file, not a folder",
        ErrorKind::IsADirectory => "; a folder of that name is in the way",
        ErrorKind::InvalidFilename => "; choose a shorter or simpler name",
        _ => "",
    }
}
