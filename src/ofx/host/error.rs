//! What a host lacks, or gives in a way that cannot be used.
//!
//! In: the cause. Out: words for the user.

use thiserror::Error;

/// Something that the host should have given.
#[derive(Debug, Error)]
pub(in crate::ofx) enum HostError {
    /// The host never introduced itself, or lacks a suite that every host has to offer.
    #[error("the host offers no {0}; pinwarp needs it")]
    MissingSuite(&'static str),
    /// A handle that should be there is not.
    #[error("the host gave no {0}")]
    Missing(&'static str),
    /// An image that cannot be read or written.
    #[error("{clip}: {what}")]
    Image {
        /// The clip.
        clip: String,
        /// What is wrong with its image, and what would be right.
        what: String,
    },
}
