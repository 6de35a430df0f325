//! Converts a frame for display: 8-bit sRGB with straight alpha.
//!
//! In: [`Frame`] (scene-linear, associated alpha). Out: [`Preview`], the size of the display window; PNG files.

use super::atomic::{self, Destination};
use super::srgb::srgb_byte;
use super::{Frame, FrameMetadata, ImageError, png_note};
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use std::path::Path;

/// An 8-bit picture: sRGB transfer, straight (unassociated) alpha, rows from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, alpha of each pixel: 4 × width × height bytes.
    pub rgba: Vec<u8>,
}

impl Preview {
    /// Creates a fully transparent picture.
    #[must_use]
    pub fn transparent(width: u32, height: u32) -> Self {
        Self { width, height, rgba: vec![0; 4 * width as usize * height as usize] }
    }

    /// Returns red, green, blue, alpha at column `x` and row `y`; `None` outside.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        let index = self.index(x, y)?;
        self.rgba[index..].first_chunk().copied()
    }

    pub(super) fn pixel_mut(&mut self, x: u32, y: u32) -> Option<&mut [u8; 4]> {
        let index = self.index(x, y)?;
        self.rgba[index..].first_chunk_mut()
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| 4 * (y as usize * self.width as usize + x as usize))
    }
}

/// Converts the display window of a frame: channels R, G, B with alpha. Missing colour channels are black; without A the data window is
/// opaque. Values are clipped at 1, without tone mapping or exposure. The pixel aspect is not corrected.
///
/// Where light exceeds its alpha (a glow with alpha 0, a highlight on an edge), alpha is raised so that it shows, since
/// straight 8-bit pixels cannot represent it otherwise.
#[must_use]
pub fn preview(frame: &Frame) -> Preview {
    let mut picture = Preview::transparent(frame.display.width, frame.display.height);
    let samples = |name| frame.channel(name).map(|channel| channel.samples.as_slice());
    let channels = [samples("R"), samples("G"), samples("B"), samples("A")];
    let window = frame.data_window;
    let width = picture.width as usize;
    picture.rgba.par_chunks_exact_mut(4 * width.max(1)).enumerate().for_each(|(y, row)| {
        let down = y as i64 + i64::from(frame.display.y) - i64::from(window.y);
        if !(0..i64::from(window.height)).contains(&down) {
            return;
        }
        for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
            let across = x as i64 + i64::from(frame.display.x) - i64::from(window.x);
            if (0..i64::from(window.width)).contains(&across) {
                let index = (down * i64::from(window.width) + across) as usize;
                let [red, green, blue, alpha] = channels.map(|samples| samples.map(|samples| samples[index]));
                let color = [red, green, blue].map(Option::unwrap_or_default);
                pixel.copy_from_slice(&straight_srgb(color, alpha.unwrap_or(1.0)));
            }
        }
    });
    picture
}

fn straight_srgb(color: [f32; 3], alpha: f32) -> [u8; 4] {
    let color = color.map(|light| if light.is_nan() { 0.0 } else { light.max(0.0) });
    let strongest = color.into_iter().fold(0.0, f32::max);
    // f32::max returns the other operand if alpha is NaN.
    let alpha = alpha.max(strongest).clamp(0.0, 1.0);
    if alpha == 0.0 {
        return [0; 4];
    }
    let [red, green, blue] = color.map(|light| srgb_byte((light / alpha).min(1.0)));
    [red, green, blue, byte(alpha)]
}

fn byte(unit: f32) -> u8 {
    (unit * 255.0).round() as u8
}

/// Writes a picture as PNG, atomically like [`super::write_exr`].
///
/// # Errors
/// [`ImageError`] if the file cannot be written or the picture has no pixels.
pub fn write_png(path: &Path, picture: &Preview) -> Result<(), ImageError> {
    atomic::replace_bytes(path, &png_bytes(path, picture)?)
}

/// Writes the preview of a frame as PNG, with the same provenance metadata as EXR files.
///
/// # Errors
/// As [`write_png`].
pub(crate) fn write_frame_preview<'a>(
    to: impl Into<Destination<'a>>,
    picture: &Preview,
    metadata: &FrameMetadata,
) -> Result<(), ImageError> {
    let to = to.into();
    let bytes = png_note::noted(png_bytes(to.path, picture)?, metadata);
    atomic::replace_bytes(to, &bytes)
}

/// Encodes a picture as PNG in memory; `path` is only used in messages.
///
/// # Errors
/// [`ImageError`] if the picture has no pixels.
pub fn png_bytes(path: &Path, picture: &Preview) -> Result<Vec<u8>, ImageError> {
    let bytes_needed = 4 * picture.width as usize * picture.height as usize;
    if bytes_needed == 0 || picture.rgba.len() != bytes_needed {
        return Err(ImageError::frame(path, "the preview has no pixels, or not 4 bytes for each"));
    }
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive);
    encoder
        .write_image(&picture.rgba, picture.width, picture.height, ExtendedColorType::Rgba8)
        .map_err(|failed| ImageError::frame(path, failed.to_string()))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middle_grey_is_118_and_alpha_is_divided_out() {
        assert_eq!(straight_srgb([0.18; 3], 1.0), [118, 118, 118, 255]);
        assert_eq!(straight_srgb([0.09; 3], 0.5), [118, 118, 118, 128]);
        assert_eq!(straight_srgb([1.0, 0.0, 2.0], 1.0), [255, 0, 255, 255]);
        assert_eq!(straight_srgb([0.0; 3], 0.0), [0; 4]);
    }

    #[test]
    fn light_without_alpha_shows() {
        let [red, .., alpha] = straight_srgb([0.5, 0.0, 0.0], 0.0);
        assert_eq!((red, alpha), (255, 128));
    }

    #[test]
    fn hostile_samples_stay_in_range() {
        assert_eq!(straight_srgb([f32::NAN; 3], f32::NAN), [0; 4]);
        assert_eq!(straight_srgb([f32::INFINITY, -1.0, f32::NAN], 1.0), [255, 0, 0, 255]);
        assert_eq!(straight_srgb([0.5; 3], f32::NEG_INFINITY)[3], 128);
    }
}
