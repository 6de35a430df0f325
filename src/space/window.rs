//! Rectangles of whole pixels: union, intersection, tiles, and the layout of their samples.
//!
//! In: windows and samples in rows. Out: windows and sample indices. All windows of one calculation share an origin:
//! the corner of the display window ([`PixelRect::relative_to`]), or that of the file.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A rectangle of whole pixels in image space (y down), which may lie partly or wholly outside the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelRect {
    /// Index of the left column.
    pub x: i32,
    /// Index of the top row.
    pub y: i32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

impl PixelRect {
    /// Returns the number of pixels.
    #[must_use]
    pub const fn area(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns the first column right of the rectangle and the first row below it.
    fn end(self) -> [i64; 2] {
        [i64::from(self.x) + i64::from(self.width), i64::from(self.y) + i64::from(self.height)]
    }

    /// Creates the rectangle from a corner up to, but not including, `end`; empty if the end lies before the corner.
    fn between(x: i32, y: i32, end: [i64; 2]) -> Self {
        let side = |start: i32, end: i64| (end - i64::from(start)).clamp(0, u32::MAX.into()) as u32;
        Self { x, y, width: side(x, end[0]), height: side(y, end[1]) }
    }

    /// Returns the smallest window that contains both windows; empty windows are ignored.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        if self.area() == 0 || other.area() == 0 {
            return if self.area() == 0 { other } else { self };
        }
        let (own, theirs) = (self.end(), other.end());
        Self::between(self.x.min(other.x), self.y.min(other.y), [0, 1].map(|axis| own[axis].max(theirs[axis])))
    }

    /// Returns the pixels common to both windows; may be empty.
    #[must_use]
    pub(crate) fn intersection(self, other: Self) -> Self {
        let (own, theirs) = (self.end(), other.end());
        Self::between(self.x.max(other.x), self.y.max(other.y), [0, 1].map(|axis| own[axis].min(theirs[axis])))
    }

    /// Returns the same pixels relative to the upper left corner of `origin`.
    #[must_use]
    pub(crate) const fn relative_to(self, origin: Self) -> Self {
        Self { x: self.x - origin.x, y: self.y - origin.y, ..self }
    }

    /// The inverse of [`Self::relative_to`].
    #[must_use]
    pub(crate) const fn placed_in(self, origin: Self) -> Self {
        Self { x: self.x + origin.x, y: self.y + origin.y, ..self }
    }

    /// Returns the window extended by `by` pixels on every side.
    #[must_use]
    pub(crate) const fn grown(self, by: u32) -> Self {
        let Self { x, y, width, height } = self;
        let (x, y) = (x.saturating_sub_unsigned(by), y.saturating_sub_unsigned(by));
        Self { x, y, width: width.saturating_add(2 * by), height: height.saturating_add(2 * by) }
    }

    /// Cuts the window into tiles of at most `side` > 0 pixels, ordered in rows from the top.
    ///
    /// # Panics
    /// If `side` is 0.
    #[must_use]
    pub(crate) fn tiles(self, side: u32) -> Vec<Self> {
        let starts = |length: u32| (0..length).step_by(side as usize);
        let tile = |x: u32, y: u32| Self {
            x: self.x + x as i32,
            y: self.y + y as i32,
            width: side.min(self.width - x),
            height: side.min(self.height - y),
        };
        starts(self.height).flat_map(|y| starts(self.width).map(move |x| tile(x, y))).collect()
    }

    /// Returns the index of a pixel among the samples of this window, which are stored in rows from the top; `None` outside.
    #[must_use]
    #[inline]
    pub(crate) fn sample_index(self, [x, y]: [i32; 2]) -> Option<usize> {
        let column = usize::try_from(i64::from(x) - i64::from(self.x)).ok()?;
        let row = usize::try_from(i64::from(y) - i64::from(self.y)).ok()?;
        let is_inside = column < self.width as usize && row < self.height as usize;
        is_inside.then(|| row * self.width as usize + column)
    }

    /// Returns the pixel with the given sample index; the window must not be empty.
    #[must_use]
    #[inline]
    pub const fn pixel_at(self, place: usize) -> [i32; 2] {
        let width = self.width as usize;
        [self.x + (place % width) as i32, self.y + (place / width) as i32]
    }

    /// Returns, for each row common to two windows, the range of its samples in this window and in the other, from the top.
    pub(crate) fn shared_rows(self, other: Self) -> impl Iterator<Item = [Range<usize>; 2]> + Clone {
        let shared = self.intersection(other);
        let rows = if shared.width == 0 { 0 } else { shared.height as usize };
        (0..rows).map(move |row| [self, other].map(|window| window.row_of(shared, row)))
    }

    /// Returns the sample range of a row of `part`, which must lie in this window.
    const fn row_of(self, part: Self, row: usize) -> Range<usize> {
        let (x, y) = (part.x.abs_diff(self.x) as usize, part.y.abs_diff(self.y) as usize + row);
        let start = y * self.width as usize + x;
        start..start + part.width as usize
    }

    /// Copies the samples of this window into the layout of another window, filling pixels outside this window with `outside`.
    ///
    /// # Panics
    /// If there are fewer samples than pixels.
    #[must_use]
    pub(crate) fn resized_samples<T: Copy>(self, samples: &[T], other: Self, outside: T) -> Vec<T> {
        let mut result = vec![outside; other.area()];
        for [from, to] in self.shared_rows(other) {
            result[to].copy_from_slice(&samples[from]);
        }
        result
    }
}

/// Returns the row or column of a pixel with those beside it, of `count`.
pub(crate) fn with_neighbours(at: usize, count: usize) -> Range<usize> {
    at.saturating_sub(1)..(at + 2).min(count)
}

/// Returns a pixel with the up to eight around it.
pub(crate) fn around(width: usize, height: usize, pixel: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (pixel % width, pixel / width);
    with_neighbours(y, height).flat_map(move |y| with_neighbours(x, width).map(move |x| y * width + x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn window() -> impl Strategy<Value = PixelRect> {
        (-5..5, -5..5, 0..7_u32, 0..7_u32).prop_map(|(x, y, width, height)| PixelRect { x, y, width, height })
    }

    #[test]
    fn two_windows_are_joined_placed_and_walked_by_rows() {
        let (a, b) = (PixelRect { x: -2, y: 0, width: 4, height: 3 }, PixelRect { x: 1, y: 1, width: 5, height: 5 });
        assert_eq!(a.union(b), PixelRect { x: -2, y: 0, width: 8, height: 6 });
        assert_eq!(a.union(PixelRect { width: 0, ..b }), a);
        assert_eq!(b.relative_to(a), PixelRect { x: 3, y: 1, ..b });
        assert_eq!(b.relative_to(a).placed_in(a), b);
        assert_eq!(a.shared_rows(b).collect::<Vec<_>>(), [[7..8, 0..1], [11..12, 5..6]]);
    }

    proptest! {
        #[test]
        fn windows_hold_what_their_pixels_say(a in window(), b in window()) {
            let has = |window: PixelRect, pixel| window.sample_index(pixel).is_some();
            let (both, either) = (a.intersection(b), a.union(b));
            for pixel in (-12..14).flat_map(|y| (-12..14).map(move |x| [x, y])) {
                prop_assert_eq!(has(both, pixel), has(a, pixel) && has(b, pixel));
                prop_assert!(has(either, pixel) || !(has(a, pixel) || has(b, pixel)));
            }
            let numbers: Vec<i32> = (0..a.area() as i32).collect();
            for (place, number) in a.resized_samples(&numbers, b, -1).into_iter().enumerate() {
                prop_assert_eq!(number, a.sample_index(b.pixel_at(place)).map_or(-1, |place| place as i32));
            }
        }
    }

    #[test]
    fn windows_at_the_end_of_the_numbers_do_not_overflow() {
        let far = PixelRect { x: i32::MAX - 1, y: i32::MIN, width: 9, height: 9 };
        assert_eq!(far.intersection(PixelRect { x: i32::MAX, ..far }).width, 8);
        assert_eq!(far.grown(9).y, i32::MIN);
        assert_eq!(far.union(PixelRect { x: i32::MIN, width: 1, ..far }).width, u32::MAX);
    }

    #[test]
    fn windows_have_common_pixels_or_none() {
        let (a, b) = (PixelRect { x: -2, y: 0, width: 4, height: 3 }, PixelRect { x: 1, y: 1, width: 5, height: 5 });
        assert_eq!(a.intersection(b), PixelRect { x: 1, y: 1, width: 1, height: 2 });
        assert_eq!(a.intersection(PixelRect { x: 100, ..b }).area(), 0);
    }

    #[test]
    fn a_window_grows_on_every_side() {
        let window = PixelRect { x: 0, y: 5, width: 4, height: 3 };
        assert_eq!(window.grown(2), PixelRect { x: -2, y: 3, width: 8, height: 7 });
    }

    #[test]
    fn tiles_are_in_rows_from_the_top() {
        let tiles = PixelRect { x: -1, y: 0, width: 3, height: 2 }.tiles(2);
        assert_eq!(
            tiles,
            [PixelRect { x: -1, y: 0, width: 2, height: 2 }, PixelRect { x: 1, y: 0, width: 1, height: 2 }]
        );
    }

    #[test]
    fn indices_of_samples_are_in_rows_from_the_top() {
        let window = PixelRect { x: -2, y: 0, width: 4, height: 3 };
        assert_eq!(window.sample_index([-1, 2]), Some(9));
        assert_eq!(window.pixel_at(9), [-1, 2]);
        assert_eq!(window.sample_index([2, 0]), None);
    }

    #[test]
    fn samples_keep_their_pixels_in_another_window() {
        let (a, b) = (PixelRect { x: 0, y: 0, width: 2, height: 1 }, PixelRect { x: 1, y: 0, width: 2, height: 1 });
        assert_eq!(a.resized_samples(&[1.0, 2.0], b, 0.0), [2.0, 0.0]);
    }
}
