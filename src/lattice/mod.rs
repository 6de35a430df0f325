//! Stage 4: grids of handles, their bases, and the forward free-form deformation (2D and 3D).
//!
//! In: a rest box, dims, a basis and moved handles. Out: weights, gradients, warped points.

mod axis;
mod display;
mod error;
mod fit;
mod folds;
mod forward;
mod grid;
mod patch;
mod placed;
mod transfer;

pub(crate) use axis::bernstein_values;
pub use axis::{AxisTerms, MAX_HANDLES, MAX_HANDLES_IN_ALL};
pub use display::DisplayWarp;
pub use error::LatticeError;
pub use fit::Fitted;
pub use folds::Folds;
pub use forward::Carried;
pub use grid::Term;
pub use placed::{BoxFrame, SceneLattice};
pub use transfer::Fit;

use crate::space::ScreenBox;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The functions that blend handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Bernstein polynomials of degree dims − 1 (the paper's).
    Bernstein,
    /// Uniform cubic B-spline: dims − 3 spans, local support.
    Bspline,
    /// Bilinear cells.
    Bilinear,
    /// Cells split along their diagonal, barycentric in each half.
    Barytri,
}

/// A grid of handles over a rest box, in D dimensions. Handle index h = i + nx·(j + ny·k).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Handles per axis.
    pub dims: [usize; D],
    /// How they are blended.
    pub basis: Basis,
    /// Lower corner of the rest box.
    pub lo: [f64; D],
    /// Upper corner of the rest box.
    pub hi: [f64; D],
}

/// A grid with moved handles.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice<const D: usize> {
    /// Its rest state.
    pub grid: Grid<D>,
    /// Where the handles are: #handles, x fastest.
    pub handles: Vec<[f64; D]>,
}

/// A lattice of screen space.
pub type ScreenLattice = Lattice<2>;

impl Grid<2> {
    /// A grid over a box of the screen.
    #[must_use]
    pub fn over(bounds: ScreenBox, dims: [usize; 2], basis: Basis) -> Self {
        Self { dims, basis, lo: bounds.min.0.to_array(), hi: bounds.max.0.to_array() }
    }
}
