//! Computes the maps of a warped frame tile by tile, so that tiled and whole renders show the same pixels.
//!
//! In: a [`Warp`], the frame, a window. Out: the tiles that the window touches. Tiles lie on a fixed grid, since a map
//! depends slightly (2e-4 of a pixel) on where its window begins.

use super::key::{Key, KeyWriter};
use super::process_cache::CACHE;
use super::{LiveError, Warp};
use crate::plate::{Coverage, Field, WarpMap};
use crate::space::{FrameSize, PixelRect};
use std::sync::Arc;

/// Largest width and height of a tile in pixels, without its border.
const MAX_TILE: [u32; 2] = [4096, 126];

/// Border around a tile in pixels, needed by footprints.
const RIM: u32 = 2;

/// A tile of the image plane. The frame is divided into equal tiles; the grid continues around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MapTile {
    /// Column and row in the grid; (0, 0) is at the upper left corner of the frame.
    place: [i32; 2],
    /// Width and height in pixels.
    size: [u32; 2],
}

impl MapTile {
    /// Returns the tiles that a window touches, row by row.
    pub(super) fn all_of(frame: FrameSize, window: PixelRect) -> Vec<Self> {
        if window.area() == 0 {
            return Vec::new();
        }
        let side = |length: u32, most: u32| length.div_ceil(length.div_ceil(most));
        let size = [side(frame.width, MAX_TILE[0]), side(frame.height, MAX_TILE[1])];
        let [columns, rows] =
            [(window.x, window.width, size[0]), (window.y, window.height, size[1])].map(|(start, length, size)| {
                let last = i64::from(start) + i64::from(length) - 1;
                let of = |place: i64| place.div_euclid(i64::from(size)) as i32;
                of(start.into())..=of(last)
            });
        rows.flat_map(|row| columns.clone().map(move |column| Self { place: [column, row], size })).collect()
    }

    /// Returns the pixels that the tile covers.
    pub(super) const fn window(self) -> PixelRect {
        let Self { place: [column, row], size: [width, height] } = self;
        PixelRect { x: column * width as i32, y: row * height as i32, width, height }
    }

    /// Returns the maps of all parts of the picture, from back to front, or those of the whole picture if it has no parts.
    pub(super) fn maps_of_parts(self, warp: &Warp, frame: FrameSize) -> Vec<Arc<Vec<WarpMap>>> {
        if warp.parts.is_empty() {
            return vec![self.maps(warp, frame)];
        }
        let windows = warp.part_windows(frame);
        let part = |(index, ((field, _), seen)): (usize, (&(Field, Coverage), &PixelRect))| {
            if seen.intersection(self.window().grown(RIM)).area() == 0 {
                return Arc::new(Vec::new());
            }
            self.computed((field, KeyWriter::after(warp.key).word(1 + index as u64).finish()), frame)
        };
        warp.parts.iter().zip(windows.iter()).enumerate().map(part).collect()
    }

    /// Returns the maps of its pixels and of a border around it: the front, followed by what lies behind where the warp
    /// folds ([`WarpMap::backward_preimages`]).
    pub(super) fn maps(self, warp: &Warp, frame: FrameSize) -> Arc<Vec<WarpMap>> {
        self.computed((&warp.field, warp.key), frame)
    }

    fn computed(self, (field, key): (&Field, Key), frame: FrameSize) -> Arc<Vec<WarpMap>> {
        let window = self.window().grown(RIM);
        let compute = || Ok::<_, LiveError>(WarpMap::backward_preimages(field, frame, window));
        CACHE
            .maps
            .get(self.key(key, frame), compute)
            .unwrap_or_else(|_| Arc::new(vec![WarpMap::identity(frame, window)]))
    }

    fn key(self, warp: Key, frame: FrameSize) -> Key {
        let mut key = KeyWriter::after(warp);
        key.words(&[frame.width.into(), frame.height.into(), frame.pixel_aspect.to_bits()]);
        key.words(&self.place.map(|place| place as u64)).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_tile_every_window() {
        let window = PixelRect { x: -700, y: -3, width: 2000, height: 400 };
        let frame = FrameSize::new(999, 199);
        let tiles = MapTile::all_of(frame, window);
        let covered: usize = tiles.iter().map(|tile| tile.window().intersection(window).area()).sum();
        assert_eq!(covered, window.area());
        // Tiles are 999 x 100: columns -1 to 1, rows -1 to 3.
        assert_eq!(tiles.len(), 3 * 5);
        assert_eq!(MapTile::all_of(frame, PixelRect::default()), []);
    }
}
