//! Errors of grid validation.

use crate::spelling::pluralised;

/// An invalid grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LatticeError {
    /// Too few or too many handles on an axis.
    #[error(
        "the lattice has {} on axis {axis}, but the {basis:?} basis needs {least} to {most}; change `dims`",
        pluralised(*found, "handle", "handles")
    )]
    Dims {
        /// Axis, 0 = x.
        axis: usize,
        /// Number of handles requested.
        found: usize,
        /// Minimum for the basis.
        least: usize,
        /// Maximum supported.
        most: usize,
        /// The basis.
        basis: super::basis::Basis,
    },
    /// Too many handles in total.
    #[error(
        "the lattice has {found} handles in all, too many to solve; change `dims` so that their product is at most {most}"
    )]
    Size {
        /// Product of the dims.
        found: usize,
        /// Maximum supported.
        most: usize,
    },
    /// The box is empty, or a corner is not finite.
    #[error("the lattice box spans {lo} to {hi} on axis {axis}; give it a finite size above zero")]
    Box {
        /// Axis, 0 = x.
        axis: usize,
        /// Lower bound.
        lo: f64,
        /// Upper bound.
        hi: f64,
    },
    /// The angle of the box is not finite.
    #[error("the lattice box is rotated by {angle} radians; give a finite angle")]
    Angle {
        /// The angle.
        angle: f64,
    },
}
