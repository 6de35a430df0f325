//! What can go wrong in a solve.

use crate::lattice::LatticeError;

/// A problem that cannot be solved.
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
    /// Nothing decides where some handles go.
    #[error("the equations of {what} have no single solution; {hint}")]
    Singular {
        /// Energy and regulariser.
        what: String,
        /// How to fix it.
        hint: String,
    },
}
