//! Mip chains: successively smaller copies of an image, averaged in linear light.
//!
//! In: an [`Image`] as stored (RGBA8). Out: levels as stored, down to 1x1. Both rasterisers use these chains.

use crate::scene::Image;
use glam::Vec4;
use rayon::prelude::*;
use std::sync::LazyLock;

/// One level of a mip chain: RGBA8, rows from the top, colour encoded as in the image.
#[derive(Clone, Debug, Default)]
pub(crate) struct Level {
    /// Texels across.
    pub(crate) width: u32,
    /// Texels down.
    pub(crate) height: u32,
    /// width · height.
    pub(crate) texels: Vec<[u8; 4]>,
}

/// Linear value of an sRGB-encoded byte (IEC 61966-2-1).
pub(super) static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

/// Linear value of a byte of data.
pub(super) static LINEAR_FROM_BYTE: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| byte as f32 / 255.0));

/// Returns all levels of an image, the first its own texels, the last 1x1. An empty image becomes one white texel.
pub(crate) fn mip_chain(image: &Image) -> Vec<Level> {
    let texels: Vec<[u8; 4]> = image.rgba.chunks_exact(4).map(|rgba| [rgba[0], rgba[1], rgba[2], rgba[3]]).collect();
    let is_whole = !texels.is_empty() && texels.len() == image.width as usize * image.height as usize;
    if !is_whole {
        return vec![Level { width: 1, height: 1, texels: vec![[255; 4]] }];
    }
    let mut levels = vec![Level { width: image.width, height: image.height, texels }];
    while let Some(last) = levels.last().filter(|last| last.width > 1 || last.height > 1) {
        let next = halved(last, image.is_srgb);
        levels.push(next);
    }
    levels
}

/// Returns a level of half the size, rounded down, each texel the exact mean over the area it covers.
fn halved(from: &Level, is_srgb: bool) -> Level {
    let (width, height) = ((from.width / 2).max(1), (from.height / 2).max(1));
    let columns: Vec<Span> = (0..width).map(|x| span(x, width, from.width)).collect();
    let texels = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let rows = span(y, height, from.height);
            columns.iter().map(move |columns| encode(mean(from, columns, &rows, is_srgb), is_srgb))
        })
        .collect();
    Level { width, height, texels }
}

/// First source texel and the weights of it and its successors (two, or three if the size is odd); they sum to 1.
type Span = (u32, [f32; 3]);

/// Returns the source texels, out of `source`, that the texel at `index` of `count` covers.
fn span(index: u32, count: u32, source: u32) -> Span {
    let ratio = f64::from(source) / f64::from(count);
    let (from, to) = (f64::from(index) * ratio, f64::from(index + 1) * ratio);
    let first = from.floor();
    let weights = [0.0, 1.0, 2.0].map(|k| {
        let overlap = (first + k + 1.0).min(to) - (first + k).max(from);
        (overlap.max(0.0) / ratio) as f32
    });
    (first as u32, weights)
}

/// Returns the linear mean over a span of texels; colour is weighted by alpha, so hidden colours do not bleed in.
fn mean(from: &Level, columns: &Span, rows: &Span, is_srgb: bool) -> Vec4 {
    let (mut plain, mut covered) = (Vec4::ZERO, Vec4::ZERO);
    for (dy, row_weight) in rows.1.iter().enumerate() {
        let y = (rows.0 as usize + dy).min(from.height as usize - 1);
        for (dx, weight) in columns.1.iter().enumerate() {
            let x = (columns.0 as usize + dx).min(from.width as usize - 1);
            let texel = decode(from.texels[y * from.width as usize + x], is_srgb) * (row_weight * weight);
            plain += texel;
            covered += decode(from.texels[y * from.width as usize + x], is_srgb) * (texel.w);
        }
    }
    if is_srgb && plain.w > 1e-4 { (covered.truncate() / plain.w).extend(plain.w) } else { plain }
}

/// Converts a stored texel to linear values.
pub(super) fn decode(texel: [u8; 4], is_srgb: bool) -> Vec4 {
    let colour = if is_srgb { &LINEAR_FROM_SRGB } else { &LINEAR_FROM_BYTE };
    let [r, g, b, a] = texel.map(usize::from);
    Vec4::new(colour[r], colour[g], colour[b], LINEAR_FROM_BYTE[a])
}

/// Converts linear values to a stored texel.
fn encode(linear: Vec4, is_srgb: bool) -> [u8; 4] {
    let encode_one = |x: f32| match is_srgb {
        true if x <= 0.003_130_8 => x * 12.92,
        true => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        false => x,
    };
    let byte = |x: f32| (x * 255.0).round().clamp(0.0, 255.0) as u8;
    [byte(encode_one(linear.x)), byte(encode_one(linear.y)), byte(encode_one(linear.z)), byte(linear.w)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, rgba: Vec<u8>, is_srgb: bool) -> Image {
        Image { width, height, rgba, is_srgb }
    }

    #[test]
    fn black_and_white_average_to_half_the_light_not_half_the_code() {
        let checker = vec![0, 0, 0, 255, 255, 255, 255, 255];
        let levels = mip_chain(&image(2, 1, checker.clone(), true));
        // sRGB code of linear 0.5.
        assert_eq!(levels[1].texels, [[188, 188, 188, 255]]);
        assert_eq!(mip_chain(&image(2, 1, checker, false))[1].texels, [[128, 128, 128, 255]]);
    }

    #[test]
    fn odd_sizes_keep_the_mean() {
        let values = [10, 20, 30, 40, 50];
        let rgba = values.iter().flat_map(|&v| [v, v, v, 255]).collect();
        let levels = mip_chain(&image(5, 1, rgba, false));
        let sizes: Vec<u32> = levels.iter().map(|level| level.width).collect();
        assert_eq!(sizes, [5, 2, 1]);
        // (10 + 20 + 30/2) / 2.5 and (30/2 + 40 + 50) / 2.5.
        assert_eq!(levels[1].texels.iter().map(|texel| texel[0]).collect::<Vec<_>>(), [18, 42]);
        assert_eq!(levels[2].texels[0][0], 30);
    }

    #[test]
    fn hidden_colours_do_not_bleed_in() {
        let levels = mip_chain(&image(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 0], true));
        assert_eq!(levels[1].texels, [[255, 0, 0, 128]]);
    }

    #[test]
    fn a_broken_image_is_white() {
        assert_eq!(mip_chain(&image(4, 4, vec![0; 7], true))[0].texels, [[255; 4]]);
    }
}
