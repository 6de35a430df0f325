//! Errors of loading a scene.

use crate::memory::OverBudget;
use std::path::PathBuf;

/// A scene that cannot be loaded. Each message says what is wrong, where, and how to fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file (or a buffer or image beside it) cannot be read.
    #[error("cannot read {path}: {source}; check the path and its permissions")]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The file violates the format.
    #[error("{path} is not valid glTF: {what}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong and where in the file.
        what: String,
    },
    /// The file requires an unsupported feature.
    #[error("{path} needs {what}, which is not supported; {hint}")]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The extension or feature by name.
        what: String,
        /// What to do about it.
        hint: String,
    },
    /// Its textures, vertices and instances exceed the memory budget.
    #[error("{path} ({what}) {source}, smaller textures, or fewer instances")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its contents, counted.
        what: String,
        /// The bytes needed and available.
        source: OverBudget,
    },
    /// A picture is completely transparent.
    #[error(
        "nothing of '{picture}' in {path} can be seen: its alpha is 0 everywhere; take it off the list, or draw on it"
    )]
    Empty {
        /// The file.
        path: PathBuf,
        /// The picture, or the layer of the file.
        picture: String,
    },
}
