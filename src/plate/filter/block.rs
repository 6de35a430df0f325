//! Prepares a region of the source for filtering: interleaves four planes, extends borders, and removes infinities.
//!
//! In: planes, and a rectangle of samples that may extend beyond them. Out: texels, and a mask of NaN samples.

use super::border::Extent;
use pulp::{Simd, WithSimd};

/// Replacement for infinities: the greatest finite half float, since sums of it stay finite.
const MAX_HALF: f32 = 65504.0;
/// Texels after the last that kernels may read (with weight 0).
const PADDING: usize = 8;

/// Samples of four planes at one position.
pub(super) type Texel = [f32; 4];

/// A rectangle of the source; may extend beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SampleRect {
    /// First sample on both axes.
    pub(super) low: [i32; 2],
    /// End (exclusive) on both axes.
    pub(super) high: [i32; 2],
}

impl SampleRect {
    pub(super) fn size(&self, axis: usize) -> usize {
        (self.high[axis] - self.low[axis]).max(0) as usize
    }
}

/// Texels of a rectangle, rows from the top.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// First sample on both axes.
    pub(super) low: [i32; 2],
    /// Texels per row.
    pub(super) stride: usize,
    /// Samples; NaN is replaced by 0.
    pub(super) texels: Vec<Texel>,
    /// 1 for numbers, 0 for NaN; empty if there are no NaN samples.
    pub(super) presence: Vec<Texel>,
}

/// Reads a rectangle of up to four planes into a block.
pub(super) struct FillBlock<'a> {
    pub(super) block: &'a mut Block,
    pub(super) planes: &'a [&'a [f32]],
    pub(super) extents: &'a [Extent; 2],
    pub(super) rect: &'a SampleRect,
}

impl WithSimd for FillBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { block, planes, extents, rect } = self;
        block.low = rect.low;
        block.stride = rect.size(0);
        block.texels.resize(block.stride * rect.size(1) + PADDING, [0.0; 4]);
        block.presence.clear();
        let mut all_finite = true;
        for (row, texels) in block.texels.chunks_exact_mut(block.stride).take(rect.size(1)).enumerate() {
            match extents[1].sample(rect.low[1] + row as i32) {
                Some(y) => all_finite &= fill_row(planes, y, &extents[0], rect.low[0], texels),
                None => texels.fill([0.0; 4]),
            }
        }
        if !all_finite {
            block.contain();
        }
    }
}

impl Block {
    /// Replaces samples that are not finite.
    fn contain(&mut self) {
        let found_nan = self.texels.iter().flatten().any(|sample| sample.is_nan());
        if found_nan {
            self.presence.extend(self.texels.iter().map(|texel| texel.map(|x| f32::from(u8::from(!x.is_nan())))));
        }
        for sample in self.texels.iter_mut().flatten() {
            *sample = if sample.is_nan() { 0.0 } else { finite(*sample) };
        }
    }
}

/// Replaces infinities by ±[`MAX_HALF`].
fn finite(sample: f32) -> f32 {
    if sample.is_infinite() { MAX_HALF.copysign(sample) } else { sample }
}

/// Reads a row from sample `low` on; returns whether all samples are finite.
#[inline(always)]
fn fill_row(planes: &[&[f32]], y: usize, extent: &Extent, low: i32, texels: &mut [Texel]) -> bool {
    let count = extent.count;
    let begin = low.clamp(0, count);
    let end = (low + texels.len() as i32).clamp(begin, count);
    let (before, inside) = texels.split_at_mut((begin - low).clamp(0, texels.len() as i32) as usize);
    let (inside, after) = inside.split_at_mut((end - begin) as usize);
    let row = y * count as usize;
    interleave(planes, row + begin as usize, inside);
    for (texels, place) in [(before, -1), (after, count)] {
        let beyond = |x| std::array::from_fn(|k| planes.get(k).map_or(0.0, |plane| plane[row + x]));
        texels.fill(extent.sample(place).map_or([0.0; 4], beyond));
    }
    // Multiplying by 0 yields 0 or NaN, so the sum needs no branch per sample.
    let mut sum = [0.0; 4];
    for texel in texels {
        for k in 0..4 {
            sum[k] += 0.0 * texel[k];
        }
    }
    sum == [0.0; 4]
}

/// Interleaves planes from a sample on.
#[inline(always)]
fn interleave(planes: &[&[f32]], begin: usize, texels: &mut [Texel]) {
    if let [r, g, b, a] = planes[..] {
        let count = texels.len();
        let [r, g, b, a] = [r, g, b, a].map(|plane| &plane[begin..begin + count]);
        for ((((texel, r), g), b), a) in texels.iter_mut().zip(r).zip(g).zip(b).zip(a) {
            *texel = [*r, *g, *b, *a];
        }
        return;
    }
    texels.fill([0.0; 4]);
    for (k, plane) in planes.iter().enumerate() {
        texels.iter_mut().zip(&plane[begin..]).for_each(|(texel, sample)| texel[k] = *sample);
    }
}
