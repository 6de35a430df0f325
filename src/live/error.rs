//! What can go wrong on the way from parameters to pixels.

use crate::image::ImageError;
use crate::memory::OverBudget;
use crate::pipeline::PipelineError;
use crate::scene::SceneError;
use crate::shot::ShotError;
use crate::space::ScreenPoint;
use crate::spelling::counted;
use std::path::PathBuf;

/// A warp that cannot be computed, or a picture that was not finished.
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
    /// A pin or its target lies nowhere near the picture.
    #[error("pin {} lies at {}, {} and goes to {}, {}; give places in frame heights, within 1000 of the frame", pin + 1, rest.0.x, rest.0.y, target.0.x, target.0.y)]
    FarPin {
        /// Index in the controls.
        pin: usize,
        /// Where it is.
        rest: ScreenPoint,
        /// Where it goes.
        target: ScreenPoint,
    },
    /// The shot file is wrong.
    #[error(transparent)]
    Shot(#[from] ShotError),
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The shot does not fit its scene, or cannot be solved.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] ImageError),
    /// The shot shows another frame than the picture.
    #[error("{path} is for frames {wanted:.4} wide to 1 high, the picture is {found:.4} to 1; {hint}")]
    Aspect {
        /// The shot file.
        path: PathBuf,
        /// Its aspect.
        wanted: f64,
        /// That of the picture.
        found: f64,
        /// How to fix it.
        hint: &'static str,
    },
    /// A layer that cannot be driven.
    #[error("{path}: {what}; {hint}")]
    Layer {
        /// The shot file.
        path: PathBuf,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// A lattice whose matrices do not fit into the memory budget.
    #[error("a lattice of {} x {} handles {source}; fewer columns and rows, or B-splines, take less", dims[0], dims[1])]
    Memory {
        /// Handles across and up.
        dims: [usize; 2],
        /// What it needs, and what there is.
        source: OverBudget,
    },
    /// Planes that are not as large as their window.
    #[error(
        "a plane of {what} has {} for {}; this is a fault of the host's adapter",
        counted(*found, "sample", "samples"),
        counted(*wanted, "pixel", "pixels")
    )]
    Planes {
        /// Which picture.
        what: &'static str,
        /// Samples.
        found: usize,
        /// Pixels.
        wanted: usize,
    },
    /// A background of other channels.
    #[error(
        "the background has {}, the source {wanted}; give both the same",
        counted(*found, "channel", "channels")
    )]
    PlaneCount {
        /// Those of the background.
        found: usize,
        /// Those of the source.
        wanted: usize,
    },
    /// The host cancelled the render.
    #[error("the render was cancelled")]
    Aborted,
}
