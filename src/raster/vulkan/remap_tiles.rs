//! Splits a resampling into tiles whose source, offsets and result fit into a device's buffers.
//!
//! In: a map, the source's extent, a filter. Out: rectangles of the map, each with the part of the source that it
//! needs.

use crate::plate::{Extent, Filter, WarpMap};
use crate::space::PixelRect;
use rayon::prelude::*;

/// Samples on each side needed by the widest footprint: minification is filtered in full up to 16, on diagonals 23.
const WIDEST: i32 = 47;
/// Maximum side in pixels: every device supports the corresponding number of workgroups per axis.
const LONGEST: u32 = 1 << 18;

/// One dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tile {
    /// Pixels, relative to the first of the map.
    pub(super) area: PixelRect,
    /// Samples, relative to the first of the source; never empty.
    pub(super) part: PixelRect,
}

/// The inputs of tiling.
pub(super) struct Cut<'a> {
    pub(super) map: &'a WarpMap,
    pub(super) extents: [Extent; 2],
    /// The sample at the position of the map's first pixel.
    pub(super) start: [i32; 2],
    pub(super) filter: Filter,
    /// Maximum pixels or samples of a tile; a single pixel is processed whatever it needs.
    pub(super) most: usize,
}

impl Cut<'_> {
    /// Returns tiles that cover each pixel of the map once; deterministic.
    pub(super) fn tiles(&self) -> Vec<Tile> {
        let window = self.map.window;
        let mut open = vec![PixelRect { x: 0, y: 0, ..window }];
        let mut tiles = Vec::new();
        while let Some(area) = open.pop() {
            let part = self.part(area);
            // The neighbours of the area are needed, too.
            let pixels = (area.width as usize + 2) * (area.height as usize + 2);
            let fits = pixels.max(part.area()) <= self.most && area.width.max(area.height) <= LONGEST;
            if area.area() == 1 || fits {
                tiles.push(Tile { area, part });
            } else {
                open.extend(halves(area));
            }
        }
        tiles
    }

    /// Returns the part of the source that an area needs, or all of it if that fits.
    fn part(&self, area: PixelRect) -> PixelRect {
        let [width, height] = self.extents.map(|extent| extent.count);
        if width as usize * height as usize <= self.most {
            return PixelRect { x: 0, y: 0, width: width as u32, height: height as u32 };
        }
        let rows = (area.y..area.y + area.height as i32).into_par_iter();
        let [x, y] = rows.map(|row| self.row_range(area, row)).reduce(|| [NOWHERE; 2], both);
        let ([x, width], [y, height]) = (clipped(x, width), clipped(y, height));
        PixelRect { x, y, width: width as u32, height: height as u32 }
    }

    /// Returns the first and last sample that the pixels of a row need, on both axes.
    fn row_range(&self, area: PixelRect, row: i32) -> [Range; 2] {
        let taps = match self.filter {
            Filter::Ewa => WIDEST,
            Filter::Lanczos => 3,
            Filter::Cubic | Filter::Nearest => 2,
        };
        let offsets = &self.map.offsets[row as usize * self.map.window.width as usize..][area.x as usize..];
        let mut ranges = [NOWHERE; 2];
        for (column, offset) in (area.x..).zip(&offsets[..area.width as usize]) {
            let place = [self.start[0] + column, self.start[1] + row];
            let samples = [0, 1].map(|axis| place[axis] as f32 + offset[axis].floor());
            // The comparisons are false for NaN.
            let near = |axis: usize| (samples[axis] + taps as f32) >= 0.0 && samples[axis] < self.limit(axis, taps);
            if near(0) && near(1) {
                let range = |axis: usize| (samples[axis] as i32 - taps, samples[axis] as i32 + taps);
                ranges = both(ranges, [range(0), range(1)]);
            }
        }
        ranges
    }

    fn limit(&self, axis: usize, taps: i32) -> f32 {
        (self.extents[axis].count + taps) as f32
    }
}

/// First and last sample; empty if the first is after the last.
type Range = (i32, i32);

const NOWHERE: Range = (i32::MAX, i32::MIN);

fn both(a: [Range; 2], b: [Range; 2]) -> [Range; 2] {
    [0, 1].map(|axis| (a[axis].0.min(b[axis].0), a[axis].1.max(b[axis].1)))
}

/// Returns the first sample and the number of samples within a picture, at least one.
fn clipped((first, last): Range, count: i32) -> [i32; 2] {
    let first = first.clamp(0, count - 1);
    [first, last.clamp(first, count - 1) - first + 1]
}

/// Returns the lower half first, so that the upper one is processed first.
fn halves(area: PixelRect) -> [PixelRect; 2] {
    let mut parts = [area; 2];
    if area.width > area.height {
        parts[1].width = area.width / 2;
        parts[0].width -= parts[1].width;
        parts[0].x += parts[1].width as i32;
    } else {
        parts[1].height = area.height / 2;
        parts[0].height -= parts[1].height;
        parts[0].y += parts[1].height as i32;
    }
    parts
}
