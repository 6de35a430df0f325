//! Kinds of picture files, told by the endings of their names.
//!
//! In: paths. Out: what they may hold, whether they are whole.

use crate::image::{ImageError, is_complete};
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

/// The file is whole. Pictures that are no EXR files appear whole or not at all.
pub(super) fn is_whole(path: &Path) -> bool {
    if Kind::of(path) == Some(Kind::Exr) { is_complete(path) } else { path.is_file() }
}
