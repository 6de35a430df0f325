//! What can go wrong while a shot is prepared or rendered.

use crate::export::ExportError;
use crate::image::ImageError;
use crate::plate::PlateError;
use crate::raster::RasterError;
use crate::scene::{FindError, SceneError};
use crate::shot::{Shot, ShotError};
use crate::solve::SolveError;
use crate::spelling::counted;
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
    #[error("{path}:{line}: {key}: {source}")]
    Find {
        /// The shot file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// `camera` or `frames.clip`.
        key: String,
        /// What is not there.
        source: FindError,
    },
    /// Drawing failed.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// A file could not be written or read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A lattice file cannot be read.
    #[error(transparent)]
    Lattice(#[from] ExportError),
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
    #[error("{path}:{line}: {key}: {what}; {hint}")]
    Mismatch {
        /// The shot file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The key as a path: `layer[0].pin[2].anchor`.
        key: String,
        /// What does not fit.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A plate cannot be warped as the shot asks.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// A picture that was to be an STMap is none, or one for another plate.
    #[error("{path}: {source}")]
    StMap {
        /// The picture.
        path: PathBuf,
        /// Why.
        source: PlateError,
    },
    /// What is asked cannot be done.
    #[error("{what}; {hint}")]
    Unusable {
        /// What, and why not.
        what: String,
        /// What to do instead.
        hint: String,
    },
    /// Frames are already there.
    #[error(
        "{} already, the first is {first}; use --resume to keep or --overwrite to replace what is there",
        counted(*count, "of the frames exists", "of the frames exist")
    )]
    Exists {
        /// How many.
        count: usize,
        /// The first of them.
        first: PathBuf,
    },
    /// Another run is making the same frames.
    #[error(
        "process {process} is writing frame {frame} into {} too; wait for it, choose other frames (--frames) or another \
         output path (-o)",
        folder.display()
    )]
    Busy {
        /// Its process.
        process: u32,
        /// A frame that both make.
        frame: i32,
        /// Where.
        folder: PathBuf,
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

impl PipelineError {
    /// A key of the shot that does not fit the scene.
    pub(super) fn mismatch(shot: &Shot, key: &str, what: impl Into<String>, hint: impl Into<String>) -> Self {
        let (path, line) = (shot.path.clone(), shot.lines.of(key));
        Self::Mismatch { path, line, key: key.to_owned(), what: what.into(), hint: hint.into() }
    }

    /// A camera or clip that the scene does not have.
    pub(super) fn find(shot: &Shot, key: &str, source: FindError) -> Self {
        Self::Find { path: shot.path.clone(), line: shot.lines.of(key), key: key.to_owned(), source }
    }
}
