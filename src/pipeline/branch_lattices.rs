//! The branches of a lattice file as lattices.
//!
//! In: [`LatticeBranches`] and the grid of their frame. Out: one lattice a branch, whose other handles continue it smoothly.

use crate::export::LatticeBranches;
use crate::lattice::{Grid, ScreenLattice};
use crate::solve::continued;
use rayon::prelude::*;

/// The lattices of the branches of a lattice file, over the grid of their frame.
pub(crate) fn lattices_of_file(branches: &LatticeBranches, grid: &Grid<2>) -> Vec<ScreenLattice> {
    branches.list.par_iter().map(|branch| continued(grid, &branch.handles)).collect()
}
