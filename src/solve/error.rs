//! What can go wrong in a solve.

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
}
