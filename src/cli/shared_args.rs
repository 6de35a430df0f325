//! Arguments that several commands take.

use super::progress::ProgressForm;
use crate::image::{Durability, Existing};
use crate::raster::DeviceChoice;
use crate::scene::FileAccess;
use crate::shot::{Shot, ShotError};
use clap::builder::TypedValueParser;
use std::path::Path;

/// Which files a scene may refer to.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct OutsideArg {
    /// Read buffers and images that the scene names outside its own folder.
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

/// What happens to frames that are already there; without a flag nothing is done.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct ExistingArgs {
    /// Keep the frames that this run would write again, make the rest.
    ///
    /// A frame is kept where its file is complete and says that the same version of pinwarp made it from the same state of
    /// the shot, in the same size, on the same class of device. Every other frame is made again, and the reason is given.
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// With --resume: read kept frames to the end and compare their pixels with their checksums.
    #[arg(long, requires = "resume")]
    verify: bool,
    /// Replace files that are already there.
    #[arg(long)]
    overwrite: bool,
}

/// What happens to a file that is already there.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct OverwriteArg {
    /// Replace a file that is already there.
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
    /// Wait until every frame is on the disk before it gets its name.
    ///
    /// Frames then survive a power failure. Without this flag they survive the end of the program, however it ends.
    #[arg(long)]
    fsync: bool,
}

/// How progress is printed; without a flag as words and a bar.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct ProgressArgs {
    /// Print one JSON event per line instead of words and a progress bar.
    ///
    /// Events of frames are started, note, frame_redone, frame_done, frame_failed and finished, of `bake` note, started, progress,
    /// layer_done, layer_failed and finished; the last holds the totals.
    #[arg(long, conflicts_with = "openjd")]
    json: bool,
    /// Print openjd_progress and openjd_status lines for a scheduler, beside the words.
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
