//! What can go wrong while a shot is prepared or rendered.

use crate::image::ImageError;
use crate::raster::RasterError;
use crate::scene::{FindError, SceneError};
use crate::shot::ShotError;
use crate::solve::SolveError;
use std::path::PathBuf;

/// A shot that cannot be rendered, or a frame of it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The shot file is wrong.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The shot names a camera or clip that the scene does not have.
    #[error("{path}: {source}")]
    Find {
        /// The shot file.
        path: PathBuf,
        /// What is not there.
        source: FindError,
    },
    /// Drawing failed.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// A file could not be written or read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A layer could not be solved.
    #[error("layer '{layer}', frame {frame}: {source}")]
    Solve {
        /// Which layer.
        layer: String,
        /// At which (fractional) frame.
        frame: f64,
        /// Why.
        source: SolveError,
    },
    /// The shot and its scene do not fit together.
    #[error("{path}: {what}; {hint}")]
    Mismatch {
        /// The shot file.
        path: PathBuf,
        /// What does not fit.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// Frames are already there.
    #[error(
        "{count} of the frames exist already, the first is {first}; use --resume to keep or --overwrite to replace them"
    )]
    Exists {
        /// How many.
        count: usize,
        /// The first of them.
        first: PathBuf,
    },
    /// A frame was given up in the middle.
    #[error("frame {frame} was given up before all its passes were drawn")]
    Interrupted {
        /// Which.
        frame: i32,
    },
    /// The output folder cannot be made or written to.
    #[error("cannot write into the folder {path}: {source}; check its permissions or give another output path (-o)")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}
