//! What can go wrong while a scene is loaded.

use crate::memory::OverBudget;
use std::path::PathBuf;

/// A scene that cannot be loaded. Each message says what, where and how to fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file (or a buffer or image beside it) cannot be read.
    #[error("cannot read {path}: {source}; check the path and its permissions")]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file breaks the format.
    #[error("{path} is not valid glTF: {what}")]
    Invalid {
        /// The file.
        path: PathBuf,
        /// What is wrong and where in the file.
        what: String,
    },
    /// The file needs something pinwarp does not know.
    #[error("{path} needs {what}, which is not supported; {hint}")]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The extension or feature by name.
        what: String,
        /// How to get on.
        hint: String,
    },
    /// Its textures, vertices and instances need more memory than may be used.
    #[error("{path} ({what}) {source}, smaller textures, or fewer instances")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What it holds, counted.
        what: String,
        /// How much it needs and may use.
        source: OverBudget,
    },
    /// Nothing of a picture can be seen.
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
