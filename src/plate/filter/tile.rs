//! Resampling tile by tile, so that the samples a tile needs stay in the cache.
//!
//! In: a map and up to four planes. Out: bands of rows. A tile finds the rectangle of the source below it, copies that
//! into a [`Block`] (cut in half while that is too large), and runs a kernel that needs no tests for borders.

use super::Planes;
use super::block::{Block, FillBlock, Texel};
use super::border::Extent;
use super::kernel::Sums;
use super::nearest::nearest_sample;
use super::places::{FindPlaces, FindShapes, Found, Place};
use super::profile::{Weights, lanczos_table};
use super::shape::Shape;
use super::simd::dispatch;
use crate::plate::{Filter, WarpMap};
use pulp::{Simd, WithSimd};

/// Columns of a tile.
const TILE: usize = 64;
/// Texels of a block, 16 bytes each: half of a second-level cache.
const BLOCK: usize = 1 << 15;
/// A sum that misses more than three quarters of its weights says nothing.
const LEAST_PRESENCE: f32 = 0.25;
/// A sum that misses less than this of its weights is whole: rounding must not tell whether a NaN lies elsewhere in its tile.
const ROUNDING: f32 = 1e-5;

/// What all tiles of a resampling share.
pub(super) struct Tiles<'a> {
    map: &'a WarpMap,
    source: &'a Planes<'a>,
    filter: Filter,
    extents: [Extent; 2],
    table: &'static [Weights],
}

/// Memory that tiles of a thread use one after the other.
#[derive(Default)]
pub(super) struct Scratch {
    block: Block,
    places: Vec<Place>,
    shapes: Vec<Shape>,
    sums: Vec<Texel>,
    presence: Vec<Texel>,
    samples: Vec<usize>,
}

/// A rectangle of the map.
#[derive(Clone, Copy)]
pub(super) struct Area {
    pub(super) column: usize,
    pub(super) row: usize,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// Rows of the planes that a band writes, and the first one's row in the map.
struct Band<'a, 'b> {
    planes: &'a mut [&'b mut [f32]],
    row: usize,
}

impl Area {
    fn halves(self) -> [Self; 2] {
        if self.width >= self.height {
            let left = self.width / 2;
            let right = Self { column: self.column + left, width: self.width - left, ..self };
            [Self { width: left, ..self }, right]
        } else {
            let upper = self.height / 2;
            let lower = Self { row: self.row + upper, height: self.height - upper, ..self };
            [Self { height: upper, ..self }, lower]
        }
    }

    fn rows(self) -> std::ops::Range<usize> {
        self.row..self.row + self.height
    }
}

impl<'a> Tiles<'a> {
    pub(super) fn new(map: &'a WarpMap, source: &'a Planes<'a>, filter: Filter) -> Self {
        let extents = Extent::of_window(source.window, map.frame.window());
        Self { map, source, filter, extents, table: lanczos_table() }
    }

    /// Writes the rows from `row` on.
    pub(super) fn write_band(&self, row: usize, planes: &mut [&mut [f32]], scratch: &mut Scratch) {
        let width = self.map.window.width as usize;
        let height = planes[0].len() / width;
        let mut band = Band { planes, row };
        if self.filter == Filter::Nearest {
            let area = Area { column: 0, row, width, height };
            return dispatch(CopyNearest { tiles: self, area, samples: &mut scratch.samples, band: &mut band });
        }
        for column in (0..width).step_by(TILE) {
            let area = Area { column, row, width: TILE.min(width - column), height };
            self.write_area(area, &mut band, scratch);
        }
    }

    fn write_area(&self, area: Area, band: &mut Band, scratch: &mut Scratch) {
        let Scratch { block, places, shapes, sums, presence, .. } = scratch;
        let taps = self.find_shapes(area, shapes);
        let found = self.find_places(area, taps, places);
        // A narrow tile may stand still beside a part that shrinks: then its footprints reach out of it.
        if found.still == area.width * area.height && shapes.iter().all(Shape::is_unit) {
            return self.copy_still(area, band);
        }
        let Some(reach) = found.reach(taps) else { return self.clear(area, band) };
        if reach.size(0) * reach.size(1) > BLOCK && area.width * area.height > 1 {
            return area.halves().into_iter().for_each(|half| self.write_area(half, band, scratch));
        }
        dispatch(FillBlock { block, source: self.source, extents: &self.extents, reach: &reach });
        self.filter_texels(block, &block.texels, (places, shapes), sums);
        if !block.presence.is_empty() {
            self.filter_texels(block, &block.presence, (places, shapes), presence);
            sums.iter_mut().zip(presence.iter()).for_each(|(sum, present)| renormalize(sum, present));
        }
        if (0..2).any(|axis| reach.low[axis] < 0 || reach.high[axis] > self.extents[axis].count) {
            self.cover(places, sums);
        }
        dispatch(Scatter { area, sums, band, width: self.map.window.width as usize });
        if found.still > 0 {
            self.copy_still(area, band);
        }
    }

    /// A pixel's own place in samples of the source.
    #[inline(always)]
    fn start(&self, column: usize, row: usize) -> [i32; 2] {
        let (to, from) = (self.map.window, self.source.window);
        [to.x + column as i32 - from.x, to.y + row as i32 - from.y]
    }

    /// Footprints, where the filter has them, and taps on each side of the widest.
    fn find_shapes(&self, area: Area, shapes: &mut Vec<Shape>) -> i32 {
        match self.filter {
            Filter::Ewa => dispatch(FindShapes { map: self.map, area, shapes }),
            Filter::Lanczos => 3,
            Filter::Cubic | Filter::Nearest => 2,
        }
    }

    fn find_places(&self, area: Area, taps: i32, places: &mut Vec<Place>) -> Found {
        let start = self.start(area.column, area.row);
        dispatch(FindPlaces { map: self.map, area, start, extents: &self.extents, taps, places })
    }

    /// Runs the filter over an area.
    fn filter_texels(
        &self,
        block: &Block,
        texels: &[Texel],
        (places, shapes): (&[Place], &[Shape]),
        sums: &mut Vec<Texel>,
    ) {
        sums.clear();
        sums.resize(places.len(), [0.0; 4]);
        dispatch(Sums { filter: self.filter, table: self.table, block, texels, places, shapes, sums });
    }

    /// The softness of the picture's own edges.
    fn cover(&self, places: &[Place], sums: &mut [Texel]) {
        for (place, sum) in places.iter().zip(sums).filter(|(place, _)| !place.is_nowhere()) {
            let [x, y] = [0, 1].map(|axis| self.extents[axis].coverage(place.sample[axis], place.fraction[axis]));
            *sum = sum.map(|sample| sample * (x * y));
        }
    }

    /// Copies the samples of pixels that do not move, bit for bit.
    fn copy_still(&self, area: Area, band: &mut Band) {
        let width = self.map.window.width as usize;
        for row in area.rows() {
            for column in area.column..area.column + area.width {
                let is_still = self.map.offsets[row * width + column] == [0.0; 2];
                if is_still && (self.filter != Filter::Ewa || Shape::at(self.map, column, row).is_unit()) {
                    let sample = nearest_sample([0.0; 2], self.start(column, row), &self.extents);
                    self.copy_sample(sample, [column, row], band);
                }
            }
        }
    }

    /// Copies a sample of all planes to a pixel; nothing is 0.
    #[inline(always)]
    fn copy_sample(&self, sample: Option<usize>, [column, row]: [usize; 2], band: &mut Band) {
        let index = (row - band.row) * self.map.window.width as usize + column;
        for (from, to) in self.source.planes.iter().zip(band.planes.iter_mut()) {
            to[index] = sample.map_or(0.0, |sample| from[sample]);
        }
    }

    /// Fills an area with nothing.
    fn clear(&self, area: Area, band: &mut Band) {
        for row in area.rows() {
            let begin = (row - band.row) * self.map.window.width as usize + area.column;
            band.planes.iter_mut().for_each(|plane| plane[begin..begin + area.width].fill(0.0));
        }
    }
}

/// Spreads the weights of samples that are no numbers over the others.
fn renormalize(sum: &mut Texel, present: &Texel) {
    for (sum, present) in sum.iter_mut().zip(present) {
        let is_whole = (1.0 - present).abs() < ROUNDING;
        *sum = match *present {
            _ if is_whole => *sum,
            present if present >= LEAST_PRESENCE => *sum / present,
            _ => 0.0,
        };
    }
}

/// Puts sums into their planes.
struct Scatter<'a, 'b, 'c> {
    area: Area,
    sums: &'a [Texel],
    band: &'a mut Band<'b, 'c>,
    /// Pixels of a row of the planes.
    width: usize,
}

impl WithSimd for Scatter<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let area = self.area;
        for (row, sums) in area.rows().zip(self.sums.chunks_exact(area.width)) {
            let begin = (row - self.band.row) * self.width + area.column;
            for (k, plane) in self.band.planes.iter_mut().enumerate() {
                plane[begin..begin + area.width].iter_mut().zip(sums).for_each(|(to, sum)| *to = sum[k]);
            }
        }
    }
}

/// Copies the nearest samples of an area.
struct CopyNearest<'a, 'b, 'c> {
    tiles: &'a Tiles<'a>,
    area: Area,
    /// Memory for a row.
    samples: &'a mut Vec<usize>,
    band: &'a mut Band<'b, 'c>,
}

impl WithSimd for CopyNearest<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let (tiles, width) = (self.tiles, self.area.width);
        for row in self.area.rows() {
            self.samples.clear();
            for (column, offset) in tiles.map.offsets[row * width..][..width].iter().enumerate() {
                let sample = nearest_sample(*offset, tiles.start(column, row), &tiles.extents);
                self.samples.push(sample.unwrap_or(usize::MAX));
            }
            let begin = (row - self.band.row) * width;
            for (from, to) in tiles.source.planes.iter().zip(self.band.planes.iter_mut()) {
                for (to, sample) in to[begin..begin + width].iter_mut().zip(self.samples.iter()) {
                    *to = from.get(*sample).copied().unwrap_or(0.0);
                }
            }
        }
    }
}
