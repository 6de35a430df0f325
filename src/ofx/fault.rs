//! Errors of the plugin, with the status that reports each to the host.
//!
//! In: the cause. Out: a message for the user and a [`Status`] for the host.

use super::api::Status;
use super::host::HostError;
use crate::image::ImageError;
use crate::live::LiveError;
use crate::memory::OverBudget;
use std::error::Error as _;
use thiserror::Error;

/// A failed action.
#[derive(Debug, Error)]
pub(super) enum Fault {
    /// The host lacks something, or provided something unusable.
    #[error(transparent)]
    Host(#[from] HostError),
    /// The shape comes from a shot file, but none is given.
    #[error("Shape from is set to Shot file, but Shot file is empty; name a .toml file, or choose another shape")]
    NoShotFile,
    /// A button requires a path.
    #[error("{0} is empty; name a file to write")]
    NoPath(&'static str),
    /// An invalid name pattern for STMaps.
    #[error("{0} is not a valid file name: omit folders, frame number and placeholders")]
    BadName(String),
    /// A pin implausibly far from the picture.
    #[error("pin {number} lies at {}, {} px and goes to {}, {} px, far outside the picture; bring it back", ends[0][0], ends[0][1], ends[1][0], ends[1][1])]
    FarPin {
        /// Its number, counted from 1.
        number: usize,
        /// Its rest position and its target.
        ends: [[f64; 2]; 2],
    },
    /// A map could not be written.
    #[error(transparent)]
    Write(#[from] ImageError),
    /// The engine failed.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// A picture exceeds the memory budget.
    #[error("a picture of {} x {} pixels {source}", size[0], size[1])]
    Memory {
        /// Width and height in pixels.
        size: [u32; 2],
        /// The bytes needed and available.
        source: OverBudget,
    },
    /// The user's limit is invalid.
    #[error("{0}; correct it and restart the host")]
    Limit(String),
    /// A panic.
    #[error("internal error in pinwarp: {0}; please report it with your project")]
    Panic(String),
    /// The host no longer needs the result.
    #[error("stopped by the host")]
    Aborted,
}

impl Fault {
    /// Returns whether the host itself aborted the work.
    pub(super) fn is_abort(&self) -> bool {
        matches!(self, Self::Aborted | Self::Live(LiveError::Aborted))
    }

    /// Returns the status that reports the error to the host.
    pub(super) fn status(&self) -> Status {
        let mut causes = std::iter::successors(self.source(), |error| (*error).source());
        if causes.any(|error| error.is::<OverBudget>()) {
            return Status::ERR_MEMORY;
        }
        match self {
            Self::Host(HostError::MissingSuite(_)) => Status::ERR_MISSING_HOST_FEATURE,
            Self::Host(HostError::Missing(_)) => Status::ERR_BAD_HANDLE,
            Self::Host(HostError::Image { .. }) => Status::ERR_IMAGE_FORMAT,
            // A host that aborts discards the frame; an error would show a message to the user.
            Self::Aborted | Self::Live(LiveError::Aborted) => Status::OK,
            Self::NoShotFile
            | Self::NoPath(_)
            | Self::BadName(_)
            | Self::FarPin { .. }
            | Self::Write(_)
            | Self::Live(_)
            | Self::Memory { .. }
            | Self::Limit(_)
            | Self::Panic(_) => Status::FAILED,
        }
    }
}
