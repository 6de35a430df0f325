//! Errors of problem files.

use crate::solve::error::SolveError;
use std::path::PathBuf;

/// A problem file that cannot be solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Something in a file is wrong.
    #[error("{}: {source}", path.display())]
    In {
        /// The file.
        path: PathBuf,
        /// What.
        source: Box<ProblemError>,
    },
    /// The text is not JSON of the right form.
    #[error("not a problem file: {0}")]
    Json(#[from] serde_json::Error),
    /// A key has an invalid value.
    #[error("`{key}`: {what}; {hint}")]
    Key {
        /// The key, with its index in a list.
        key: String,
        /// What is wrong.
        what: String,
        /// How to fix it.
        hint: String,
    },
    /// The solver reports an error.
    #[error(transparent)]
    Solve(#[from] SolveError),
}

impl ProblemError {
    pub(super) fn key(key: impl Into<String>, what: impl Into<String>, hint: impl Into<String>) -> Self {
        Self::Key { key: key.into(), what: what.into(), hint: hint.into() }
    }
}
