//! Writes integer data as 16-bit PNG files without a colour space, for programs that read data as pictures.
//!
//! In: rows of integers. Out: a PNG file, written atomically.

use super::{FrameMetadata, ImageError, atomic, png_note};
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder};
use std::path::Path;

/// Writes 16-bit numbers as the red, green and blue of a PNG: `codes` are rows from the top, 3 per pixel. The metadata record the frame.
///
/// # Errors
/// [`ImageError`] if the file cannot be written or the picture has no pixels.
pub(crate) fn write_codes(
    path: &Path,
    [width, height]: [u32; 2],
    codes: &[u16],
    metadata: &FrameMetadata,
) -> Result<(), ImageError> {
    if codes.is_empty() || codes.len() != 3 * width as usize * height as usize {
        return Err(ImageError::frame(path, "the picture has no pixels, or not 3 numbers for each"));
    }
    // The encoder expects native byte order.
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_ne_bytes()).collect();
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive)
        .write_image(&bytes, width, height, ExtendedColorType::Rgb16)
        .map_err(|failed| ImageError::frame(path, failed.to_string()))?;
    atomic::replace_bytes(path, &png_note::noted(file, metadata))
}
