//! Kinds of picture files, told by the endings of their names.
//!
//! In: paths. Out: what they may hold, whether they are whole, how large their frame is.

use crate::image::{ImageError, is_complete, read_any};
use crate::space::FrameSize;
use std::path::Path;

/// Kinds of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Exr,
    Png,
    Jpeg,
}

impl Kind {
    /// `None`: none that is read here.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "exr" => Some(Self::Exr),
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            _ => None,
        }
    }

    /// The kind of a plate.
    pub(super) fn of_plate(path: &Path) -> Result<Self, ImageError> {
        let what = "is not the name of a plate; EXR, PNG and JPEG files can be warped";
        Self::of(path).ok_or_else(|| ImageError::Pattern { pattern: path.to_owned(), what: what.into() })
    }
}

/// The display window of a plate, as screen space is measured against it.
///
/// # Errors
/// [`ImageError`] where the plate cannot be read.
pub fn plate_size(path: &Path) -> Result<FrameSize, ImageError> {
    Kind::of_plate(path)?;
    read_any(path).map(|plate| plate.frame_size())
}

/// The file is whole. Pictures that are no EXR files appear whole or not at all.
pub(super) fn is_whole(path: &Path) -> bool {
    if Kind::of(path) == Some(Kind::Exr) { is_complete(path) } else { path.is_file() }
}
