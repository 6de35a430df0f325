//! Errors caused by the host: missing features and unusable data.
//!
//! In: the cause. Out: a message for the user.

use thiserror::Error;

/// A feature or datum that the host failed to provide.
#[derive(Debug, Error)]
pub(in crate::ofx) enum HostError {
    /// The host never called `setHost`, or lacks a mandatory suite.
    #[error("the host offers no {0}; pinwarp needs it")]
    MissingSuite(&'static str),
    /// A handle is missing.
    #[error("the host gave no {0}")]
    Missing(&'static str),
    /// An image cannot be read or written.
    #[error("{clip}: {what}")]
    Image {
        /// The clip's name.
        clip: String,
        /// The problem with its image, and what is supported.
        what: String,
    },
}
