//! The nearest object of an R-tree that a ray hits, in the plane and in space.
//!
//! In: a tree of objects with boxes, and a test that tells where the ray hits an object. Out: the nearest hit. Boxes behind the nearest hit so
//! far are left out, so that a ray through a field of many small objects passes few of them.

use rstar::{AABB, RTree, RTreeObject, SelectionFunction};
use std::cell::Cell;

/// Part of the distance of a hit by which rounding may put its box farther away.
const ROUNDING: f64 = 1e-9;

/// A ray. Its direction has unit length.
#[derive(Clone, Copy)]
pub(super) struct Ray<const D: usize> {
    pub(super) start: [f64; D],
    pub(super) direction: [f64; D],
}

impl<const D: usize> Ray<D> {
    /// Returns the nearest hit; of several at the same distance, the one of the lowest key. `hit`: the distance along the ray at which it hits
    /// an object, with the key of the object.
    pub(super) fn nearest_hit<T, K: Ord>(
        self,
        tree: &RTree<T>,
        hit: impl Fn(&T) -> Option<(f64, K)>,
    ) -> Option<(f64, K)>
    where
        T: RTreeObject<Envelope = AABB<[f64; D]>>,
    {
        let limit = Cell::new(f64::INFINITY);
        let mut nearest: Option<(f64, K)> = None;
        for leaf in tree.locate_with_selection_function(Within { ray: self, limit: &limit }) {
            let Some(found) = hit(leaf) else { continue };
            let is_nearer = |known: &(f64, K)| found.0.total_cmp(&known.0).then(found.1.cmp(&known.1)).is_lt();
            if nearest.as_ref().is_none_or(is_nearer) {
                limit.set(found.0 * (1.0 + ROUNDING));
                nearest = Some(found);
            }
        }
        nearest
    }

    /// Whether the ray meets a box within a distance.
    fn meets(&self, envelope: &AABB<[f64; D]>, limit: f64) -> bool {
        let (low, high) = (envelope.lower(), envelope.upper());
        let (mut enter, mut leave) = (0.0_f64, limit);
        for axis in 0..D {
            let [a, b] = [low[axis], high[axis]].map(|border| (border - self.start[axis]) / self.direction[axis]);
            // NaN if the ray runs along a border, which counts as inside.
            if !(a.is_nan() || b.is_nan()) {
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        enter <= leave
    }
}

/// Selects the boxes that a ray meets within a distance, which shrinks during a search.
struct Within<'a, const D: usize> {
    ray: Ray<D>,
    limit: &'a Cell<f64>,
}

impl<T: RTreeObject<Envelope = AABB<[f64; D]>>, const D: usize> SelectionFunction<T> for Within<'_, D> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; D]>) -> bool {
        self.ray.meets(envelope, self.limit.get())
    }

    fn should_unpack_leaf(&self, leaf: &T) -> bool {
        self.ray.meets(&leaf.envelope(), self.limit.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstar::primitives::{GeomWithData, Rectangle};

    /// Sides of squares in a row, all of which the ray along x passes.
    const ROW: usize = 4096;

    #[test]
    fn the_nearest_hit_is_found_without_passing_what_lies_behind_it() {
        let square = |number: usize| {
            let x = number as f64;
            GeomWithData::new(Rectangle::from_corners([x + 0.5, -1.0], [x + 0.75, 1.0]), number / 2 * 2)
        };
        let tree = RTree::bulk_load((0..ROW).map(square).collect());
        let ray = Ray { start: [100.0, 0.0], direction: [1.0, 0.0] };
        let seen = Cell::new(0);
        let hit = |leaf: &GeomWithData<Rectangle<[f64; 2]>, usize>| {
            seen.set(seen.get() + 1);
            Some((leaf.geom().lower()[0] - 100.0, leaf.data))
        };
        assert_eq!(ray.nearest_hit(&tree, hit), Some((0.5, 100)));
        assert!(seen.get() < ROW / 4, "{} of {ROW}", seen.get());
        let all_alike = |leaf: &GeomWithData<Rectangle<[f64; 2]>, usize>| Some((7.0, leaf.data));
        assert_eq!(ray.nearest_hit(&tree, all_alike), Some((7.0, 100)), "the lowest key of those within");
        assert_eq!(ray.nearest_hit(&tree, |_| None::<(f64, usize)>), None);
    }
}
