//! Arguments shared by several commands.

use super::progress::ProgressForm;
use crate::image::{Durability, Existing};
use crate::raster::DeviceChoice;
use crate::scene::FileAccess;
use crate::shot::{Shot, ShotError};
use clap::builder::TypedValueParser;
use std::path::Path;

/// The files that a scene may refer to.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct OutsideArg {
    /// Also read buffers and images that lie outside the scene's folder.
    #[arg(long)]
    allow_outside: bool,
}

impl OutsideArg {
    /// Reads a shot file, with the file access that the user allows.
    pub(super) fn read(self, path: &Path) -> Result<Shot, ShotError> {
        Ok(self.allow(Shot::read(path)?))
    }

    /// Sets the file access that the user allows.
    pub(super) fn allow(self, shot: Shot) -> Shot {
        Shot { allow_outside: self.allow_outside, ..shot }
    }

    /// Returns the file access, for a scene opened without a shot.
    pub(super) const fn access(self) -> FileAccess {
        if self.allow_outside { FileAccess::Anywhere } else { FileAccess::SceneFolder }
    }
}

/// How to treat existing frames; without a flag, they are an error.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct ExistingArgs {
    /// Keep existing frames that are up to date and render the others.
    ///
    /// A frame is kept if its file is complete and records that it was made by the same version of pinwarp from the same state of
    /// the shot, in the same size and on the same class of device. Every other frame is rendered again, and the reason is given.
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// With --resume: read kept frames completely and compare their pixels with their checksums.
    #[arg(long, requires = "resume")]
    verify: bool,
    /// Replace existing files.
    #[arg(long)]
    overwrite: bool,
}

/// How to treat an existing file.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct OverwriteArg {
    /// Replace an existing file.
    #[arg(long)]
    overwrite: bool,
}

impl From<OverwriteArg> for Existing {
    fn from(arg: OverwriteArg) -> Self {
        if arg.overwrite { Self::Overwrite } else { Self::Refuse }
    }
}

/// When a file counts as written.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct FsyncArg {
    /// Wait until every frame is stored on the disk before it gets its final name.
    ///
    /// Finished frames then survive a power failure. Without this flag they survive the end of the program, even a crash.
    #[arg(long)]
    fsync: bool,
}

/// How to print progress; without a flag, as text with a progress bar.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct ProgressArgs {
    /// Print one JSON event per line instead of text and a progress bar.
    ///
    /// The events for frames are started, note, frame_redone, frame_done, frame_failed and finished; those of `bake` are note,
    /// started, progress, layer_done, layer_failed and finished. The last event contains the totals.
    #[arg(long, conflicts_with = "openjd")]
    json: bool,
    /// Also print openjd_progress and openjd_status lines for an Open Job Description scheduler.
    #[arg(long)]
    openjd: bool,
}

impl From<ProgressArgs> for ProgressForm {
    fn from(args: ProgressArgs) -> Self {
        match args {
            ProgressArgs { json: true, .. } => Self::Json,
            ProgressArgs { openjd: true, .. } => Self::OpenJd,
            _ => Self::Words,
        }
    }
}

impl From<FsyncArg> for Durability {
    fn from(arg: FsyncArg) -> Self {
        if arg.fsync { Self::Synced } else { Self::Cached }
    }
}

impl From<ExistingArgs> for Existing {
    fn from(args: ExistingArgs) -> Self {
        match args {
            ExistingArgs { verify: true, .. } => Self::Verify,
            ExistingArgs { resume: true, .. } => Self::Resume,
            ExistingArgs { overwrite: true, .. } => Self::Overwrite,
            _ => Self::Refuse,
        }
    }
}

/// Parses `auto`, `cpu`, or a device name.
pub(super) fn device_parser() -> impl TypedValueParser<Value = DeviceChoice> {
    clap::builder::NonEmptyStringValueParser::new().map(|text| DeviceChoice::of_name(&text))
}
