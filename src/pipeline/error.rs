//! The errors of preparing and rendering a shot.

use crate::export::ExportError;
use crate::image::ImageError;
use crate::plate::PlateError;
use crate::raster::RasterError;
use crate::scene::{FindError, SceneError};
use crate::shot::{Shot, ShotError};
use crate::solve::SolveError;
use crate::spelling::pluralised;
use std::path::PathBuf;

/// An error that prevents a shot, or one of its frames, from being rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The shot file is invalid.
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
        /// The name that was not found.
        source: FindError,
    },
    /// Drawing failed.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// An image file could not be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A lattice file cannot be read.
    #[error(transparent)]
    Lattice(#[from] ExportError),
    /// A layer could not be solved.
    #[error("layer '{layer}', frame {frame}: {source}")]
    Solve {
        /// Name of the layer.
        layer: String,
        /// The (fractional) frame.
        frame: f64,
        /// The cause.
        source: SolveError,
    },
    /// The shot does not match its scene.
    #[error("{path}:{line}: {key}: {what}; {hint}")]
    Mismatch {
        /// The shot file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The key as a path: `layer[0].pin[2].anchor`.
        key: String,
        /// The mismatch.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A plate cannot be warped as the shot requests.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// A picture given as an STMap is not one, or belongs to a plate of another size.
    #[error("{path}: {source}")]
    StMap {
        /// The picture.
        path: PathBuf,
        /// The cause.
        source: PlateError,
    },
    /// A clean plate cannot fill the holes of its plate.
    #[error("{path}: {source}")]
    CleanPlate {
        /// The clean plate.
        path: PathBuf,
        /// The cause.
        source: PlateError,
    },
    /// The request cannot be fulfilled.
    #[error("{what}; {hint}")]
    Unusable {
        /// The problem and its reason.
        what: String,
        /// The remedy.
        hint: String,
    },
    /// Output frames exist already.
    #[error(
        "{} already, the first is {first}; use --resume to keep or --overwrite to replace what is there",
        pluralised(*count, "of the frames exists", "of the frames exist")
    )]
    Exists {
        /// Number of existing frames.
        count: usize,
        /// The first existing frame.
        first: PathBuf,
    },
    /// Another process is rendering the same frames.
    #[error(
        "process {process} is writing frame {frame} into {} too; wait for it, choose other frames (--frames) or another \
         output path (-o)",
        folder.display()
    )]
    Busy {
        /// Its process id.
        process: u32,
        /// A frame that both processes would write.
        frame: i32,
        /// The output folder.
        folder: PathBuf,
    },
    /// A frame was abandoned before it was complete.
    #[error("frame {frame} was abandoned before all its passes were drawn")]
    Interrupted {
        /// The frame.
        frame: i32,
    },
    /// The output folder cannot be created or written to.
    #[error("cannot write into the folder {path}: {source}; check its permissions or give another output path (-o)")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
}

impl PipelineError {
    /// Creates the error for a key of the shot that does not match the scene.
    pub(super) fn mismatch(shot: &Shot, key: &str, what: impl Into<String>, hint: impl Into<String>) -> Self {
        let (path, line) = (shot.path.clone(), shot.lines.of(key));
        Self::Mismatch { path, line, key: key.to_owned(), what: what.into(), hint: hint.into() }
    }

    /// Creates the error for a camera or clip that the scene does not have.
    pub(super) fn find(shot: &Shot, key: &str, source: FindError) -> Self {
        Self::Find { path: shot.path.clone(), line: shot.lines.of(key), key: key.to_owned(), source }
    }
}
