//! The size of a picture, without decoding it.
//!
//! In: the path of a PNG, JPEG or EXR file. Out: its display window as a [`FrameSize`].

use super::{ImageError, PictureKind};
use crate::space::FrameSize;
use ::image::metadata::Orientation;
use ::image::{ImageDecoder, ImageReader};
use exr::meta::MetaData;
use std::path::Path;

/// How large a picture is as the viewer sees it. Only its head is read.
///
/// # Errors
/// [`ImageError`] where the name is none of an EXR, PNG or JPEG file, where it cannot be opened or its head is damaged.
pub fn picture_size(path: &Path) -> Result<FrameSize, ImageError> {
    if PictureKind::known(path)? == PictureKind::Exr {
        let head =
            MetaData::read_from_file(path, false).map_err(|failed| super::exr_guard::read_error(path, failed))?;
        let first = head.headers.first().ok_or_else(|| ImageError::damaged(path, "it has no parts"))?;
        let shared = &first.shared_attributes;
        let [width, height] = [shared.display_window.size.width(), shared.display_window.size.height()]
            .map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        return Ok(FrameSize { width, height, pixel_aspect: f64::from(shared.pixel_aspect) });
    }
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let reader = reader.map_err(|source| ImageError::reading(path, source))?;
    let mut decoder = reader.into_decoder().map_err(|failed| ImageError::damaged(path, failed.to_string()))?;
    let (width, height) = decoder.dimensions();
    let is_lying = matches!(
        decoder.orientation().unwrap_or(Orientation::NoTransforms),
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH
    );
    Ok(if is_lying { FrameSize::new(height, width) } else { FrameSize::new(width, height) })
}
