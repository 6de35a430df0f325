//! The bases of a lattice: everything in which they differ, except the functions themselves, which are in `axis`.
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

/// Which handles have a weight at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// All handles of the lattice.
    Global,
    /// On each axis `width` neighbouring handles: the tensor product of polynomials of degree width − 1.
    Tensor {
        /// Handles per axis.
        width: usize,
    },
    /// The corners of the simplex that holds the point.
    Simplex,
}

impl Basis {
    /// All bases.
    pub const ALL: [Self; 4] = [Self::Bernstein, Self::Bspline, Self::Bilinear, Self::Barytri];

    /// The name in messages; files use the serde name.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Bernstein => "Bernstein",
            Self::Bspline => "B-spline",
            Self::Bilinear => "bilinear",
            Self::Barytri => "barycentric",
        }
    }

    /// Which handles have a weight at a point.
    #[must_use]
    pub const fn support(self) -> Support {
        match self {
            Self::Bernstein => Support::Global,
            Self::Bspline => Support::Tensor { width: 4 },
            Self::Bilinear => Support::Tensor { width: 2 },
            Self::Barytri => Support::Simplex,
        }
    }

    /// Handles outside the box at each end of an axis.
    #[must_use]
    pub const fn margin(self) -> usize {
        match self {
            Self::Bspline => 1,
            Self::Bernstein | Self::Bilinear | Self::Barytri => 0,
        }
    }

    /// Fewest handles an axis may have: those of one span.
    #[must_use]
    pub const fn min_handles(self) -> usize {
        2 + 2 * self.margin()
    }

    /// Spans of an axis with `count` handles; Bernstein counts its control intervals.
    #[must_use]
    pub const fn spans(self, count: usize) -> usize {
        count - 1 - 2 * self.margin()
    }

    /// Each handle acts on a few cells only.
    #[must_use]
    pub fn is_local(self) -> bool {
        self.support() != Support::Global
    }

    /// The lattice passes through its handles and is linear between them along the axes, so its gradient jumps between cells.
    #[must_use]
    pub fn is_piecewise_linear(self) -> bool {
        matches!(self.support(), Support::Tensor { width: 2 } | Support::Simplex)
    }

    /// Rings of handles at the border of the grid that act on the border of the box.
    #[must_use]
    pub const fn border_rings(self) -> usize {
        1 + 2 * self.margin()
    }

    /// How many handles have a weight at a point of a lattice with `dims` handles per axis.
    #[must_use]
    pub fn handles_at_point<const D: usize>(self, dims: [usize; D]) -> usize {
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
            let grid = Grid { dims: [least + 3, least + 2], basis, lo: [0.0; 2], hi: [1.0; 2] };
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
