//! Selection of the boxes of an R-tree that a ray meets, in the plane and in space.
//!
//! In: a tree of objects with boxes. Out: the objects whose box the ray meets.

use rstar::{AABB, RTreeObject, SelectionFunction};

/// A ray. Its direction has unit length.
#[derive(Clone, Copy)]
pub(super) struct Ray<const D: usize> {
    pub(super) start: [f64; D],
    pub(super) direction: [f64; D],
}

impl<const D: usize> Ray<D> {
    fn meets(&self, envelope: &AABB<[f64; D]>) -> bool {
        let (low, high) = (envelope.lower(), envelope.upper());
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
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

impl<T: RTreeObject<Envelope = AABB<[f64; D]>>, const D: usize> SelectionFunction<T> for Ray<D> {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; D]>) -> bool {
        self.meets(envelope)
    }

    fn should_unpack_leaf(&self, leaf: &T) -> bool {
        self.meets(&leaf.envelope())
    }
}
