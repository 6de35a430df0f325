//! The branches of a lattice at one frame, as stored in lattice files.
//!
//! Plain data: the handles of each branch, and the polygons that it moves.

use crate::lattice::ScreenLattice;
use std::collections::HashMap;

/// The branches of a screen lattice: each is a plain lattice over its own part of the shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LatticeBranches {
    /// Corners of the regions, in frame heights.
    pub points: Vec<[f64; 2]>,
    /// Branches from back to front.
    pub(crate) list: Vec<LatticeBranch>,
}

/// A branch.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LatticeBranch {
    /// The handles that influence the branch, #handles; `None`: a handle that does not, extrapolated smoothly from the others.
    pub handles: Vec<Option<[f64; 2]>>,
    /// The part of the shape at rest that the branch moves: convex polygons, as indices of points.
    pub region: Vec<Vec<u32>>,
}

/// The handles that influence a branch, #handles.
pub(crate) type ActingHandles = Vec<Option<[f64; 2]>>;

/// Convex polygons.
pub(crate) type Region = Vec<Vec<[f64; 2]>>;

impl LatticeBranches {
    /// Creates branches from handles and polygons, from back to front.
    #[must_use]
    pub(crate) fn of(branches: Vec<(ActingHandles, Region)>) -> Self {
        let (mut points, mut known) = (Vec::new(), HashMap::new());
        let mut place = |point: [f64; 2]| {
            *known.entry(point.map(f64::to_bits)).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            })
        };
        let branch = |(handles, region): (ActingHandles, Region)| LatticeBranch {
            handles,
            region: region.into_iter().map(|polygon| polygon.into_iter().map(&mut place).collect()).collect(),
        };
        let list = branches.into_iter().map(branch).collect();
        Self { points, list }
    }

    /// Returns the polygons of a branch.
    pub(crate) fn polygons(&self, branch: usize) -> impl Iterator<Item = Vec<[f64; 2]>> {
        let corner = |&corner: &u32| self.points[corner as usize];
        self.list[branch].region.iter().map(move |polygon| polygon.iter().map(corner).collect())
    }

    /// Returns the same regions with other lattices, one per branch.
    #[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only commands call it"))]
    #[must_use]
    pub(crate) fn with_lattices(&self, lattices: Vec<ScreenLattice>) -> Self {
        let branch = |(lattice, branch): (ScreenLattice, &LatticeBranch)| LatticeBranch {
            handles: lattice.handles.into_iter().map(Some).collect(),
            region: branch.region.clone(),
        };
        let list = lattices.into_iter().zip(&self.list).map(branch).collect();
        Self { points: self.points.clone(), list }
    }
}
