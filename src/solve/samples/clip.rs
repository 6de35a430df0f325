//! Convex polygons clipped by axis-aligned planes (I. Sutherland and G. Hodgman, "Reentrant polygon clipping", 1974).
//!
//! In: a polygon and a plane. Out: the parts below and above the plane, which together are the polygon, up to rounding.

/// Capacity in corners. A triangle has at most nine after two cuts per axis in three dimensions.
const MAX_CORNERS: usize = 12;

/// A convex polygon in D dimensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon<const D: usize> {
    corners: [[f64; D]; MAX_CORNERS],
    count: usize,
}

impl<const D: usize> Polygon<D> {
    const NONE: Self = Self { corners: [[0.0; D]; MAX_CORNERS], count: 0 };

    pub(crate) fn triangle(corners: [[f64; D]; 3]) -> Self {
        let mut polygon = Self { corners: [[0.0; D]; MAX_CORNERS], count: 3 };
        polygon.corners[..3].copy_from_slice(&corners);
        polygon
    }

    /// The polygon with every corner moved.
    pub(crate) fn mapped(mut self, to: impl Fn([f64; D]) -> [f64; D]) -> Self {
        self.corners[..self.count].iter_mut().for_each(|corner| *corner = to(*corner));
        self
    }

    pub(crate) fn corners(&self) -> &[[f64; D]] {
        &self.corners[..self.count]
    }

    /// Smallest and largest coordinate along an axis.
    pub(crate) fn range(&self, axis: usize) -> [f64; 2] {
        self.corners().iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], corner| {
            [low.min(corner[axis]), high.max(corner[axis])]
        })
    }

    fn push(&mut self, corner: [f64; D]) {
        // A cut adds at most one corner to a convex polygon, so the capacity suffices; dropping a corner would lose a sliver.
        if self.count < MAX_CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Splits the polygon at the plane where the coordinate of `axis` equals `at`: returns the part below and keeps the part
    /// above. Either may be empty.
    pub(crate) fn split_off(&mut self, axis: usize, at: f64) -> Self {
        let (mut below, mut above) = (Self::NONE, Self::NONE);
        for k in 0..self.count {
            let (from, to) = (self.corners[k], self.corners[if k + 1 < self.count { k + 1 } else { 0 }]);
            let (height, next) = (from[axis] - at, to[axis] - at);
            if height <= 0.0 {
                below.push(from);
            }
            if height >= 0.0 {
                above.push(from);
            }
            if height * next < 0.0 || (height < 0.0) != (next < 0.0) && height != 0.0 && next != 0.0 {
                let t = height / (height - next);
                let mut crossing: [f64; D] = std::array::from_fn(|d| from[d] + t * (to[d] - from[d]));
                crossing[axis] = at;
                below.push(crossing);
                above.push(crossing);
            }
        }
        *self = above;
        below
    }
}
