//! The transfer of sRGB (IEC 61966-2-1).
//!
//! In: light, or a code value. Out: the other; both 0 to 1.

pub(super) fn srgb_from_linear(light: f32) -> f32 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// In `f64`, for tables.
pub(super) fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}
