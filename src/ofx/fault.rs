//! What can go wrong between host and plugin, and the status that says so.
//!
//! In: the cause. Out: words for the user and a [`Status`] for the host.

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
    /// The host lacks something, or gives what cannot be used.
    #[error(transparent)]
    Host(#[from] HostError),
    /// The shape comes from a shot file, and none is named.
    #[error("Shape from is set to Shot file, but Shot file is empty; name a .toml file, or choose another shape")]
    NoShotFile,
    /// A button needs a path.
    #[error("{0} is empty; name a file to write")]
    NoPath(&'static str),
    /// A name of STMaps that is none.
    #[error("{0} is no name of a file: leave out folders, the number and its signs")]
    BadName(String),
    /// A pin that cannot be meant.
    #[error("pin {number} lies at {}, {} px and goes to {}, {} px, far outside the picture; bring it back", ends[0][0], ends[0][1], ends[1][0], ends[1][1])]
    FarPin {
        /// As users count.
        number: usize,
        /// Its place and its target.
        ends: [[f64; 2]; 2],
    },
    /// A map cannot be written.
    #[error(transparent)]
    Write(#[from] ImageError),
    /// The engine cannot do it.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// A picture that does not fit into the memory budget.
    #[error("a picture of {} x {} pixels {source}", size[0], size[1])]
    Memory {
        /// Pixels across and down.
        size: [u32; 2],
        /// What it needs, and what there is.
        source: OverBudget,
    },
    /// The user's limit cannot be read.
    #[error("{0}; correct it and start the host anew")]
    Limit(String),
    /// A panic.
    #[error("pinwarp stumbled over a fault of its own: {0}; please report this with your project")]
    Panic(String),
    /// The host wants the result no more.
    #[error("stopped by the host")]
    Aborted,
}

impl Fault {
    /// Whether the host itself stopped the work.
    pub(super) fn is_abort(&self) -> bool {
        matches!(self, Self::Aborted | Self::Live(LiveError::Aborted))
    }

    /// The status that tells the host.
    pub(super) fn status(&self) -> Status {
        let mut causes = std::iter::successors(self.source(), |error| (*error).source());
        if causes.any(|error| error.is::<OverBudget>()) {
            return Status::ERR_MEMORY;
        }
        match self {
            Self::Host(HostError::MissingSuite(_)) => Status::ERR_MISSING_HOST_FEATURE,
            Self::Host(HostError::Missing(_)) => Status::ERR_BAD_HANDLE,
            Self::Host(HostError::Image { .. }) => Status::ERR_IMAGE_FORMAT,
            // Hosts that abort throw the frame away; an error would put a message on the screen.
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
