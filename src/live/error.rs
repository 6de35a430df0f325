//! Errors of warps from plain parameters.

use crate::image::ImageError;
use crate::memory::OverBudget;
use crate::pipeline::PipelineError;
use crate::scene::SceneError;
use crate::shot::ShotError;
use crate::space::ScreenPoint;
use crate::spelling::pluralised;
use std::path::PathBuf;

/// The error of a warp that cannot be computed, or of a picture that was not completed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// A parameter is out of range.
    #[error("{what}; {hint}")]
    Controls {
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A pin or its target is too far from the picture.
    #[error(
        "pin {} lies at {}, {} and goes to {}, {}; give positions in frame heights, within 1000 of the frame",
        pin + 1,
        rest.0.x,
        rest.0.y,
        target.0.x,
        target.0.y
    )]
    FarPin {
        /// Its index in the controls.
        pin: usize,
        /// Its rest position.
        rest: ScreenPoint,
        /// Its target.
        target: ScreenPoint,
    },
    /// The shot file is invalid.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The shot does not match its scene, or cannot be solved.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] ImageError),
    /// The frame of the shot does not have the aspect ratio of the picture.
    #[error("{path} is for frames {wanted:.4} wide to 1 high, the picture is {found:.4} to 1; {hint}")]
    Aspect {
        /// The shot file.
        path: PathBuf,
        /// Its aspect ratio.
        wanted: f64,
        /// The aspect ratio of the picture.
        found: f64,
        /// How to fix it.
        hint: &'static str,
    },
    /// The layer of a shot cannot be controlled by these parameters, or cannot be written to the file.
    #[error("{path}: {what}; {hint}")]
    Layer {
        /// The shot file.
        path: PathBuf,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// The matrices of the lattice do not fit into the memory limit.
    #[error("a lattice of {} x {} handles {source}; fewer columns and rows, or B-splines, take less", dims[0], dims[1])]
    Memory {
        /// Number of handles along x and y.
        dims: [usize; 2],
        /// The required and the available memory.
        source: OverBudget,
    },
    /// A plane does not have one sample per pixel of its window.
    #[error(
        "a plane of {what} has {} for {}; this is a fault of the host's adapter",
        pluralised(*found, "sample", "samples"),
        pluralised(*wanted, "pixel", "pixels")
    )]
    Planes {
        /// The name of the picture.
        what: &'static str,
        /// Number of samples.
        found: usize,
        /// Number of pixels.
        wanted: usize,
    },
    /// The background and the source differ in their number of channels.
    #[error(
        "the background has {}, the source {wanted}; give both the same",
        pluralised(*found, "channel", "channels")
    )]
    PlaneCount {
        /// Number of channels of the background.
        found: usize,
        /// Number of channels of the source.
        wanted: usize,
    },
    /// The host cancelled the render.
    #[error("the render was cancelled")]
    Aborted,
}
