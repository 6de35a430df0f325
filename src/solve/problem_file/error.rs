//! Errors of problem files.

use crate::solve::error::SolveError;
use std::path::PathBuf;

/// A problem file that cannot be read or solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// An error in the contents of a file.
    #[error("{}: {source}", path.display())]
    In {
        /// Path of the file.
        path: PathBuf,
        /// The error.
        source: Box<ProblemError>,
    },
    /// The text is not JSON of the required form.
    #[error("not a problem file: {0}")]
    Json(#[from] serde_json::Error),
    /// A key has an invalid value.
    #[error("`{key}`: {what}; {hint}")]
    Key {
        /// The key, with its index if it is in a list.
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
