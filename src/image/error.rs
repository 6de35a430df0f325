//! Errors of reading and writing pictures.

use crate::memory::OverBudget;
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// An error of reading or writing a picture. Each message says what is wrong, where, and how to fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// An error of the file system.
    #[error("cannot {action} {}: {source}{}", path.display(), remedy(path, source.kind()))]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// The underlying error.
        source: Error,
    },
    /// The frame cannot be stored as requested.
    #[error("cannot write {}: {what}", path.display())]
    Frame {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong with the frame, and how to fix it.
        what: String,
    },
    /// The file violates its format, or is truncated.
    #[error("{} is damaged: {what}; render or export it again", path.display())]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The file is valid, but uses features that are not supported.
    #[error("{} cannot be used: {what}", path.display())]
    Unsupported {
        /// Path of the file.
        path: PathBuf,
        /// The unsupported feature, and what to export instead.
        what: String,
    },
    /// A file that must not be written.
    #[error("{} {what}; {hint}", path.display())]
    Refused {
        /// Path of the file.
        path: PathBuf,
        /// The reason.
        what: String,
        /// What to do instead.
        hint: String,
    },
    /// The file is valid, but decoding it would exceed the memory limit.
    #[error("{} {source}", path.display())]
    TooLarge {
        /// Path of the file.
        path: PathBuf,
        /// The required and the available memory.
        source: OverBudget,
    },
    /// A path that does not name a frame or a sequence.
    #[error("the path {} {what}", pattern.display())]
    Pattern {
        /// The path as given.
        pattern: PathBuf,
        /// What is wrong with it, and what to write instead.
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

/// Returns advice for the user, starting with `; `, or an empty string.
fn remedy(path: &Path, kind: ErrorKind) -> &'static str {
    match kind {
        // Windows denies access to a folder that is opened as a file.
        ErrorKind::PermissionDenied if path.is_dir() => "; a folder of that name exists",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space or choose another output folder (frames already written are whole)"
        }
        ErrorKind::PermissionDenied => "; check who may write there, or choose another output folder",
        ErrorKind::ReadOnlyFilesystem => "; the disk is mounted read-only, choose another output folder",
        ErrorKind::NotFound => "; check the path for typing errors",
        ErrorKind::NotADirectory => "; a part of the path is a file, not a folder",
        ErrorKind::IsADirectory => "; a folder of that name exists",
        ErrorKind::InvalidFilename => "; choose a shorter or simpler name",
        _ => "",
    }
}
