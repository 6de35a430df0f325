//! What can go wrong in the editor, in words for the person at it.

use crate::image::ImageError;
use crate::pipeline::PipelineError;
use crate::shot::ShotError;
use std::io;
use std::path::PathBuf;

/// An edit, a file or a frame that failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The shot file would be wrong.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The shot cannot be loaded or drawn.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A file could not be written or read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file cannot be read.
    #[error("{path}: {source}; check the name and its permissions")]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The edit asks for something that cannot be.
    #[error("{what}; {hint}")]
    Unusable {
        /// What, and why not.
        what: String,
        /// What to do instead.
        hint: String,
    },
    /// No window can be opened.
    #[error(
        "there is no display to open a window on: {what}; start it in a desktop session (DISPLAY or WAYLAND_DISPLAY is set there), \
         or draw into a file: pinwarp edit SHOT --frame 1 --screenshot out.png"
    )]
    NoDisplay {
        /// What was missing.
        what: String,
    },
}
