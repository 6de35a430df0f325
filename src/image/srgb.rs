//! The sRGB transfer function (IEC 61966-2-1).
//!
//! In: linear light or a code value, 0 to 1. Out: the other.

use std::sync::LazyLock;

pub(super) fn srgb_from_linear(light: f32) -> f32 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the 8-bit code of a light from 0 to 1: `srgb_from_linear` rounded, from a table of the thresholds of the codes.
pub(super) fn srgb_byte(light: f32) -> u8 {
    // Negative zero has large bits.
    if light <= 0.0 {
        return 0;
    }
    let codes = &*CODES;
    let bucket = (light.to_bits() >> BUCKET_BITS).saturating_sub(MIN_BUCKET) as usize;
    let mut code = codes.first[bucket.min(codes.first.len() - 1)];
    while code < 255 && light >= codes.begin[usize::from(code) + 1] {
        code += 1;
    }
    code
}

/// Floats that share their upper bits share a bucket; one or two codes begin in each.
const BUCKET_BITS: u32 = 16;

/// The bucket of 2^-14; it and everything below have code 0.
const MIN_BUCKET: u32 = (1.0_f32 / 16384.0).to_bits() >> BUCKET_BITS;

struct Codes {
    /// The least light of each code.
    begin: [f32; 256],
    /// The code of the least light of each bucket.
    first: Vec<u8>,
}

static CODES: LazyLock<Codes> = LazyLock::new(|| {
    let code = |light: f32| (srgb_from_linear(light) * 255.0).round() as u8;
    let mut begin = [0.0_f32; 256];
    for (wanted, begin) in begin.iter_mut().enumerate().skip(1) {
        // Positive floats are ordered by their bits, and codes are monotonic.
        let (mut low, mut high) = (0, 1.0_f32.to_bits());
        while low < high {
            let middle = low + (high - low) / 2;
            if usize::from(code(f32::from_bits(middle))) < wanted { low = middle + 1 } else { high = middle }
        }
        *begin = f32::from_bits(low);
    }
    let last = 1.0_f32.to_bits() >> BUCKET_BITS;
    let first = (MIN_BUCKET..=last).map(|bucket| code(f32::from_bits(bucket << BUCKET_BITS))).collect();
    Codes { begin, first }
});

/// Decodes in `f64`, for tables.
pub(super) fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_from_the_table_are_those_of_the_formula() {
        let formula = |light: f32| (srgb_from_linear(light) * 255.0).round() as u8;
        let steps = (0..=1.0_f32.to_bits()).step_by(9973).map(f32::from_bits);
        let at_codes =
            CODES.begin.iter().flat_map(|&light| [light.next_down().max(0.0), light, light.next_up().min(1.0)]);
        for light in steps.chain(at_codes).chain([0.0, -0.0, 1.0, 0.003_130_8]) {
            assert_eq!(srgb_byte(light), formula(light), "{light}");
        }
    }
}
