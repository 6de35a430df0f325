//! Textures made by code.
//!
//! In: a function from texture coordinates to linear colour. Out: the bytes of a PNG file, sRGB-encoded.

use glam::{DVec2, DVec3};
use image::{
    ExtendedColorType, ImageEncoder as _, ImageError,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};

/// A linear colour with opacity, not premultiplied.
pub(crate) struct Rgba {
    /// Linear RGB.
    pub(crate) color: DVec3,
    /// 0 is transparent, 1 opaque; clamped.
    pub(crate) alpha: f64,
}

/// A PNG file of a colour function, sampled at texel centres. (0, 0) is the upper left corner.
///
/// # Errors
/// If the encoder fails.
pub(crate) fn png(width: u32, height: u32, color_at: impl Fn(DVec2) -> DVec3) -> Result<Vec<u8>, ImageError> {
    let texels: Vec<u8> =
        texel_centers(width, height).flat_map(|uv| color_at(uv).to_array().map(srgb_from_linear)).collect();
    encoded([width, height], &texels, ExtendedColorType::Rgb8)
}

/// Same as [`png`], with opacity.
///
/// # Errors
/// If the encoder fails.
pub(crate) fn png_rgba(width: u32, height: u32, paint_at: impl Fn(DVec2) -> Rgba) -> Result<Vec<u8>, ImageError> {
    let texel = |uv: DVec2| {
        let Rgba { color, alpha } = paint_at(uv);
        let [r, g, b] = color.to_array().map(srgb_from_linear);
        [r, g, b, (alpha.clamp(0.0, 1.0) * 255.0).round() as u8]
    };
    let texels: Vec<u8> = texel_centers(width, height).flat_map(texel).collect();
    encoded([width, height], &texels, ExtendedColorType::Rgba8)
}

/// Samples rows from the top, with u and v in 0..1.
fn texel_centers(width: u32, height: u32) -> impl Iterator<Item = DVec2> {
    let center = |index: u32, count: u32| (f64::from(index) + 0.5) / f64::from(count);
    (0..height)
        .flat_map(move |row| (0..width).map(move |column| DVec2::new(center(column, width), center(row, height))))
}

fn encoded([width, height]: [u32; 2], texels: &[u8], color: ExtendedColorType) -> Result<Vec<u8>, ImageError> {
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(texels, width, height, color)?;
    Ok(file)
}

/// The sRGB byte of a linear value.
fn srgb_from_linear(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// 0 below `from`, 1 above `to`, with a smooth transition.
pub(crate) fn smoothstep(from: f64, to: f64, value: f64) -> f64 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
