//! The branches of a lattice at one frame, as lattice files hold them.
//!
//! Plain data: the handles of each branch, and the polygons that go with it.

use crate::lattice::ScreenLattice;
use std::collections::HashMap;

/// The branches of a lattice of the screen: each a plain lattice over the part of the shape that is its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LatticeBranches {
    /// Corners of the regions, frame heights.
    pub points: Vec<[f64; 2]>,
    /// From back to front.
    pub list: Vec<LatticeBranch>,
}

/// A branch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LatticeBranch {
    /// The handles that act on it, #handles; `None`: one that does not, and continues the others smoothly.
    pub handles: Vec<Option<[f64; 2]>>,
    /// The part of the shape at rest that goes with it: convex polygons, as indices of points.
    pub region: Vec<Vec<u32>>,
}

/// The handles that act on a branch, #handles.
pub type ActingHandles = Vec<Option<[f64; 2]>>;

/// Convex polygons.
pub type Region = Vec<Vec<[f64; 2]>>;

impl LatticeBranches {
    /// Of handles and polygons, from back to front.
    #[must_use]
    pub fn of(branches: Vec<(ActingHandles, Region)>) -> Self {
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

    /// The polygons of a branch.
    pub fn polygons(&self, branch: usize) -> impl Iterator<Item = Vec<[f64; 2]>> {
        let corner = |&corner: &u32| self.points[corner as usize];
        self.list[branch].region.iter().map(move |polygon| polygon.iter().map(corner).collect())
    }

    /// The same regions with other lattices, one a branch.
    #[must_use]
    pub fn with_lattices(&self, lattices: Vec<ScreenLattice>) -> Self {
        let branch = |(lattice, branch): (ScreenLattice, &LatticeBranch)| LatticeBranch {
            handles: lattice.handles.into_iter().map(Some).collect(),
            region: branch.region.clone(),
        };
        let list = lattices.into_iter().zip(&self.list).map(branch).collect();
        Self { points: self.points.clone(), list }
    }
}
