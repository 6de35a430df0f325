//! How much two points of the shape act on the same copies of handles.
//!
//! In: a [`Branching`], two points. Out: the degree to which their common handles are common copies, and the share of all that acts
//! on them that is common.

use super::{BranchedLattice, Branching};
use crate::solve::problem::PointPin;
use std::collections::BTreeMap;

/// Sums of products of the weights of two points.
struct Overlap {
    /// Over common copies.
    copies: f64,
    /// Over common handles.
    handles: f64,
    /// Of each point with itself.
    own: [f64; 2],
}

impl<const D: usize> Branching<D> {
    /// The degree to which two pins act on the same unknowns, 0 to 1; pins on separate parts are independent.
    pub(crate) fn coupling(&self, pins: [&PointPin<D>; 2]) -> f64 {
        let Overlap { copies, handles, .. } = self.overlap(pins.map(|pin| (pin.at, pin.triangle)));
        if handles > 0.0 { copies / handles } else { 0.0 }
    }

    /// Compares what acts on two points, each with the triangle on which it lies.
    fn overlap(&self, points: [([f64; D], Option<u32>); 2]) -> Overlap {
        let [one, other] = points.map(|(at, triangle)| {
            let (at, piece) = self.snapped_point(at, triangle);
            let copies = &self.branches[self.branch_of(piece)];
            let weights = self.grid.weights(self.grid.clamp_to_box(at)).into_iter();
            weights.filter_map(|(handle, weight)| Some((handle, (copies[handle]?, weight)))).collect::<BTreeMap<_, _>>()
        });
        let own = [&one, &other].map(|weights| weights.values().map(|(_, weight)| weight * weight).sum());
        let mut overlap = Overlap { copies: 0.0, handles: 0.0, own };
        for (handle, (copy, weight)) in &one {
            if let Some((theirs, other)) = other.get(handle) {
                overlap.copies += weight * other * self.coupling_degree([[*copy, *theirs]].into_iter());
                overlap.handles += weight * other;
            }
        }
        overlap
    }
}

impl<const D: usize> BranchedLattice<D> {
    /// The share of the copies acting on two points that acts on both, by weight: 1 for the same point, 0 for points on separate
    /// parts or four spans apart. A point may name the triangle of the shape on which it lies.
    #[must_use]
    pub(crate) fn common_share(&self, points: [([f64; D], Option<u32>); 2]) -> f64 {
        let Overlap { copies, own: [one, other], .. } = self.branching.overlap(points);
        let all = (one * other).sqrt();
        if all > 0.0 { copies / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::problem::Shape;

    /// Two prongs that rise from a bar, a tenth apart.
    fn fork() -> Shape<2> {
        let boxes = [
            [0.0, 0.0, 0.45, 0.2],
            [0.45, 0.0, 0.55, 0.2],
            [0.55, 0.0, 1.0, 0.2],
            [0.0, 0.2, 0.45, 1.0],
            [0.55, 0.2, 1.0, 1.0],
        ];
        let points =
            boxes.iter().flat_map(|&[left, low, right, high]| [[left, low], [right, low], [right, high], [left, high]]);
        let triangles =
            (0..boxes.len() as u32).flat_map(|k| [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
        Shape::of_triangles(points.collect(), triangles.collect())
    }

    fn share(spans: usize, points: [[f64; 2]; 2]) -> f64 {
        let grid = Grid { dims: [spans + 3; 2], basis: Basis::Bspline, lo: [-0.1; 2], hi: [1.1; 2], angle: 0.0 };
        let lattice = BranchedLattice::at_rest(&grid, &fork()).expect("a right shape");
        lattice.common_share(points.map(|at| (at, None)))
    }

    #[test]
    fn coarse_lattices_couple_what_finer_ones_separate() {
        let tips = [[0.44, 0.9], [0.56, 0.9]];
        assert!(share(2, tips) > 0.8, "{}", share(2, tips));
        assert!(share(12, tips) < 0.01, "{}", share(12, tips));
        let along = [[0.44, 0.9], [0.44, 0.8]];
        assert!(share(12, along) > 0.4, "{}", share(12, along));
        assert!((share(12, [along[0]; 2]) - 1.0).abs() < 1e-12);
    }
}
