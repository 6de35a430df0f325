//! Stage 4: grids of handles, their bases, and the forward free-form deformation (2D and 3D).
//!
//! In: a rest box, dims, a basis and moved handles. Out: weights, gradients, warped points.

use crate::space::{ScreenBox, ScreenPoint};
use glam::DMat2;
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

    /// The lattice whose handles are at rest: it warps nothing.
    #[must_use]
    pub fn at_rest(&self) -> ScreenLattice {
        todo!("lattice helper")
    }
}

impl Lattice<2> {
    /// Where the lattice carries a point. Outside the box: the displacement of the nearest box point.
    #[must_use]
    pub fn warp(&self, point: ScreenPoint) -> ScreenPoint {
        point
    }

    /// The gradient of [`Self::warp`] at a point (identity-like outside the box).
    #[must_use]
    pub fn jacobian(&self, point: ScreenPoint) -> DMat2 {
        let _ = point;
        DMat2::IDENTITY
    }

    /// Cells between handles (column, row), 0..dims−1, in which the warp turns over (det J ≤ 0 at any probe point).
    #[must_use]
    pub fn folded_cells(&self) -> Vec<[usize; 2]> {
        Vec::new()
    }
}
