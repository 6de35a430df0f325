//! Regions of definition and interest.
//!
//! In: a [`Warp`], the frame, a window. Out: windows that contain at least all affected pixels.

use super::key::{Key, KeyWriter};
use super::map_tiles::MapTile;
use super::process_cache::CACHE;
use super::{LiveError, Warp};
use crate::plate::{Coverage, Field, Filter, WarpMap};
use crate::space::{FrameSize, PixelRect};
use rayon::prelude::*;
use std::sync::Arc;

/// Samples around a picture's edge to which the filter may spread, in pixels of the result.
pub(super) const SOFT_EDGE: u32 = 3;

/// Samples on each side that a filter reads under little minification.
const WIDEST: u32 = 8;

/// Key of the windows of parts, which no host asks for.
const PARTS: u64 = u64::MAX;

/// Returns the region that is evaluated per pixel: the frame extended by its own size on every side, since hosts also
/// ask for infinite regions.
pub(super) fn around(frame: FrameSize) -> PixelRect {
    frame.window().grown(frame.width.max(frame.height))
}

impl Warp {
    /// Returns the region of definition: every output pixel that a picture of this window may affect. Limited to the
    /// frame extended by its own size on every side, unless the window itself reaches further.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin calls it"))]
    #[must_use]
    pub(crate) fn destination_of(&self, window: PixelRect, frame: FrameSize) -> PixelRect {
        if self.is_identity() || window.area() == 0 {
            return window;
        }
        let key = self.region_key((0, frame), window);
        let found = CACHE.regions.get(key, || {
            let near = window.intersection(around(frame));
            let windows = self.fields().map(|field| field.warped_window(frame, near));
            let seen = if near.area() == 0 { near } else { windows.reduce(PixelRect::union).unwrap_or(near) };
            let seen = if seen.area() == 0 { seen } else { seen.grown(SOFT_EDGE) };
            Ok::<_, LiveError>(if near == window { seen } else { seen.union(self.carried(frame, window)) })
        });
        found.map_or(window, |found| *found)
    }

    /// Returns the region of interest: every source pixel that affects the pixels of `window`, including the support of
    /// the filter. With a mask the part at rest is also needed: add the window itself.
    #[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin calls it"))]
    #[must_use]
    pub(crate) fn source_of(&self, window: PixelRect, frame: FrameSize, filter: Filter) -> PixelRect {
        if self.is_identity() || window.area() == 0 {
            return window;
        }
        let found = CACHE.regions.get(self.region_key((1 + filter as u64, frame), window), || {
            let near = window.intersection(around(frame));
            let reaches = MapTile::all_of(frame, near).into_iter().filter_map(|tile| {
                let window = tile.window().intersection(near);
                let maps = tile.maps_of_parts(self, frame);
                maps.iter().flat_map(|maps| maps.iter()).filter_map(|map| reach(map, window, filter)).reduce(union)
            });
            let read = reaches.reduce(union).map_or(PixelRect { width: 0, height: 0, ..window }, rect);
            Ok::<_, LiveError>(if near == window { read } else { read.union(self.carried(frame, window)) })
        });
        found.map_or(window, |found| *found)
    }

    /// Returns the output windows of all parts, from back to front.
    pub(super) fn part_windows(&self, frame: FrameSize) -> Arc<Vec<PixelRect>> {
        let key = self.region_key((PARTS, frame), PixelRect::default());
        let found = CACHE.part_windows.get(key, || {
            let seen = |(field, share): &(Field, Coverage)| {
                let scale = [
                    f64::from(frame.width) / f64::from(share.frame.width),
                    f64::from(frame.height) / f64::from(share.frame.height),
                ];
                let own = share.window;
                // Pixels beyond the frame move with the nearest part.
                let is_at_edge = own.grown(1).intersection(share.frame.window()) != own.grown(1);
                let start = [own.x, own.y].map(f64::from);
                let end = [start[0] + f64::from(own.width), start[1] + f64::from(own.height)];
                let low = [0, 1].map(|axis| (start[axis] * scale[axis]).floor() as i32 - 1);
                let high = [0, 1].map(|axis| (end[axis] * scale[axis]).ceil() as i32 + 1);
                let window = PixelRect {
                    x: low[0],
                    y: low[1],
                    width: (high[0] - low[0]) as u32,
                    height: (high[1] - low[1]) as u32,
                };
                let window = if is_at_edge { around(frame) } else { window };
                field.warped_window(frame, window).grown(SOFT_EDGE)
            };
            Ok::<_, LiveError>(self.parts.iter().map(seen).collect())
        });
        found.unwrap_or_default()
    }

    /// Grows a window by the largest displacement, a coarse bound that suffices far from the frame.
    fn carried(&self, frame: FrameSize, window: PixelRect) -> PixelRect {
        let most = self.fields().map(Field::max_displacement).fold(0.0, f64::max) * f64::from(frame.height)
            / frame.pixel_aspect.min(1.0);
        window.grown((most.ceil().clamp(0.0, 1e5) as u32).saturating_add(WIDEST))
    }

    fn region_key(&self, (question, frame): (u64, FrameSize), window: PixelRect) -> Key {
        let mut key = KeyWriter::after(self.key);
        key.words(&[question, frame.width.into(), frame.height.into(), frame.pixel_aspect.to_bits()]);
        key.words(&[window.x as u64, window.y as u64, window.width.into(), window.height.into()]).finish()
    }
}

/// Left, top, right and bottom of the read region, in pixels.
pub(super) type Reach = [f32; 4];

pub(super) fn union(a: Reach, b: Reach) -> Reach {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

/// Returns the region that the pixels of a window within a map read; `None`: nothing.
pub(super) fn reach(map: &WarpMap, window: PixelRect, filter: Filter) -> Option<Reach> {
    let rows = (window.y..window.y + window.height as i32).into_par_iter();
    let of_row = |y: i32| {
        let first = map.window.sample_index([window.x, y])?;
        let pixels = (0..window.width as usize).filter_map(|column| {
            let [dx, dy] = map.offsets[first + column];
            if !(dx + dy).is_finite() {
                return None;
            }
            let [x, y] = [(window.x + column as i32) as f32 + dx, y as f32 + dy];
            let [rx, ry] = footprint(map, first + column, filter);
            Some([x - rx, y - ry, x + rx, y + ry])
        });
        pixels.reduce(union)
    };
    rows.filter_map(of_row).reduce_with(union)
}

/// Returns the greatest number of samples that a filter reads on each side of a position.
fn footprint(map: &WarpMap, index: usize, filter: Filter) -> [f32; 2] {
    match filter {
        Filter::Nearest => [1.0; 2],
        Filter::Cubic => [2.0; 2],
        Filter::Lanczos => [3.0; 2],
        Filter::Ewa => {
            // With H² = max(1, J Jᵀ) by eigenvalues, a row of H is at most √(1 + |row of J|²) long, and the filter's
            // square of "radius" 2 reaches √2 times as far into its corners.
            let [x, y] = map.jacobian(index);
            [x, y].map(|[a, b]| 2.0 * std::f32::consts::SQRT_2 * (1.0 + a * a + b * b).sqrt())
        }
    }
}

/// Returns the pixels around a region, with one more sample for rounding.
pub(super) fn rect([left, top, right, bottom]: Reach) -> PixelRect {
    let (x, y) = (left.floor() as i32 - 1, top.floor() as i32 - 1);
    let size = |from: i32, to: f32| (to.ceil() as i32 + 2).saturating_sub(from).max(0) as u32;
    PixelRect { x, y, width: size(x, right), height: size(y, bottom) }
}
