//! The inner loops of filtering: weighted sums of texels.
//!
//! In: the texels from a pixel's first tap on, weights. Out: the sum for four planes at once. Footprints clamp it to
//! the range of the nearest texels; otherwise, the negative weights next to a flame of 400 would leave a black rim.

use super::block::{Block, Texel};
use super::footprint::Footprint;
use super::positions::SourcePosition;
use super::profile::{Cubic, Lanczos, Profile, Weights, catmull_rom};
use super::simd::{LANES, load, store};
use crate::plate::Filter;
use pulp::{Simd, WithSimd};

/// Lane indices of a register.
const STEPS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Loads the `k`-th pair of texels of a row into one register.
#[inline(always)]
fn pair<S: Simd>(texels: &[f32], k: usize) -> S::f32s {
    load::<S>(texels[LANES * k..].first_chunk().expect("a block ends with spare texels"))
}

/// Returns the weights of two texels in one register.
#[inline(always)]
fn twice<S: Simd>(a: f32, b: f32) -> S::f32s {
    load::<S>(&[a, a, a, a, b, b, b, b])
}

/// Adds the two texels of a register.
#[inline(always)]
fn halves<S: Simd>(sum: S::f32s) -> Texel {
    let sum = store::<S>(sum);
    [sum[0] + sum[4], sum[1] + sum[5], sum[2] + sum[6], sum[3] + sum[7]]
}

/// The minimum and maximum of a set of texels, accumulated in pairs.
#[derive(Clone, Copy)]
struct Range<S: Simd> {
    low: S::f32s,
    high: S::f32s,
}

impl<S: Simd> Range<S> {
    #[inline(always)]
    fn empty(simd: S) -> Self {
        Self { low: simd.splat_f32s(f32::INFINITY), high: simd.splat_f32s(f32::NEG_INFINITY) }
    }

    /// Includes a pair of texels where `out` is 0, and excludes it where `out` is infinite.
    #[inline(always)]
    fn with(self, simd: S, pair: S::f32s, out: S::f32s) -> Self {
        let low = simd.min_f32s(self.low, simd.add_f32s(pair, out));
        Self { low, high: simd.max_f32s(self.high, simd.sub_f32s(pair, out)) }
    }

    /// Clamps a texel to the range. An empty range does not clamp.
    #[inline(always)]
    fn hold(self, texel: Texel) -> Texel {
        let (low, high) = (store::<S>(self.low), store::<S>(self.high));
        std::array::from_fn(|k| {
            let low = if low[k + 4] < low[k] { low[k + 4] } else { low[k] };
            let high = if high[k + 4] > high[k] { high[k + 4] } else { high[k] };
            let held = if texel[k] < low { low } else { texel[k] };
            let held = if held > high { high } else { held };
            if low <= high { held } else { texel[k] }
        })
    }
}

/// Returns the range of the four texels around a position; `texels` starts at the one before it.
#[inline(always)]
fn around<S: Simd>(simd: S, texels: &[Texel], stride: usize) -> Range<S> {
    let nothing = simd.splat_f32s(0.0);
    let row = |y: usize| pair::<S>(texels[y * stride..][..2].as_flattened(), 0);
    Range::empty(simd).with(simd, row(0), nothing).with(simd, row(1), nothing)
}

/// Applies a separable filter of 2·`PAIRS` taps per side; `texels` starts at the first tap.
#[inline(always)]
fn separable<const PAIRS: usize, S: Simd>(
    simd: S,
    texels: &[Texel],
    stride: usize,
    [across, down]: [&Weights; 2],
) -> Texel {
    let mut columns = [simd.splat_f32s(0.0); PAIRS];
    for row in 0..2 * PAIRS {
        let taps = texels[row * stride..][..2 * PAIRS].as_flattened();
        let weight = simd.splat_f32s(down[row]);
        for (k, column) in columns.iter_mut().enumerate() {
            *column = simd.mul_add_e_f32s(weight, pair::<S>(taps, k), *column);
        }
    }
    let mut sum = simd.splat_f32s(0.0);
    for (k, column) in columns.iter().enumerate() {
        sum = simd.mul_add_e_f32s(twice::<S>(across[2 * k], across[2 * k + 1]), *column, sum);
    }
    halves::<S>(sum)
}

/// Whole blocks of texels around a pixel's position.
struct TexelBlocks<'a, const N: usize> {
    texels: [&'a [Texel]; N],
    stride: usize,
    /// Index in the blocks of the sample before the position.
    base: [usize; 2],
}

/// Applies Catmull-Rom along the axes of a widened footprint, normalised; `N` groups of planes share the weights.
/// `fraction` is the distance of the pixel's position from the sample before it.
#[inline(always)]
fn cubic_footprint<const N: usize, S: Simd>(
    simd: S,
    TexelBlocks { texels, stride, base }: TexelBlocks<N>,
    fraction: [f32; 2],
    footprint: &Footprint,
) -> [Texel; N] {
    let (mut sums, mut weight_sum) = ([simd.splat_f32s(0.0); N], simd.splat_f32s(0.0));
    let mut near = [Range::empty(simd); N];
    let half_extent = [2.0 * footprint.half_extent[0], 2.0 * footprint.half_extent[1]];
    let edges = Edges::of(footprint);
    let (mut first, mut last) = whole(fraction[0] - half_extent[0], fraction[0] + half_extent[0]);
    let is_narrow = last - first < LANES as i32;
    let (top, bottom) = whole(fraction[1] - half_extent[1], fraction[1] + half_extent[1]);
    let inner = Inner::of(fraction, footprint);
    for y in top..bottom + 1 {
        let dy = y as f32 - fraction[1];
        if !is_narrow {
            let [low, high] = edges.chord(dy, half_extent[0]);
            (first, last) = whole(fraction[0] + low, fraction[0] + high);
        }
        let row = (base[1] as i32 + y) * stride as i32 + base[0] as i32;
        let mut x = first;
        while x <= last {
            let (weights, out) = weights(simd, [x as f32 - fraction[0], dy], footprint.filter_from_source);
            let taps = texels.map(|texels| texels[(row + x) as usize..][..LANES].as_flattened());
            let (each, out) = (store::<S>(weights), store::<S>(out));
            // Pairs beyond the last sample have weight 0.
            let pairs = ((last - x) as usize / 2 + 1).min(LANES / 2);
            for k in 0..pairs {
                let weight = twice::<S>(each[2 * k], each[2 * k + 1]);
                for (sum, taps) in sums.iter_mut().zip(taps) {
                    *sum = simd.mul_add_e_f32s(weight, pair::<S>(taps, k), *sum);
                }
            }
            for k in inner.pairs(x, y, pairs) {
                let out = twice::<S>(out[2 * k], out[2 * k + 1]);
                for (near, taps) in near.iter_mut().zip(taps) {
                    *near = near.with(simd, pair::<S>(taps, k), out);
                }
            }
            weight_sum = simd.add_f32s(weight_sum, weights);
            x += LANES as i32;
        }
    }
    let norm = 1.0 / simd.reduce_sum_f32s(weight_sum);
    std::array::from_fn(|n| near[n].hold(halves::<S>(sums[n]).map(|value| value * norm)))
}

/// The rectangle of samples around the filter's inner square; only these define the range.
struct Inner {
    low: [i32; 2],
    high: [i32; 2],
}

impl Inner {
    #[inline(always)]
    fn of(fraction: [f32; 2], footprint: &Footprint) -> Self {
        // Slightly enlarged, because rounding decides which samples are inside.
        let half_extent = [1.001 * footprint.half_extent[0], 1.001 * footprint.half_extent[1]];
        let [x, y] = [0, 1].map(|axis| whole(fraction[axis] - half_extent[axis], fraction[axis] + half_extent[axis]));
        Self { low: [x.0, y.0], high: [x.1, y.1] }
    }

    /// Returns which of the `pairs` of samples from sample `x` of row `y` on lie in the rectangle.
    #[inline(always)]
    fn pairs(&self, x: i32, y: i32, pairs: usize) -> std::ops::Range<usize> {
        if y < self.low[1] || y > self.high[1] {
            return 0..0;
        }
        let first = (self.low[0] - x).max(0) as usize / 2;
        let end = ((self.high[0] - x + 2).max(0) as usize / 2).min(pairs);
        first..end
    }
}

/// Returns the weights of eight samples starting at a distance; and 0 for those in the filter's inner square, where the
/// weights are positive, infinity for the others.
#[inline(always)]
fn weights<S: Simd>(simd: S, [dx, dy]: [f32; 2], [xx, xy, yy]: [f32; 3]) -> (S::f32s, S::f32s) {
    let dx = simd.add_f32s(simd.splat_f32s(dx), load::<S>(&STEPS));
    let u = simd.mul_add_e_f32s(simd.splat_f32s(xx), dx, simd.splat_f32s(xy * dy));
    let v = simd.mul_add_e_f32s(simd.splat_f32s(xy), dx, simd.splat_f32s(yy * dy));
    let furthest = simd.max_f32s(simd.abs_f32s(u), simd.abs_f32s(v));
    let is_inside = simd.less_than_f32s(furthest, simd.splat_f32s(1.0));
    let out = simd.select_f32s(is_inside, simd.splat_f32s(0.0), simd.splat_f32s(f32::INFINITY));
    (simd.mul_f32s(catmull_rom(simd, u), catmull_rom(simd, v)), out)
}

/// Returns the first and last integers in a range.
#[inline(always)]
fn whole(low: f32, high: f32) -> (i32, i32) {
    (low.ceil() as i32, high.floor() as i32)
}

/// The edges of a filter's square of "radius" 2 in the source.
struct Edges {
    /// For both pairs of opposite edges: the change per row of the intersection with a row, and half the distance of
    /// the two edges along a row.
    pairs: [[f32; 2]; 2],
}

impl Edges {
    #[inline(always)]
    fn of(footprint: &Footprint) -> Self {
        let [xx, xy, yy] = footprint.filter_from_source;
        // Edges parallel to the rows never intersect them: use a distance larger than any footprint.
        let level = [0.0, 1e6];
        let second = if xy.abs() < 1e-5 { level } else { [-yy / xy, 2.0 / xy.abs()] };
        Self { pairs: [[-xy / xx, 2.0 / xx], second] }
    }

    /// Returns the interval in which a row intersects the square, clamped to `half_extent`.
    #[inline(always)]
    fn chord(&self, dy: f32, half_extent: f32) -> [f32; 2] {
        let [[a, b], [c, d]] = self.pairs;
        let low = (a * dy - b).max(c * dy - d);
        [low.max(-half_extent), (a * dy + b).min(c * dy + d).min(half_extent)]
    }
}

/// Filters an area: `N` groups of up to four planes that share positions and weights.
pub(super) struct Accumulate<'a, const N: usize> {
    pub(super) filter: Filter,
    /// Weights of the Lanczos filter.
    pub(super) table: &'a [Weights],
    /// Per group, the texels or the presence mask of its block.
    pub(super) texels: [&'a [Texel]; N],
    /// Geometry of the blocks, the same for all groups.
    pub(super) block: &'a Block,
    pub(super) positions: &'a [SourcePosition],
    /// One per position, or empty if no footprint is widened.
    pub(super) footprints: &'a [Footprint],
    /// One per position.
    pub(super) sums: &'a mut [[Texel; N]],
}

impl<const N: usize> WithSimd for Accumulate<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let table = self.table;
        match self.filter {
            Filter::Ewa => self.run_footprints(simd),
            Filter::Lanczos => self.run_plain::<3, S>(simd, Lanczos(table)),
            Filter::Cubic | Filter::Nearest => self.run_plain::<2, S>(simd, Cubic),
        }
    }
}

impl<const N: usize> Accumulate<'_, N> {
    /// Applies the same unwidened filter to all pixels.
    #[inline(always)]
    fn run_plain<const PAIRS: usize, S: Simd>(self, simd: S, profile: impl Profile<PAIRS>) {
        let (stride, low) = (self.block.stride, self.block.low);
        let low = [(low[0] + PAIRS as i32 - 1) as f32, (low[1] + PAIRS as i32 - 1) as f32];
        for (position, sums) in self.positions.iter().zip(self.sums) {
            // A NaN position maps to texel 0; its sum is not used.
            let first =
                (position.sample[1] - low[1]) as i32 as usize * stride + (position.sample[0] - low[0]) as i32 as usize;
            let across = profile.weights(simd, position.fraction[0]);
            let down = profile.weights(simd, position.fraction[1]);
            for (sum, texels) in sums.iter_mut().zip(self.texels) {
                let found = separable::<PAIRS, S>(simd, &texels[first..], stride, [&across, &down]);
                *sum = if position.is_nowhere() { [0.0; 4] } else { found };
            }
        }
    }

    /// Filters pixels with individual footprints.
    #[inline(always)]
    fn run_footprints<S: Simd>(self, simd: S) {
        let (stride, low) = (self.block.stride, [self.block.low[0] as f32, self.block.low[1] as f32]);
        for ((position, footprint), sums) in self.positions.iter().zip(self.footprints).zip(self.sums) {
            if position.is_nowhere() {
                *sums = [[0.0; 4]; N];
                continue;
            }
            let base = [(position.sample[0] - low[0]) as i32 as usize, (position.sample[1] - low[1]) as i32 as usize];
            if !footprint.is_unit() {
                let blocks = TexelBlocks { texels: self.texels, stride, base };
                *sums = cubic_footprint(simd, blocks, position.fraction, footprint);
                continue;
            }
            let across = Cubic.weights(simd, position.fraction[0]);
            let down = Cubic.weights(simd, position.fraction[1]);
            let first = (base[1] - 1) * stride + base[0] - 1;
            for (sum, texels) in sums.iter_mut().zip(self.texels) {
                let found = separable::<2, S>(simd, &texels[first..], stride, [&across, &down]);
                *sum = around::<S>(simd, &texels[first + stride + 1..], stride).hold(found);
            }
        }
    }
}
