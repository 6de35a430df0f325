//! The bases of a lattice and their properties; the functions themselves are in `axis`.
//!
//! In: a basis and a number of handles. Out: limits, cells, support.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The functions that blend the handles of a lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// Bernstein polynomials of degree dims − 1 (the paper's).
    Bernstein,
    /// Uniform cubic B-spline: dims − 3 spans, local support.
    #[default]
    Bspline,
    /// Bilinear cells.
    Bilinear,
    /// Cells split along their diagonal, barycentric in each half.
    Barytri,
}

/// The handles with a non-zero weight at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Support {
    /// All handles of the lattice.
    Global,
    /// `width` neighbouring handles on each axis: a tensor product of polynomials of degree width − 1.
    Tensor {
        /// Handles per axis.
        width: usize,
    },
    /// The corners of the simplex that contains the point.
    Simplex,
}

impl Basis {
    /// All bases.
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::Bernstein, Self::Bspline, Self::Bilinear, Self::Barytri];

    /// Returns the name for messages; files use the serde name.
    #[must_use]
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::Bernstein => "Bernstein",
            Self::Bspline => "B-spline",
            Self::Bilinear => "bilinear",
            Self::Barytri => "barycentric",
        }
    }

    /// Returns the handles with a non-zero weight at a point.
    #[must_use]
    pub(crate) const fn support(self) -> Support {
        match self {
            Self::Bernstein => Support::Global,
            Self::Bspline => Support::Tensor { width: 4 },
            Self::Bilinear => Support::Tensor { width: 2 },
            Self::Barytri => Support::Simplex,
        }
    }

    /// Returns the number of handles outside the box at each end of an axis.
    #[must_use]
    pub(crate) const fn margin(self) -> usize {
        match self {
            Self::Bspline => 1,
            Self::Bernstein | Self::Bilinear | Self::Barytri => 0,
        }
    }

    /// Returns the minimum number of handles of an axis, which is that of one span.
    #[must_use]
    pub(crate) const fn min_handles(self) -> usize {
        2 + 2 * self.margin()
    }

    /// Returns the number of spans of an axis with `count` handles; for Bernstein, the intervals of the control polygon.
    #[must_use]
    pub(crate) const fn spans(self, count: usize) -> usize {
        count - 1 - 2 * self.margin()
    }

    /// Whether each handle influences only a few cells.
    #[must_use]
    pub(crate) fn is_local(self) -> bool {
        self.support() != Support::Global
    }

    /// Whether lattices with this basis can branch: each handle influences a box of cells.
    #[must_use]
    pub(crate) const fn can_branch(self) -> bool {
        matches!(self.support(), Support::Tensor { .. })
    }

    /// Whether the lattice interpolates its handles linearly along the axes, so that its gradient jumps between cells.
    #[must_use]
    pub(crate) fn is_piecewise_linear(self) -> bool {
        matches!(self.support(), Support::Tensor { width: 2 } | Support::Simplex)
    }

    /// Returns the number of rings of handles at the border of the grid that influence the border of the box.
    #[must_use]
    pub(crate) const fn border_rings(self) -> usize {
        1 + 2 * self.margin()
    }

    /// Returns the number of handles with a non-zero weight at a point of a lattice with `dims` handles per axis.
    #[must_use]
    pub(crate) fn handles_at_point<const D: usize>(self, dims: [usize; D]) -> usize {
        match self.support() {
            Support::Global => dims.iter().product(),
            Support::Tensor { width } => width.pow(D as u32),
            Support::Simplex => D + 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Grid;

    #[test]
    fn facts_agree_with_the_weights_of_a_grid() {
        for basis in Basis::ALL {
            let least = basis.min_handles();
            assert_eq!(basis.spans(least), 1, "{basis:?}");
            let grid = Grid { dims: [least + 3, least + 2], basis, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
            assert!(grid.check().is_ok() && Grid { dims: [least - 1, 9], ..grid.clone() }.check().is_err());
            let inside = grid.weights([0.41, 0.27]);
            assert_eq!(inside.len(), basis.handles_at_point(grid.dims), "{basis:?}");
            let acting = grid.weights([0.0, 0.27]).into_iter().filter(|(_, weight)| *weight != 0.0);
            let columns: Vec<usize> = acting.map(|(handle, _)| grid.handle_coords(handle)[0]).collect();
            assert_eq!(columns.iter().max().map(|most| most + 1), Some(basis.border_rings()), "{basis:?}");
            let first = grid.rest_handle(0)[0];
            assert!((first + basis.margin() as f64 * grid.spacing(0)).abs() < 1e-15, "{basis:?}: {first}");
        }
    }
}
