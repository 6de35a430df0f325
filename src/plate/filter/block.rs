//! A part of the source, made ready for filters: four planes side by side, borders filled in, no infinities.
//!
//! In: planes, a rectangle of samples that may reach over their borders. Out: texels; and where samples are not a
//! number, texels that say so.

use super::Planes;
use super::border::Extent;

/// What infinities become: the greatest finite half, as sums of it stay finite.
const GREATEST: f32 = 65504.0;
/// Texels after the last that kernels may read (times a weight of 0).
const SPARE: usize = 8;

/// Four planes' samples at one place.
pub(super) type Texel = [f32; 4];

/// A rectangle of the source; may reach over its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reach {
    /// First sample on both axes.
    pub(super) low: [i32; 2],
    /// One after the last.
    pub(super) high: [i32; 2],
}

impl Reach {
    pub(super) fn size(&self, axis: usize) -> usize {
        (self.high[axis] - self.low[axis]).max(0) as usize
    }
}

/// Texels of a rectangle, rows from the top.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// First sample on both axes.
    pub(super) low: [i32; 2],
    /// Texels of a row.
    pub(super) stride: usize,
    /// Samples; 0 for what is not a number.
    pub(super) texels: Vec<Texel>,
    /// 1 for numbers, 0 for what is none; empty where all are numbers.
    pub(super) presence: Vec<Texel>,
}

impl Block {
    /// Reads a rectangle of up to four planes.
    pub(super) fn fill(&mut self, source: &Planes, extents: &[Extent; 2], reach: &Reach) {
        self.low = reach.low;
        self.stride = reach.size(0);
        self.texels.clear();
        self.texels.resize(self.stride * reach.size(1) + SPARE, [0.0; 4]);
        self.presence.clear();
        let mut all_finite = true;
        for (row, texels) in self.texels.chunks_exact_mut(self.stride).take(reach.size(1)).enumerate() {
            if let Some(y) = extents[1].sample(reach.low[1] + row as i32) {
                all_finite &= fill_row(source, y, &extents[0], reach.low[0], texels);
            }
        }
        if !all_finite {
            self.contain();
        }
    }

    /// Replaces what is no finite number.
    fn contain(&mut self) {
        let lacks = self.texels.iter().flatten().any(|sample| sample.is_nan());
        if lacks {
            self.presence.extend(self.texels.iter().map(|texel| texel.map(|x| f32::from(u8::from(!x.is_nan())))));
        }
        for sample in self.texels.iter_mut().flatten() {
            *sample = if sample.is_nan() { 0.0 } else { finite(*sample) };
        }
    }
}

/// Infinities as [`GREATEST`]; other samples as they are.
fn finite(sample: f32) -> f32 {
    if sample.is_infinite() { GREATEST.copysign(sample) } else { sample }
}

/// Reads a row from sample `low`; whether all samples are finite.
fn fill_row(source: &Planes, y: usize, extent: &Extent, low: i32, texels: &mut [Texel]) -> bool {
    let count = extent.count;
    let begin = low.clamp(0, count);
    let end = (low + texels.len() as i32).clamp(begin, count);
    let (before, inside) = texels.split_at_mut((begin - low).clamp(0, texels.len() as i32) as usize);
    let (inside, after) = inside.split_at_mut((end - begin) as usize);
    let row = y * count as usize;
    let planes: Vec<&[f32]> =
        source.planes.iter().map(|plane| &plane[row + begin as usize..row + end as usize]).collect();
    let texel_at = |x: usize| std::array::from_fn(|k| source.planes.get(k).map_or(0.0, |plane| plane[row + x]));
    let beyond = |texels: &mut [Texel], place: i32| {
        if let Some(x) = extent.sample(place) {
            texels.fill(texel_at(x));
        }
    };
    beyond(before, -1);
    beyond(after, count);
    interleave(&planes, inside);
    let held = before.iter().chain(after.iter()).flatten().all(|sample| sample.is_finite());
    inside.iter().flatten().fold(true, |all, sample| all & sample.is_finite()) & held
}

/// Puts planes side by side; missing ones are left 0.
fn interleave(planes: &[&[f32]], texels: &mut [Texel]) {
    if let [r, g, b, a] = planes {
        for ((((texel, r), g), b), a) in texels.iter_mut().zip(*r).zip(*g).zip(*b).zip(*a) {
            *texel = [*r, *g, *b, *a];
        }
        return;
    }
    for (k, plane) in planes.iter().enumerate() {
        texels.iter_mut().zip(*plane).for_each(|(texel, sample)| texel[k] = *sample);
    }
}
