//! What can be wrong with a file of lattices.

use crate::image::ImageError;
use std::path::PathBuf;

/// A lattice file that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The file cannot be opened.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is no JSON of the expected form.
    #[error("{path} is no lattice file: {source}; lattice files are written by `pinwarp export --to lattice-json`")]
    Json {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// A value makes no sense.
    #[error("{path}: {key}: {what}; {hint}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The value: `layers[0].frames[3].handles`.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A .glb file cannot hold it.
    #[error(
        "the scene with its deformed meshes has {bytes} bytes, a .glb file holds 4 GiB; export fewer frames (--frames)"
    )]
    TooLarge {
        /// Size of the file.
        bytes: usize,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] ImageError),
}
