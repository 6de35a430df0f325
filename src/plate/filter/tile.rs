//! Resampling tile by tile, so that the samples a tile needs stay in the cache.
//!
//! In: a map and up to four planes. Out: bands of rows. A tile finds the rectangle of the source below it, copies that
//! into a [`Block`] (cut in half while that is too large), and runs a kernel that needs no tests for borders.

use super::Planes;
use super::block::{Block, Reach, Texel};
use super::border::Extent;
use super::kernel::{separable, widened};
use super::nearest::nearest_sample;
use super::profile::{Weights, cubic, lanczos, lanczos_table};
use super::shape::Shape;
use crate::plate::{Filter, WarpMap};
use pulp::{Simd, WithSimd};

/// Columns of a tile.
const TILE: usize = 64;
/// Texels of a block, 16 bytes each: half of a second-level cache.
const BLOCK: usize = 1 << 15;
/// A sum that misses more than three quarters of its weights says nothing.
const LEAST_PRESENCE: f32 = 0.25;

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
    shapes: Vec<Shape>,
    sums: Vec<Texel>,
    presence: Vec<Texel>,
}

/// A rectangle of the map.
#[derive(Clone, Copy)]
struct Area {
    column: usize,
    row: usize,
    width: usize,
    height: usize,
}

/// Where a pixel lies in the source: the sample before it on both axes, and how far behind it.
#[derive(Clone, Copy)]
struct Place {
    sample: [i32; 2],
    fraction: [f32; 2],
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
            return self.copy_nearest(height, &mut band);
        }
        for column in (0..width).step_by(TILE) {
            let area = Area { column, row, width: TILE.min(width - column), height };
            self.write_area(area, &mut band, scratch);
        }
    }

    fn write_area(&self, area: Area, band: &mut Band, scratch: &mut Scratch) {
        if self.is_still(area) {
            return self.copy_still(area, band);
        }
        self.find_shapes(area, scratch);
        let Some(reach) = self.reach(area, &scratch.shapes) else { return clear(self, area, band) };
        if reach.size(0) * reach.size(1) > BLOCK && area.width * area.height > 1 {
            return area.halves().into_iter().for_each(|half| self.write_area(half, band, scratch));
        }
        scratch.block.fill(self.source, &self.extents, &reach);
        let Scratch { block, shapes, sums, presence } = scratch;
        self.filter_texels(area, block, &block.texels, shapes, sums);
        if !block.presence.is_empty() {
            self.filter_texels(area, block, &block.presence, shapes, presence);
            sums.iter_mut().zip(presence.iter()).for_each(|(sum, present)| renormalize(sum, present));
        }
        self.cover(area, &reach, sums);
        scatter(self, area, sums, band);
        self.copy_still(area, band);
    }

    /// The offsets of a row of an area.
    fn offsets(&self, area: Area, row: usize) -> &'a [[f32; 2]] {
        &self.map.offsets[row * self.map.window.width as usize + area.column..][..area.width]
    }

    /// A pixel's own place in samples of the source.
    #[inline(always)]
    fn start(&self, column: usize, row: usize) -> [i32; 2] {
        let (to, from) = (self.map.window, self.source.window);
        [to.x + column as i32 - from.x, to.y + row as i32 - from.y]
    }

    /// Taps on each side of a plain filter.
    const fn taps(&self) -> i32 {
        match self.filter {
            Filter::Lanczos => 3,
            _ => 2,
        }
    }

    /// Whether nothing moves in an area.
    fn is_still(&self, area: Area) -> bool {
        area.rows().all(|row| self.offsets(area, row).iter().all(|offset| *offset == [0.0; 2]))
    }

    fn find_shapes(&self, area: Area, scratch: &mut Scratch) {
        scratch.shapes.clear();
        if self.filter == Filter::Ewa {
            dispatch(ShapesOf { map: self.map, area, shapes: &mut scratch.shapes });
        }
    }

    /// Where a pixel leads; `None`: nowhere near the picture.
    #[inline(always)]
    fn place(&self, offset: [f32; 2], start: [i32; 2], taps: [i32; 2]) -> Option<Place> {
        let whole = offset.map(f32::floor);
        let sample = [start[0] as f32 + whole[0], start[1] as f32 + whole[1]];
        let near = |axis: usize| {
            sample[axis] >= -taps[axis] as f32 && sample[axis] < (self.extents[axis].count + taps[axis]) as f32
        };
        let fraction = [offset[0] - whole[0], offset[1] - whole[1]];
        (near(0) && near(1)).then_some(Place { sample: sample.map(|x| x as i32), fraction })
    }

    /// Taps before a place on both axes; `None`: of a plain filter.
    #[inline(always)]
    fn taps_of(&self, shape: Option<&Shape>) -> [i32; 2] {
        match shape {
            Some(shape) => shape.reach.map(|reach| (2.0 * reach) as i32 + 1),
            None => [self.taps(); 2],
        }
    }

    /// The samples that an area needs; `None` where it needs none.
    fn reach(&self, area: Area, shapes: &[Shape]) -> Option<Reach> {
        let mut reach = Reach { low: [i32::MAX; 2], high: [i32::MIN; 2] };
        for row in area.rows() {
            for (k, offset) in self.offsets(area, row).iter().enumerate() {
                let shape = shapes.get((row - area.row) * area.width + k);
                let taps = self.taps_of(shape.filter(|shape| !shape.is_unit()));
                let Some(place) = self.place(*offset, self.start(area.column + k, row), taps) else { continue };
                for axis in 0..2 {
                    reach.low[axis] = reach.low[axis].min(place.sample[axis] - taps[axis] + 1);
                    reach.high[axis] = reach.high[axis].max(place.sample[axis] + taps[axis] + 1);
                }
            }
        }
        (reach.low[0] < reach.high[0]).then_some(reach)
    }

    /// Runs the filter over an area.
    fn filter_texels(&self, area: Area, block: &Block, texels: &[Texel], shapes: &[Shape], sums: &mut Vec<Texel>) {
        sums.clear();
        sums.resize(area.width * area.height, [0.0; 4]);
        dispatch(Sums { tiles: self, area, block, texels, shapes, sums });
    }

    /// The softness of the picture's own edges.
    fn cover(&self, area: Area, reach: &Reach, sums: &mut [Texel]) {
        let inside = |axis: usize| reach.low[axis] >= 0 && reach.high[axis] <= self.extents[axis].count;
        if inside(0) && inside(1) {
            return;
        }
        for (row, sums) in area.rows().zip(sums.chunks_exact_mut(area.width)) {
            for ((k, offset), sum) in self.offsets(area, row).iter().enumerate().zip(sums) {
                let Some(place) = self.place(*offset, self.start(area.column + k, row), [1 << 20; 2]) else { continue };
                let coverage = |axis: usize| self.extents[axis].coverage(place.sample[axis], place.fraction[axis]);
                let share = coverage(0) * coverage(1);
                *sum = sum.map(|x| x * share);
            }
        }
    }

    /// Copies the samples of pixels that do not move, bit for bit.
    fn copy_still(&self, area: Area, band: &mut Band) {
        for row in area.rows() {
            let offsets = self.offsets(area, row);
            for k in (0..area.width).filter(|k| offsets[*k] == [0.0; 2]) {
                if self.filter == Filter::Ewa && !Shape::at(self.map, area.column + k, row).is_unit() {
                    continue;
                }
                let sample = nearest_sample([0.0; 2], self.start(area.column + k, row), &self.extents);
                self.copy_sample(sample, [area.column + k, row], band);
            }
        }
    }

    fn copy_nearest(&self, height: usize, band: &mut Band) {
        let area = Area { column: 0, row: band.row, width: self.map.window.width as usize, height };
        for row in area.rows() {
            for (column, offset) in self.offsets(area, row).iter().enumerate() {
                let sample = nearest_sample(*offset, self.start(column, row), &self.extents);
                self.copy_sample(sample, [column, row], band);
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
}

/// Fills an area with nothing.
fn clear(tiles: &Tiles, area: Area, band: &mut Band) {
    for row in area.rows() {
        let begin = (row - band.row) * tiles.map.window.width as usize + area.column;
        band.planes.iter_mut().for_each(|plane| plane[begin..begin + area.width].fill(0.0));
    }
}

/// Puts sums into their planes.
fn scatter(tiles: &Tiles, area: Area, sums: &[Texel], band: &mut Band) {
    for (row, sums) in area.rows().zip(sums.chunks_exact(area.width)) {
        let begin = (row - band.row) * tiles.map.window.width as usize + area.column;
        for (k, plane) in band.planes.iter_mut().enumerate() {
            plane[begin..begin + area.width].iter_mut().zip(sums).for_each(|(to, sum)| *to = sum[k]);
        }
    }
}

/// Spreads the weights of samples that are no numbers over the others.
fn renormalize(sum: &mut Texel, present: &Texel) {
    for (sum, present) in sum.iter_mut().zip(present) {
        *sum = if *present >= LEAST_PRESENCE { *sum / present } else { 0.0 };
    }
}

/// Kernels that run with the widest registers of eight floats that the processor has.
trait Kernel {
    fn run<const FUSED: bool>(self);
}

/// Tells pulp which kernel to run.
struct Vector<K, const FUSED: bool>(K);

impl<K: Kernel, const FUSED: bool> WithSimd for Vector<K, FUSED> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.0.run::<FUSED>();
    }
}

fn dispatch<K: Kernel>(kernel: K) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return Simd::vectorize(simd, Vector::<K, true>(kernel));
    }
    Simd::vectorize(pulp::Scalar, Vector::<K, false>(kernel));
}

/// Kernel of [`Tiles::find_shapes`].
struct ShapesOf<'a> {
    map: &'a WarpMap,
    area: Area,
    shapes: &'a mut Vec<Shape>,
}

impl Kernel for ShapesOf<'_> {
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Area { column, width, .. } = self.area;
        for row in self.area.rows() {
            self.shapes.extend((column..column + width).map(|column| Shape::at(self.map, column, row)));
        }
    }
}

/// Kernel of [`Tiles::filter_texels`].
struct Sums<'a> {
    tiles: &'a Tiles<'a>,
    area: Area,
    block: &'a Block,
    texels: &'a [Texel],
    shapes: &'a [Shape],
    sums: &'a mut [Texel],
}

impl Kernel for Sums<'_> {
    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Sums { tiles, area, block, texels, shapes, sums } = self;
        let (stride, low) = (block.stride, block.low);
        for (index, sum) in sums.iter_mut().enumerate() {
            let (row, column) = (area.row + index / area.width, area.column + index % area.width);
            let offset = tiles.map.offsets[row * tiles.map.window.width as usize + column];
            let shape = shapes.get(index).filter(|shape| !shape.is_unit());
            let Some(place) = tiles.place(offset, tiles.start(column, row), tiles.taps_of(shape)) else { continue };
            let base = [0, 1].map(|axis| (place.sample[axis] - low[axis]) as usize);
            let [x, y] = place.fraction;
            let from = |taps: usize| &texels[(base[1] + 1 - taps) * stride + base[0] + 1 - taps..];
            *sum = match (tiles.filter, shape) {
                (_, Some(shape)) => widened::<FUSED>(texels, stride, base, place.fraction, shape),
                (Filter::Lanczos, _) => {
                    let weights = [x, y].map(|fraction| lanczos::<FUSED>(tiles.table, fraction));
                    separable::<3, FUSED>(from(3), stride, &weights[0], &weights[1])
                }
                _ => separable::<2, FUSED>(from(2), stride, &cubic::<FUSED>(x), &cubic::<FUSED>(y)),
            };
        }
    }
}
