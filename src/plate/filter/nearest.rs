//! Nearest-neighbour lookup.
//!
//! In: offsets of a row of pixels. Out: indices of the nearest source samples; bit-exact copies of them.

use super::border::Extent;
use crate::plate::WarpMap;
use crate::simd::dispatch;
use crate::space::PixelRect;
use pulp::{Simd, WithSimd};

/// Marks a position outside the picture.
pub(crate) const NOWHERE: u32 = u32::MAX;

/// Returns the index of the source sample nearest to a position; [`NOWHERE`] outside the picture and for NaN offsets.
/// `start` is the pixel's own position, in samples of the source.
#[inline(always)]
pub(super) fn nearest_sample(offset: [f32; 2], start: [i32; 2], extents: &[Extent; 2]) -> u32 {
    let x = start[0] as f32 + rounded(offset[0]);
    let y = start[1] as f32 + rounded(offset[1]);
    let is_inside = (x >= 0.0) & (y >= 0.0) & (x < extents[0].count as f32) & (y < extents[1].count as f32);
    let index = (y as i32).wrapping_mul(extents[0].count).wrapping_add(x as i32);
    if is_inside { index as u32 } else { NOWHERE }
}

/// Rounds to the nearest integer, halves up. Adding 0.5 first would round the sum.
#[inline(always)]
fn rounded(x: f32) -> f32 {
    let whole = x.floor();
    if x - whole >= 0.5 { whole + 1.0 } else { whole }
}

/// Finds the nearest samples of adjacent pixels.
pub(super) struct FindNearest<'a> {
    pub(super) offsets: &'a [[f32; 2]],
    /// Position of the first pixel, in samples of the source.
    pub(super) start: [i32; 2],
    pub(super) extents: &'a [Extent; 2],
    /// One per offset.
    pub(super) samples: &'a mut [u32],
}

impl WithSimd for FindNearest<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let [x, y] = self.start;
        for (k, (sample, offset)) in self.samples.iter_mut().zip(self.offsets).enumerate() {
            *sample = nearest_sample(*offset, [x + k as i32, y], self.extents);
        }
    }
}

/// Finds the nearest samples for the pixels of a row of the map from column `first` on, as indices into a source window
/// of fewer than 2^32 samples.
pub(crate) fn nearest_in_row(map: &WarpMap, [first, row]: [usize; 2], source: PixelRect, samples: &mut [u32]) {
    let offsets = &map.offsets[row * map.window.width as usize + first..][..samples.len()];
    let extents = &Extent::of_window(source, map.frame.window());
    let start = [map.window.x + first as i32 - source.x, map.window.y + row as i32 - source.y];
    dispatch(FindNearest { offsets, start, extents, samples });
}

/// Copies samples by index; `empty` for indices outside the picture.
#[inline(always)]
pub(crate) fn copy_samples(from: &[f32], samples: &[u32], empty: f32, to: &mut [f32]) {
    for (to, sample) in to.iter_mut().zip(samples) {
        *to = from.get(*sample as usize).copied().unwrap_or(empty);
    }
}
