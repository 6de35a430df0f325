//! What can go wrong between host and plugin, and the status that says so.
//!
//! In: the cause. Out: words for the user and a [`Status`] for the host.

use super::api::Status;
use thiserror::Error;

/// A failed action.
#[derive(Debug, Error)]
pub(super) enum Fault {
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
    /// The host wants the result no more.
    #[error("stopped by the host")]
    Aborted,
}

impl Fault {
    /// The status that tells the host.
    pub(super) fn status(&self) -> Status {
        match self {
            Self::MissingSuite(_) => Status::ERR_MISSING_HOST_FEATURE,
            Self::Missing(_) => Status::ERR_BAD_HANDLE,
            Self::Image { .. } => Status::ERR_IMAGE_FORMAT,
            // Hosts that abort throw the frame away; an error here would put a message on the screen.
            Self::Aborted => Status::OK,
        }
    }
}
