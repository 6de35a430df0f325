//! What can go wrong while a shot file is read.

use std::path::PathBuf;

/// A shot that cannot be used. Each message names file, line, key and remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShotError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A key is unknown, missing, of the wrong type or out of range.
    #[error("{path}:{line}: {key}: {what}; {hint}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The key as a path: `layer[0].pin[2].keys[1].ease`.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
}
