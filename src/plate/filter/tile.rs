//! Resamples tile by tile, so that the samples of a tile stay in the cache.
//!
//! In: a map and planes. Out: bands of rows. For each tile, positions, footprints and the source rectangle are computed
//! once for all planes (splitting the tile while the rectangle is too large); a few planes at a time are then copied
//! into [`Block`]s and filtered by a kernel without border checks.

use super::Planes;
use super::area::Area;
use super::block::{Block, FillBlock, SampleRect, Texel};
use super::border::{Extent, coverage};
use super::footprint::Footprint;
use super::kernel::Accumulate;
use super::nearest::{FindNearest, copy_samples, nearest_sample};
use super::positions::{FindFootprints, FindPositions, FoundPositions, SourcePosition};
use super::profile::{Weights, lanczos_table};
use crate::plate::{Filter, WarpMap};
use crate::simd::dispatch;
use crate::space::PixelRect;
use pulp::{Simd, WithSimd};

/// Columns per tile.
const TILE: usize = 64;
/// Texels per block, 16 bytes each: half of an L2 cache.
const BLOCK: usize = 1 << 15;
/// Planes interleaved in a block.
const GROUP: usize = 4;
/// Groups that share the weights of a pixel, limited by the registers for their sums.
const GROUPS: usize = 2;
/// A sum that lacks more than three quarters of its weights is treated as missing.
const MIN_PRESENCE: f32 = 0.25;
/// A sum that lacks less than this is complete, so that rounding does not reveal a NaN elsewhere in the tile.
const ROUNDING: f32 = 1e-5;

/// State shared by all tiles of a resampling.
pub(super) struct Tiles<'a> {
    map: &'a WarpMap,
    source: &'a Planes<'a>,
    filter: Filter,
    extents: [Extent; 2],
    table: &'static [Weights],
}

/// Per-thread scratch memory, reused from tile to tile.
#[derive(Default)]
pub(super) struct Scratch {
    blocks: [Block; GROUPS],
    positions: Vec<SourcePosition>,
    footprints: Vec<Footprint>,
    sums: Vec<Texel>,
    presence: Vec<Texel>,
    samples: Vec<u32>,
}

/// An area of the map, and the samples of the source that it needs.
#[derive(Clone, Copy)]
struct SampledArea {
    area: Area,
    rect: SampleRect,
}

/// Where the pixels of an area come from, one of each per pixel.
#[derive(Clone, Copy)]
struct PixelSources<'a> {
    positions: &'a [SourcePosition],
    /// Empty if the filter has none.
    footprints: &'a [Footprint],
}

/// The rows of the planes that a band writes, and the position of their first pixel in the map.
struct Band<'a, 'b> {
    planes: &'a mut [&'b mut [f32]],
    column: usize,
    row: usize,
    width: usize,
}

impl Band<'_, '_> {
    /// Returns the index into the planes of a pixel of the map.
    #[inline(always)]
    const fn index(&self, column: usize, row: usize) -> usize {
        (row - self.row) * self.width + column - self.column
    }
}

impl<'a> Tiles<'a> {
    pub(super) fn new(map: &'a WarpMap, source: &'a Planes<'a>, filter: Filter) -> Self {
        let extents = Extent::of_window(source.window, map.frame.window());
        Self { map, source, filter, extents, table: lanczos_table() }
    }

    /// Writes the rows of `part`, a window within the map's.
    pub(super) fn write_band(&self, part: PixelRect, planes: &mut [&mut [f32]], scratch: &mut Scratch) {
        let [left, row] = [part.x.abs_diff(self.map.window.x), part.y.abs_diff(self.map.window.y)].map(|k| k as usize);
        let [width, height] = [part.width, part.height].map(|side| side as usize);
        let mut band = Band { planes, column: left, row, width };
        for column in (0..width).step_by(TILE) {
            let area = Area { column: left + column, row, width: TILE.min(width - column), height };
            match self.filter {
                Filter::Nearest => self.copy_nearest(area, &mut band, &mut scratch.samples),
                _ => self.write_area(area, &mut band, scratch),
            }
        }
    }

    fn write_area(&self, area: Area, band: &mut Band, scratch: &mut Scratch) {
        let Scratch { positions, footprints, .. } = scratch;
        let taps = self.find_footprints(area, footprints);
        let found = self.find_positions(area, taps, positions);
        // A narrow tile may be at rest next to a minified region; its footprints then extend beyond it.
        if found.still == area.width * area.height && footprints.iter().all(Footprint::is_unit) {
            return self.copy_still(area, band);
        }
        let Some(rect) = found.rect(taps) else { return self.clear(area, band) };
        if rect.size(0) * rect.size(1) > BLOCK && area.width * area.height > 1 {
            return area.halves().into_iter().for_each(|half| self.write_area(half, band, scratch));
        }
        for first in (0..self.source.planes.len()).step_by(GROUP * GROUPS) {
            let planes = &self.source.planes[first..];
            match planes.len().div_ceil(GROUP) {
                1 => self.write_groups::<1>(SampledArea { area, rect }, first, band, scratch),
                _ => self.write_groups::<GROUPS>(SampledArea { area, rect }, first, band, scratch),
            }
        }
        if found.still > 0 {
            self.copy_still(area, band);
        }
    }

    /// Filters `N` groups of planes, starting at the plane `first`.
    fn write_groups<const N: usize>(
        &self,
        SampledArea { area, rect }: SampledArea,
        first: usize,
        band: &mut Band,
        scratch: &mut Scratch,
    ) {
        let Scratch { blocks, positions, footprints, sums, presence, .. } = scratch;
        let groups = self.source.planes[first..].chunks(GROUP);
        for (block, planes) in blocks.iter_mut().zip(groups).take(N) {
            dispatch(FillBlock { block, planes, extents: &self.extents, rect: &rect });
        }
        let texels: [&[Texel]; N] = std::array::from_fn(|n| &blocks[n].texels[..]);
        let pixels = PixelSources { positions, footprints };
        self.filter_texels(&blocks[0], texels, pixels, sums);
        for (n, block) in blocks.iter().take(N).enumerate().filter(|(_, block)| !block.presence.is_empty()) {
            self.filter_texels(block, [&block.presence[..]], pixels, presence);
            let sums = sums.iter_mut().skip(n).step_by(N);
            sums.zip(presence.iter()).for_each(|(sum, present)| renormalize(sum, present));
        }
        let sums = sums.as_chunks_mut::<N>().0;
        if (0..2).any(|axis| rect.low[axis] < 0 || rect.high[axis] > self.extents[axis].count) {
            self.cover(area, positions, sums);
        }
        let last = self.source.planes.len().min(first + N * GROUP);
        let (begin, width) = (band.index(area.column, area.row), band.width);
        let planes = &mut band.planes[first..last];
        dispatch(Scatter { area, sums, planes, begin, width });
    }

    /// Returns a pixel's own position, in samples of the source.
    #[inline(always)]
    fn start(&self, column: usize, row: usize) -> [i32; 2] {
        let (to, from) = (self.map.window, self.source.window);
        [to.x + column as i32 - from.x, to.y + row as i32 - from.y]
    }

    /// Computes the footprints, if the filter has any, and returns the taps on each side of the widest.
    fn find_footprints(&self, area: Area, footprints: &mut Vec<Footprint>) -> i32 {
        match self.filter {
            Filter::Ewa => dispatch(FindFootprints { map: self.map, area, footprints }),
            Filter::Lanczos => 3,
            Filter::Cubic | Filter::Nearest => 2,
        }
    }

    fn find_positions(&self, area: Area, taps: i32, positions: &mut Vec<SourcePosition>) -> FoundPositions {
        let start = self.start(area.column, area.row);
        dispatch(FindPositions { map: self.map, area, start, extents: &self.extents, taps, positions })
    }

    /// Filters an area: one sum per group and pixel.
    fn filter_texels<const N: usize>(
        &self,
        block: &Block,
        texels: [&[Texel]; N],
        PixelSources { positions, footprints }: PixelSources,
        sums: &mut Vec<Texel>,
    ) {
        sums.resize(N * positions.len(), [0.0; 4]);
        let sums = sums.as_chunks_mut::<N>().0;
        dispatch(Accumulate { filter: self.filter, table: self.table, block, texels, positions, footprints, sums });
    }

    /// Multiplies by the coverage at the edges of the picture.
    fn cover<const N: usize>(&self, area: Area, positions: &[SourcePosition], sums: &mut [[Texel; N]]) {
        let pixels =
            area.rows().flat_map(|row| (area.column..area.column + area.width).map(move |column| [column, row]));
        let near = positions.iter().zip(sums).zip(pixels).filter(|((position, _), _)| !position.is_nowhere());
        for ((position, sums), pixel) in near {
            let inside = coverage(&self.extents, (position.sample, position.fraction), self.map, pixel);
            sums.as_flattened_mut().iter_mut().for_each(|sample| *sample *= inside);
        }
    }

    /// Copies the samples of pixels that do not move, bit-exactly.
    fn copy_still(&self, area: Area, band: &mut Band) {
        let width = self.map.window.width as usize;
        for row in area.rows() {
            for column in area.column..area.column + area.width {
                let is_still = self.map.offsets[row * width + column] == [0.0; 2];
                if is_still && (self.filter != Filter::Ewa || Footprint::at(self.map, column, row).is_unit()) {
                    let sample = nearest_sample([0.0; 2], self.start(column, row), &self.extents);
                    self.copy_sample(sample, [column, row], band);
                }
            }
        }
    }

    /// Copies a sample of all planes to a pixel; 0 outside the picture.
    #[inline(always)]
    fn copy_sample(&self, sample: u32, [column, row]: [usize; 2], band: &mut Band) {
        let index = band.index(column, row);
        for (from, to) in self.source.planes.iter().zip(band.planes.iter_mut()) {
            to[index] = from.get(sample as usize).copied().unwrap_or(0.0);
        }
    }

    /// Copies the nearest samples of an area plane by plane: a few rows of one plane fit into the cache and the TLB,
    /// those of all planes do not.
    fn copy_nearest(&self, area: Area, band: &mut Band, samples: &mut Vec<u32>) {
        let width = self.map.window.width as usize;
        samples.resize(area.width * area.height, 0);
        for (row, samples) in area.rows().zip(samples.chunks_exact_mut(area.width)) {
            let offsets = &self.map.offsets[row * width + area.column..][..area.width];
            let start = self.start(area.column, row);
            dispatch(FindNearest { offsets, start, extents: &self.extents, samples });
        }
        let begin = band.index(area.column, area.row);
        for (from, to) in self.source.planes.iter().zip(band.planes.iter_mut()) {
            let rows = to[begin..].chunks_mut(band.width);
            for (to, samples) in rows.zip(samples.chunks_exact(area.width)) {
                copy_samples(from, samples, 0.0, &mut to[..area.width]);
            }
        }
    }

    /// Fills an area with zeros.
    fn clear(&self, area: Area, band: &mut Band) {
        for row in area.rows() {
            let begin = band.index(area.column, row);
            band.planes.iter_mut().for_each(|plane| plane[begin..begin + area.width].fill(0.0));
        }
    }
}

/// Divides by the weight of the samples that are not NaN.
fn renormalize(sum: &mut Texel, present: &Texel) {
    for (sum, present) in sum.iter_mut().zip(present) {
        let is_whole = (1.0 - present).abs() < ROUNDING;
        *sum = match *present {
            _ if is_whole => *sum,
            present if present >= MIN_PRESENCE => *sum / present,
            _ => 0.0,
        };
    }
}

/// Scatters sums to their planes: `N` groups of four, the last of which may have fewer.
struct Scatter<'a, 'b, const N: usize> {
    area: Area,
    sums: &'a [[Texel; N]],
    planes: &'a mut [&'b mut [f32]],
    /// Index of the area's first pixel in the planes.
    begin: usize,
    /// Row length of the planes, in pixels.
    width: usize,
}

impl<const N: usize> WithSimd for Scatter<'_, '_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let area = self.area;
        for (row, sums) in self.sums.chunks_exact(area.width).enumerate() {
            let begin = self.begin + row * self.width;
            for (k, plane) in self.planes.iter_mut().enumerate() {
                let to = plane[begin..begin + area.width].iter_mut();
                to.zip(sums).for_each(|(to, sum)| *to = sum[k / GROUP][k % GROUP]);
            }
        }
    }
}
