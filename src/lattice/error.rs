//! What can be wrong with a grid.

use crate::spelling::counted;

/// A grid that is not valid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// Too few or too many handles on an axis.
    #[error(
        "the lattice has {} on axis {axis}, but the {basis:?} basis needs {least} to {most}; change `dims`",
        counted(*found, "handle", "handles")
    )]
    Dims {
        /// Axis, 0 = x.
        axis: usize,
        /// Handles requested.
        found: usize,
        /// Minimum of the basis.
        least: usize,
        /// Maximum supported.
        most: usize,
        /// The basis.
        basis: super::basis::Basis,
    },
    /// Too many handles on all axes together.
    #[error(
        "the lattice has {found} handles in all, too many to solve; change `dims` so that their product is at most {most}"
    )]
    Size {
        /// Product of the dims.
        found: usize,
        /// Maximum supported.
        most: usize,
    },
    /// The box has no extent, or a corner is not a number.
    #[error("the lattice box spans {lo} to {hi} on axis {axis}; give it a finite size above zero")]
    Box {
        /// Axis, 0 = x.
        axis: usize,
        /// Lower bound.
        lo: f64,
        /// Upper bound.
        hi: f64,
    },
}
