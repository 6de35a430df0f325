//! The outlines of the cells in which a lattice on the screen folds.
//!
//! In: a solved layer and the sample that it was solved over. Out: points of the screen.

use super::folded_model_cells::folded_model_cells;
use crate::lattice::ScreenLattice;
use crate::pipeline::evaluate::screen_shape::screen_shape;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::solve::Solution;
use crate::space::ScreenPoint;

/// Line segments per cell and line of the lattice.
pub(super) const PIECES: usize = 4;

impl PreparedShot {
    /// Returns the warped outlines of the cells in which a screen layer folds where it holds part of the model.
    pub(crate) fn folded_outlines(
        &self,
        (sample, layer): (&TimeSample, usize),
        solution: &Solution<2>,
    ) -> Vec<Vec<ScreenPoint>> {
        let outlines = |lattice: &ScreenLattice, cells: Vec<[usize; 2]>| -> Vec<Vec<ScreenPoint>> {
            cells.into_iter().map(|cell| cell_outline(lattice, cell)).collect()
        };
        match &solution.branches {
            Some(branches) if solution.report.folded_model_cells > 0 => (0..branches.branch_count())
                .flat_map(|branch| outlines(&branches.lattice(branch), branches.folds_of(branch).cells))
                .collect(),
            Some(_) => Vec::new(),
            None => {
                outlines(&solution.lattice, folded_model_cells(&solution.lattice, || screen_shape(self, sample, layer)))
            }
        }
    }
}

/// Returns the warped outline of a cell between handles.
fn cell_outline(lattice: &ScreenLattice, cell: [usize; 2]) -> Vec<ScreenPoint> {
    let margin = lattice.grid.basis.margin() as f64;
    let [x, y] = cell.map(|place| place as f64 - margin);
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let side = |k: usize| {
        let ([from, to], t) = ([corners[k / PIECES % 4], corners[(k / PIECES + 1) % 4]], (k % PIECES) as f64);
        std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * t / PIECES as f64)
    };
    let rim = (0..4 * PIECES).map(side);
    rim.map(|[u, v]: [f64; 2]| lattice.warp(ScreenPoint(lattice.grid.point_from_spans([x + u, y + v]).into())))
        .collect()
}
