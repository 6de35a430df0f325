//! Errors of lattice files and exports.

use crate::image::ImageError;
use crate::key_fault::KeyFault;
use std::path::{Path, PathBuf};

/// An error of reading or writing exported files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file cannot be opened.
    #[error("cannot read {path}: {source}; check the path and its permissions")]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// The underlying error.
        source: std::io::Error,
    },
    /// The file is not valid JSON of the expected form.
    #[error("{path} is not a lattice file: {source}; lattice files are written by `pinwarp export --to lattice-json`")]
    Json {
        /// Path of the file.
        path: PathBuf,
        /// The parse error, with its position.
        source: serde_json::Error,
    },
    /// A value is invalid.
    #[error("{path}: {key}: {what}; {hint}")]
    Invalid {
        /// Path of the file.
        path: PathBuf,
        /// Key of the value: `layers[0].frames[3].handles`.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// The export exceeds the size limit of .glb files.
    #[error(
        "the scene with its deformed meshes has {bytes} bytes, a .glb file holds 4 GiB; export fewer frames (--frames)"
    )]
    TooLarge {
        /// Size of the file, in bytes.
        bytes: usize,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] ImageError),
}

impl ExportError {
    /// The error of a file with a fault.
    pub(super) fn invalid(path: &Path, KeyFault { key, what, hint }: KeyFault) -> Self {
        Self::Invalid { path: path.to_owned(), key, what, hint }
    }
}
