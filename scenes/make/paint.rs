//! Pictures drawn by code.
//!
//! In: a function from texture coordinates to linear colour. Out: the bytes of a PNG file, sRGB-encoded.

use glam::{DVec2, DVec3};
use image::{ExtendedColorType, ImageEncoder as _, ImageError, codecs::png::PngEncoder};

/// The PNG of a colour function, sampled at texel centres; (0, 0) is the upper left corner.
///
/// # Errors
/// Where the encoder fails.
pub(crate) fn png(width: u32, height: u32, color_at: impl Fn(DVec2) -> DVec3) -> Result<Vec<u8>, ImageError> {
    let size = DVec2::new(f64::from(width), f64::from(height));
    let mut rgb = Vec::with_capacity((width * height * 3) as usize);
    for row in 0..height {
        for column in 0..width {
            let uv = (DVec2::new(f64::from(column), f64::from(row)) + 0.5) / size;
            rgb.extend(color_at(uv).to_array().map(srgb_from_linear));
        }
    }
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(&rgb, width, height, ExtendedColorType::Rgb8)?;
    Ok(file)
}

/// The sRGB byte of a linear value.
fn srgb_from_linear(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(crate) fn smoothstep(from: f64, to: f64, value: f64) -> f64 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
