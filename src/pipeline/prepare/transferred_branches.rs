//! Fits the branches of a lattice file to another shape.
//!
//! In: the branches of one frame of the file, a [`LatticeFit`], and a shape that is split into branches of its own.
//! Out: a [`BranchedLattice`] over that shape: each of its parts follows the branch of the file that contains most of
//! it or is nearest.

use crate::export::LatticeBranches;
use crate::lattice::{LatticeFit, ScreenLattice};
use crate::pipeline::lattices_of_file;
use crate::solve::BranchedLattice;
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use std::sync::OnceLock;

/// The lattice of one frame of a file, and its branches.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct SourceFrame {
    pub(in crate::pipeline) lattice: ScreenLattice,
    branches: Option<LatticeBranches>,
    /// Computed on first use.
    parts: OnceLock<SourceParts>,
}

/// The lattices of the branches, and their regions at rest.
#[derive(Clone, Debug)]
struct SourceParts {
    lattices: Vec<ScreenLattice>,
    regions: RTree<BranchPolygon>,
}

/// A convex polygon of the shape at rest.
#[derive(Clone, Debug)]
struct BranchPolygon {
    branch: usize,
    corners: Vec<[f64; 2]>,
}

impl SourceFrame {
    pub(in crate::pipeline) fn new(lattice: ScreenLattice, branches: Option<LatticeBranches>) -> Self {
        Self { lattice, branches, parts: OnceLock::new() }
    }

    /// Returns the branched lattice over a shape at rest.
    pub(in crate::pipeline) fn over(&self, rest: &BranchedLattice<2>, fit: &LatticeFit) -> BranchedLattice<2> {
        let SourceParts { lattices, regions } = self.parts.get_or_init(|| self.parts());
        let lattices: Vec<ScreenLattice> = lattices.iter().map(|lattice| lattice.transferred(fit)).collect();
        rest.moved_by(&lattices, |point| branches_at(regions, self.lattice.origin_of(point, fit)))
    }

    fn parts(&self) -> SourceParts {
        let Some(branches) = &self.branches else {
            return SourceParts { lattices: vec![self.lattice.clone()], regions: RTree::new() };
        };
        let polygons = (0..branches.list.len())
            .flat_map(|branch| branches.polygons(branch).map(move |corners| BranchPolygon { branch, corners }));
        SourceParts {
            lattices: lattices_of_file(branches, &self.lattice.grid),
            regions: RTree::bulk_load(polygons.filter(|polygon| !polygon.corners.is_empty()).collect()),
        }
    }
}

/// Returns the branches whose polygons contain a point, or else the nearest branch.
fn branches_at(regions: &RTree<BranchPolygon>, point: [f64; 2]) -> Vec<usize> {
    let mut found: Vec<usize> = regions.locate_all_at_point(point).map(|polygon| polygon.branch).collect();
    found.sort_unstable();
    found.dedup();
    if found.is_empty() {
        found.push(regions.nearest_neighbor(point).map_or(0, |polygon| polygon.branch));
    }
    found
}

impl RTreeObject for BranchPolygon {
    type Envelope = AABB<[f64; 2]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_points(&self.corners)
    }
}

impl PointDistance for BranchPolygon {
    fn distance_2(&self, point: &[f64; 2]) -> f64 {
        let sides = || self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        // The point is inside if it lies on the same side of all edges.
        let turns = || sides().map(|(a, b)| (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]));
        if turns().all(|turn| turn >= 0.0) || turns().all(|turn| turn <= 0.0) {
            return self.envelope().distance_2(point);
        }
        let to_side = |(a, b): (&[f64; 2], &[f64; 2])| {
            let (along, away) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
            let square = along[0] * along[0] + along[1] * along[1];
            let t = (along[0] * away[0] + along[1] * away[1]) / square;
            let t = if square > 0.0 { t.clamp(0.0, 1.0) } else { 0.0 };
            (away[0] - t * along[0]).powi(2) + (away[1] - t * along[1]).powi(2)
        };
        sides().map(to_side).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_belong_to_what_lies_over_them_or_nearest() {
        let square = |branch: usize, x: f64| BranchPolygon {
            branch,
            corners: vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]],
        };
        let regions = RTree::bulk_load(vec![square(0, 0.0), square(1, 0.5), square(2, 4.0)]);
        for (point, wanted) in
            [([0.2, 0.5], vec![0]), ([0.7, 0.5], vec![0, 1]), ([3.0, 0.5], vec![2]), ([2.0, 5.0], vec![1])]
        {
            assert_eq!(branches_at(&regions, point), wanted, "{point:?}");
        }
        let far = square(0, 0.0).distance_2(&[2.0, 2.0]);
        assert!((far - 2.0).abs() < 1e-12 && square(0, 0.0).distance_2(&[0.5, 0.5]) == 0.0, "{far}");
    }
}
