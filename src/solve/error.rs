//! Errors of the solver.

use super::cancel::Cancelled;
use crate::lattice::LatticeError;

/// A problem that cannot be solved, or a cancelled solve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The problem contradicts itself.
    #[error("the problem is not valid: {what}; {hint}")]
    Invalid {
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// The lattice cannot be built.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The matrix is singular: some handles are not constrained.
    #[error("the equations of {what} have no single solution; {hint}")]
    Singular {
        /// Energy and regulariser whose equations are singular.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// The caller cancelled the solve, see [`super::Cancel`].
    #[error("the solve was cancelled")]
    Cancelled,
}

impl From<Cancelled> for SolveError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}
