//! Converts the branches of a lattice file to lattices.
//!
//! In: [`LatticeBranches`] and the grid of their frame. Out: one lattice per branch; handles outside the branch
//! continue it smoothly.

use crate::export::LatticeBranches;
use crate::lattice::{Grid, ScreenLattice};
use crate::solve::continued;
use rayon::prelude::*;

/// Returns one lattice per branch of a lattice file, over the grid of that frame.
pub(crate) fn lattices_of_file(branches: &LatticeBranches, grid: &Grid<2>) -> Vec<ScreenLattice> {
    branches.list.par_iter().map(|branch| continued(grid, &branch.handles)).collect()
}
