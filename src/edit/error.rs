//! Errors of the editor, worded for its user.

use crate::image::ImageError;
use crate::pipeline::PipelineError;
use crate::shot::ShotError;
use std::io;
use std::path::PathBuf;

/// An edit, file or frame that failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum EditError {
    /// The edited shot file would be invalid.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The shot cannot be loaded or rendered.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// An image or other file cannot be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A file cannot be read.
    #[error("{path}: {source}; check the name and its permissions")]
    Io {
        /// Its path.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The requested edit is not possible.
    #[error("{what}; {hint}")]
    Unusable {
        /// What is impossible, and why.
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
        /// The missing display.
        what: String,
    },
}
