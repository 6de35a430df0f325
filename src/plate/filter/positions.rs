//! Computes the source positions of the pixels of a tile.
//!
//! In: the offsets of a map, the picture's extent. Out: for each pixel the preceding sample and the distance from it;
//! the rectangle of the source that the filter needs.

use super::area::Area;
use super::block::SampleRect;
use super::border::Extent;
use super::footprint::Footprint;
use super::simd::LANES as WIDE;
use crate::plate::WarpMap;
use pulp::{Simd, WithSimd};

/// Pixels per SIMD register, with x and y of each.
const LANES: usize = 4;

/// Position of a pixel in the source; NaN if it is far outside the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct SourcePosition {
    /// The preceding sample on both axes, as integers.
    pub(super) sample: [f32; 2],
    /// Distance from that sample, 0 to 1.
    pub(super) fraction: [f32; 2],
}

impl SourcePosition {
    const NOWHERE: Self = Self { sample: [f32::NAN; 2], fraction: [f32::NAN; 2] };

    #[inline(always)]
    pub(super) fn is_nowhere(&self) -> bool {
        self.sample[0].is_nan()
    }
}

/// Results of [`FindPositions`].
#[derive(Clone, Copy, Debug)]
pub(super) struct FoundPositions {
    /// Least and greatest preceding sample of the pixels near the picture, on both axes; empty if least > greatest.
    low: [f32; 2],
    high: [f32; 2],
    /// Number of pixels that do not move.
    pub(super) still: usize,
}

impl FoundPositions {
    /// NaN is ignored: comparisons with it are false.
    #[inline(always)]
    fn include(&mut self, sample: [f32; 2]) {
        for (axis, sample) in sample.into_iter().enumerate() {
            self.low[axis] = if sample < self.low[axis] { sample } else { self.low[axis] };
            self.high[axis] = if sample > self.high[axis] { sample } else { self.high[axis] };
        }
    }

    /// Returns the samples that a filter with this many taps on each side needs.
    pub(super) fn rect(&self, taps: i32) -> Option<SampleRect> {
        let low = self.low.map(|least| (least as i32).saturating_add(1 - taps));
        let high = self.high.map(|greatest| (greatest as i32).saturating_add(1 + taps));
        (self.low[0] <= self.high[0]).then_some(SampleRect { low, high })
    }
}

/// Computes the positions of an area.
pub(super) struct FindPositions<'a> {
    pub(super) map: &'a WarpMap,
    pub(super) area: Area,
    /// Position of the area's first pixel, in samples of the source.
    pub(super) start: [i32; 2],
    pub(super) extents: &'a [Extent; 2],
    /// Taps on each side; pixels further from the picture see nothing.
    pub(super) taps: i32,
    pub(super) positions: &'a mut Vec<SourcePosition>,
}

impl WithSimd for FindPositions<'_> {
    type Output = FoundPositions;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> FoundPositions {
        let mut found = FoundPositions { low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2], still: 0 };
        let limit = -self.taps as f32;
        let beyond = [(self.extents[0].count + self.taps) as f32, (self.extents[1].count + self.taps) as f32];
        self.positions.clear();
        for row in 0..self.area.height {
            let offsets = self.map.row(self.area.row + row, self.area.column, self.area.width);
            let y = (self.start[1] + row as i32) as f32;
            for (chunk, offsets) in offsets.chunks(LANES).enumerate() {
                let x = self.start[0] as f32 + (chunk * LANES) as f32;
                let mut positions = [SourcePosition::NOWHERE; LANES];
                for (k, (position, offset)) in positions.iter_mut().zip(offsets).enumerate() {
                    let whole = [offset[0].floor(), offset[1].floor()];
                    let sample = [x + k as f32 + whole[0], y + whole[1]];
                    let near =
                        (sample[0] >= limit) & (sample[0] < beyond[0]) & (sample[1] >= limit) & (sample[1] < beyond[1]);
                    found.still += usize::from((offset[0] == 0.0) & (offset[1] == 0.0));
                    if near {
                        *position = SourcePosition { sample, fraction: [offset[0] - whole[0], offset[1] - whole[1]] };
                    }
                }
                for position in &positions {
                    found.include(position.sample);
                }
                self.positions.extend_from_slice(&positions[..offsets.len()]);
            }
        }
        found
    }
}

/// Computes the footprints of an area and returns the greatest number of taps on each side that they need.
pub(super) struct FindFootprints<'a> {
    pub(super) map: &'a WarpMap,
    pub(super) area: Area,
    pub(super) footprints: &'a mut Vec<Footprint>,
}

impl WithSimd for FindFootprints<'_> {
    type Output = i32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> i32 {
        let Area { column, row, width, height } = self.area;
        let [columns, rows] = [self.map.window.width as usize, self.map.window.height as usize];
        self.footprints.clear();
        for row in row..row + height {
            let mut at = column;
            while at < column + width {
                let is_inner = at > 0 && at + WIDE < columns.min(column + width + 1) && row > 0 && row + 1 < rows;
                if is_inner {
                    self.footprints.extend_from_slice(&Footprint::of_inner(self.map, at, row));
                    at += WIDE;
                } else {
                    self.footprints.push(Footprint::at(self.map, at, row));
                    at += 1;
                }
            }
        }
        let largest =
            |largest: f32, footprint: &Footprint| largest.max(footprint.half_extent[0]).max(footprint.half_extent[1]);
        let largest = self.footprints.iter().fold(0.0, largest);
        if largest > 1.0 { (2.0 * largest) as i32 + 1 } else { 2 }
    }
}

impl WarpMap {
    /// Returns the offsets of a segment of a row.
    #[inline(always)]
    fn row(&self, row: usize, column: usize, count: usize) -> &[[f32; 2]] {
        &self.offsets[row * self.window.width as usize + column..][..count]
    }
}
