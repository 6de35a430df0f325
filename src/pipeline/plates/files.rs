//! Plates of any kind of picture file.
//!
//! In: paths. Out: [`Plate`]s, and back; the ending of the name decides.

use crate::image::{ImageError, Plate, is_complete, read_picture, read_plate, write_picture, write_plate};
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
    /// By the ending of the name; `None`: none that is read here.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "exr" => Some(Self::Exr),
            "png" => Some(Self::Png),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            _ => None,
        }
    }
}

/// Reads a picture of any kind.
pub(super) fn read(path: &Path) -> Result<Plate, ImageError> {
    match Kind::of(path) {
        Some(Kind::Png | Kind::Jpeg) => read_picture(path).map(Plate::from_frame),
        Some(Kind::Exr) | None => read_plate(path),
    }
}

/// The display window of a plate, as screen space is measured against it.
///
/// # Errors
/// [`ImageError`] where the plate cannot be read.
pub fn plate_size(path: &Path) -> Result<FrameSize, ImageError> {
    read(path).map(|plate| plate.frame_size())
}

/// Writes a picture of any kind.
pub(super) fn write(path: &Path, plate: Plate) -> Result<(), ImageError> {
    match Kind::of(path) {
        Some(Kind::Png | Kind::Jpeg) => write_picture(path, &plate.into_frame()),
        Some(Kind::Exr) | None => write_plate(path, &plate),
    }
}

/// The file is whole. Pictures that are no EXR files appear whole or not at all.
pub(super) fn is_whole(path: &Path) -> bool {
    if Kind::of(path) == Some(Kind::Exr) { is_complete(path) } else { path.is_file() }
}
