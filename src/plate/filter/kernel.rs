//! The inner loops: weighted sums of texels.
//!
//! In: texels from a pixel's first tap on, weights. Out: the sum, four planes at once.

use super::block::Texel;
use super::profile::{Weights, catmull_rom, fma};
use super::shape::Shape;

/// Texels of two neighbours.
type Pair = [f32; 8];

/// Two texels as one register.
#[inline(always)]
fn pair(texels: &[Texel]) -> Pair {
    let [a, b] = [texels[0], texels[1]];
    [a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]
}

#[inline(always)]
fn add<const FUSED: bool>(sum: &mut Pair, weights: &Pair, texels: &Pair) {
    (0..8).for_each(|k| sum[k] = fma::<FUSED>(weights[k], texels[k], sum[k]));
}

#[inline(always)]
fn twice(a: f32, b: f32) -> Pair {
    [a, a, a, a, b, b, b, b]
}

#[inline(always)]
fn halves(sum: &Pair) -> Texel {
    std::array::from_fn(|k| sum[k] + sum[k + 4])
}

/// A separable filter of 2·`PAIRS` taps a side; `texels` begins at the first tap.
#[inline(always)]
pub(super) fn separable<const PAIRS: usize, const FUSED: bool>(
    texels: &[Texel],
    stride: usize,
    across: &Weights,
    down: &Weights,
) -> Texel {
    let mut columns = [[0.0; 8]; PAIRS];
    for (row, weight) in down[..2 * PAIRS].iter().enumerate() {
        let taps = &texels[row * stride..][..2 * PAIRS];
        for (k, column) in columns.iter_mut().enumerate() {
            add::<FUSED>(column, &[*weight; 8], &pair(&taps[2 * k..]));
        }
    }
    let mut sum = [0.0; 8];
    for (k, column) in columns.iter().enumerate() {
        add::<FUSED>(&mut sum, &twice(across[2 * k], across[2 * k + 1]), column);
    }
    halves(&sum)
}

/// Catmull-Rom along the axes of a widened footprint, normalised. `texels` is the whole block, `base` the place in it of the sample
/// before the pixel's place, `fraction` how far behind that sample the place lies.
#[inline(always)]
pub(super) fn widened<const FUSED: bool>(
    texels: &[Texel],
    stride: usize,
    base: [usize; 2],
    fraction: [f32; 2],
    shape: &Shape,
) -> Texel {
    let [xx, xy, yy] = shape.filter_from_source;
    let (mut sum, mut weight_sum) = ([0.0; 8], [0.0; 8]);
    let reach = shape.reach.map(|reach| 2.0 * reach);
    for y in (fraction[1] - reach[1]).ceil() as isize..=(fraction[1] + reach[1]).floor() as isize {
        let dy = y as f32 - fraction[1];
        let [low, high] = chord(shape, dy, reach[0]);
        let (first, last) = ((low + fraction[0]).ceil() as isize, (high + fraction[0]).floor() as isize);
        let row = (base[1] as isize + y) as usize * stride;
        for x in (first..=last).step_by(8) {
            let weights: Weights = std::array::from_fn(|k| {
                let dx = x as f32 + k as f32 - fraction[0];
                let across = catmull_rom::<FUSED>(fma::<FUSED>(xx, dx, xy * dy));
                across * catmull_rom::<FUSED>(fma::<FUSED>(xy, dx, yy * dy))
            });
            let taps = &texels[(row as isize + base[0] as isize + x) as usize..][..8];
            for k in 0..4 {
                add::<FUSED>(&mut sum, &twice(weights[2 * k], weights[2 * k + 1]), &pair(&taps[2 * k..]));
            }
            (0..8).for_each(|k| weight_sum[k] += weights[k]);
        }
    }
    let norm = 1.0 / weight_sum.iter().sum::<f32>();
    halves(&sum).map(|x| x * norm)
}

/// Where a row cuts the filter's square of "radius" 2: from and to, in source distances.
#[inline(always)]
fn chord(shape: &Shape, dy: f32, reach: f32) -> [f32; 2] {
    let [xx, xy, yy] = shape.filter_from_source;
    let (low, high) = ((-2.0 - xy * dy) / xx, (2.0 - xy * dy) / xx);
    if xy.abs() < 1e-6 {
        return [low.max(-reach), high.min(reach)];
    }
    let ends = [(-2.0 - yy * dy) / xy, (2.0 - yy * dy) / xy];
    [low.max(ends[0].min(ends[1])).max(-reach), high.min(ends[0].max(ends[1])).min(reach)]
}
