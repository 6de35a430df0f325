//! Builds one map for a picture whose parts move independently.
//!
//! In: a [`Field`] and a [`Coverage`] per part, from back to front. Out: a [`WarpMap`] that shows the front part at every pixel.

use super::pixel_field::{Direction, PixelField};
use super::warp_map::{HALF, nearest_source};
use super::{Coverage, Field, WarpMap};
use crate::space::FrameWindow;
use std::collections::BTreeSet;

/// Parts that divide a picture among them, from back to front, each with its field and its share of every pixel; and the coverage of all.
pub(crate) type SharedParts = (Vec<(Field, Coverage)>, Coverage);

impl WarpMap {
    /// Returns the source of every pixel of a picture whose parts divide it among them, so that nothing of it stays.
    /// Each part moves the pixels of which it has at least half. Pixels that are `covered` by half or more hide what
    /// lies behind them; the others, which may be transparent, show only where nothing else does.
    #[must_use]
    pub(crate) fn backward_of_shares(
        parts: &[(Field, Coverage)],
        covered: &Coverage,
        FrameWindow { frame, window }: FrameWindow,
    ) -> Self {
        let mut map = Self { offsets: vec![[f32::NAN; 2]; window.area()], ..Self::identity(frame, window) };
        let mut is_covered = vec![false; window.area()];
        let mut folded = BTreeSet::new();
        for (field, share) in parts {
            let bound = |pixel| if covered.at(pixel, frame) >= HALF { 1.0 } else { 0.5 * HALF };
            let part = Self::backward_showing(field, FrameWindow { frame, window }, |pixel| {
                share.at(pixel, frame) * bound(pixel)
            });
            let is_shown = |source| share.at(source, frame) >= HALF && covered.at(source, frame) >= HALF;
            let folds = part.folds_of_branch((field, Direction::Backward), is_shown);
            for (index, is_covered) in is_covered.iter_mut().enumerate() {
                let Some(source) = nearest_source(window.pixel_at(index), part.offsets[index]) else { continue };
                let is_front = covered.at(source, frame) >= HALF;
                if share.at(source, frame) < HALF || *is_covered && !is_front {
                    continue;
                }
                map.offsets[index] = part.offsets[index];
                *is_covered |= is_front;
                if is_front && folds.contains(&(index as u32)) {
                    folded.insert(index as u32);
                } else {
                    folded.remove(&(index as u32));
                }
            }
        }
        map.folded_pixels = folded.into_iter().collect();
        map
    }

    /// Returns the folded pixels of this map that are folds of a branch, too: something that is shown lands turned over on them or,
    /// forward, where they land. Parts of a branch that pass in front of each other are no fold.
    fn folds_of_branch(
        &self,
        (field, direction): (&Field, Direction),
        is_shown: impl Fn([i32; 2]) -> bool + Sync,
    ) -> BTreeSet<u32> {
        if self.folded_pixels.is_empty() {
            return BTreeSet::new();
        }
        let reach = self.frame.window().union(self.window);
        let pixel_field = PixelField { field, frame: self.frame, direction: Direction::Forward };
        let flipped = pixel_field.flipped_targets(reach, |source| is_shown(reach.pixel_at(source)));
        let place = |index: usize| match direction {
            Direction::Backward => Some(self.window.pixel_at(index)),
            Direction::Forward => nearest_source(self.window.pixel_at(index), self.offsets[index]),
        };
        let is_fold = |index: &u32| place(*index as usize).is_some_and(|pixel| flipped.contains(&pixel));
        self.folded_pixels.iter().copied().filter(is_fold).collect()
    }

    /// Returns the target of every pixel centre of a picture, moved by the part that covers at least half of it; the rest stays.
    #[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands call it"))]
    #[must_use]
    pub(crate) fn forward_of_parts(parts: &[(Field, Coverage)], FrameWindow { frame, window }: FrameWindow) -> Self {
        let mut map = Self::identity(frame, window);
        let mut folded = BTreeSet::new();
        for (field, coverage) in parts {
            let part = Self::forward(field, frame, window);
            let is_own = |pixel| coverage.at(pixel, frame) >= HALF;
            let folds = part.folds_of_branch((field, Direction::Forward), is_own);
            let is_own = |index: usize| is_own(window.pixel_at(index));
            (0..window.area())
                .filter(|&index| is_own(index))
                .for_each(|index| map.offsets[index] = part.offsets[index]);
            folded.extend(folds.into_iter().filter(|&index| is_own(index as usize)));
        }
        map.folded_pixels = folded.into_iter().collect();
        map
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::space::FrameSize;

    const FRAME: FrameSize = FrameSize { width: 40, height: 20, pixel_aspect: 1.0 };

    /// Shifts everything right by a number of pixels.
    fn shift(pixels: f64) -> Field {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [2.0, 1.0], angle: 0.0 };
        let mut lattice = grid.at_rest();
        lattice.handles.iter_mut().for_each(|handle| handle[0] += pixels / 20.0);
        Field::of_layer(lattice)
    }

    /// Coverage of a range of columns.
    fn columns(range: std::ops::Range<i32>) -> Coverage {
        let samples = (0..800).map(|index| f32::from(u8::from(range.contains(&(index % 40))))).collect();
        Coverage { frame: FRAME, window: FRAME.window(), samples }
    }

    #[test]
    fn what_is_transparent_hides_nothing() {
        // The front part has everything to the right of column 12, but only columns 20 to 24 are visible.
        let parts = [(shift(0.0), columns(0..12)), (shift(-14.0), columns(12..40))];
        let shown = columns(0..24);
        let mut covered = shown.clone();
        (0..800).filter(|index| (12..20).contains(&(index % 40))).for_each(|index| covered.samples[index] = 0.0);
        let map = WarpMap::backward_of_shares(&parts, &covered, FRAME.whole());
        let source = |x: i32| map.source(x, 10).map(|[x, _]| (x - 0.5).round() as i32);
        let expected = |x: i32| match x {
            // Its visible columns lie over the first part; its transparent rest does not.
            6..10 => Some(x + 14),
            0..12 => Some(x),
            12..26 => Some(x + 14),
            _ => None,
        };
        (0..40).for_each(|x| assert_eq!(source(x), expected(x), "{x}"));
    }

    #[test]
    fn parts_go_where_their_own_field_says() {
        let parts = [(shift(4.0), columns(4..12)), (shift(0.0), columns(12..20))];
        let there = WarpMap::forward_of_parts(&parts, FRAME.whole());
        let target = |x: i32| there.source(x, 10).map(|[x, _]| (x - 0.5).round() as i32);
        (0..40).for_each(|x| assert_eq!(target(x), Some(if (4..12).contains(&x) { x + 4 } else { x }), "{x}"));
    }
}
