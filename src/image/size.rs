//! Reads the size of a picture without decoding it.
//!
//! In: the path of a PNG, JPEG or EXR file. Out: its display window as a [`FrameSize`].

use super::{ImageError, PictureKind};
use crate::space::FrameSize;
use ::image::metadata::Orientation;
use ::image::{ImageDecoder, ImageReader};
use std::path::Path;

/// Returns the size of a picture's display window. Reads only the header.
///
/// # Errors
/// [`ImageError`] if the extension is not that of an EXR, PNG or JPEG file, the file cannot be opened, or its header is damaged.
pub fn picture_size(path: &Path) -> Result<FrameSize, ImageError> {
    if PictureKind::known(path)? == PictureKind::Exr {
        let head = super::exr_guard::read_head(path)?;
        let first = head.headers.first().ok_or_else(|| ImageError::damaged(path, "it has no parts"))?;
        let shared = &first.shared_attributes;
        let [width, height] = [shared.display_window.size.width(), shared.display_window.size.height()]
            .map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        return Ok(FrameSize { width, height, pixel_aspect: f64::from(shared.pixel_aspect) });
    }
    crate::files::check_regular(path).map_err(|source| ImageError::reading(path, source))?;
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

/// The amount of data in a decoded picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PictureExtent {
    /// Pixels of the data windows of all parts, or of the display window if that is larger.
    pub(crate) pixels: u128,
    /// Samples of all channels.
    pub(crate) samples: u128,
}

/// Returns the amount of data in a decoded picture, to estimate memory. Reads only the header.
///
/// # Errors
/// As [`picture_size`].
pub(crate) fn picture_extent(path: &Path) -> Result<PictureExtent, ImageError> {
    let size = picture_size(path)?;
    let shown = u128::from(size.width) * u128::from(size.height);
    if PictureKind::known(path)? != PictureKind::Exr {
        return Ok(PictureExtent { pixels: shown, samples: 4 * shown });
    }
    let head = super::exr_guard::read_head(path)?;
    let parts = head.headers.iter().map(|part| {
        let pixels = part.layer_size.width() as u128 * part.layer_size.height() as u128;
        (pixels, pixels * part.channels.list.len() as u128)
    });
    let (pixels, samples) = parts.fold((0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok(PictureExtent { pixels: pixels.max(shown), samples })
}
