//! Folds of a branching lattice.
//!
//! In: a [`BranchedLattice`]. Out: its [`Folds`]. Thin parts leave most of a cell empty, so a cell that folds somewhere counts only
//! if it folds on the polygons of the shape in it.

use super::{BranchedLattice, Branching};
use crate::lattice::Folds;
use crate::solve::folds_on_polygons::CellPolygons;

impl<const D: usize> BranchedLattice<D> {
    /// The folds of all branches.
    #[must_use]
    pub(crate) fn folds(&self) -> Folds<D> {
        let mut folds = Folds { cells: Vec::new(), active_count: 0, min_det: f64::INFINITY };
        for branch in 0..self.branch_count() {
            let own = self.folds_below(branch, folds.min_det);
            folds.cells.extend(own.cells);
            folds.active_count += own.active_count;
            folds.min_det = folds.min_det.min(own.min_det);
        }
        folds
    }

    /// The folds of a branch, in the cells in which its own part of the shape folds.
    #[must_use]
    pub(crate) fn folds_of(&self, branch: usize) -> Folds<D> {
        self.folds_below(branch, f64::INFINITY)
    }

    /// Same as [`Self::folds_of`]; `min_det` is tight only if it may be less than `wanted`.
    fn folds_below(&self, branch: usize, wanted: f64) -> Folds<D> {
        let Branching { grid, width, cuts, pieces, branch_of, .. } = self.branching.as_ref();
        let lattice = self.lattice(branch);
        let mut is_active = vec![false; grid.cell_count()];
        let own = pieces.list.iter().zip(branch_of).filter(|(_, of)| **of == branch);
        own.for_each(|(piece, _)| is_active[piece.cell] = true);
        let whole = lattice.active_folds(&is_active, wanted);
        if whole.active_count == 0 {
            return Folds { cells: Vec::new(), ..whole };
        }
        let folded: Vec<usize> = whole.cells.iter().map(|place| grid.cell_between_handles(place)).collect();
        let mut polygons = CellPolygons::within(grid, folded.iter().copied());
        for (cut, _) in cuts.iter().zip(&pieces.of_cuts).filter(|(_, piece)| branch_of[**piece] == branch) {
            polygons.add(cut.cell, &cut.polygon.mapped(|corner| grid.upright_from_point(corner)));
        }
        folded.iter().for_each(|&cell| is_active[cell] = false);
        // The bound over whole cells is tight only without the folded ones.
        let others =
            if is_active.contains(&true) { lattice.active_folds(&is_active, wanted).min_det } else { f64::INFINITY };
        let (cells, least) = polygons.folds(&lattice, *width, others.min(wanted));
        Folds { active_count: cells.len(), cells, min_det: others.min(least) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::problem::Shape;

    /// The folds over a bar, in a single cell in which det J is 3 (x − ¼)² − 0.05: it folds for x between 0.121 and 0.379.
    fn folds_over([low, high]: [f64; 2], angle: f64) -> Folds<2> {
        let grid = Grid { dims: [4, 4], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle };
        let corners = [[low, 0.2], [high, 0.2], [high, 0.8], [low, 0.8]].map(|corner| grid.point_from_upright(corner));
        let shape = Shape::of_triangles(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
        let rest = BranchedLattice::at_rest(&grid, &shape).expect("a right shape");
        let creased = |copy: &[f64; 2]| {
            let [x, y] = grid.upright_from_point(*copy);
            [(x - 0.25).powi(3) - 1.05 * x, y]
        };
        let copies = rest.copies().iter().map(creased).collect();
        BranchedLattice::new(&rest.branching, copies).folds()
    }

    #[test]
    fn a_cell_folds_only_where_it_holds_the_shape() {
        for angle in [0.0, 0.5] {
            let beside = folds_over([0.6, 0.8], angle);
            assert!(beside.cells.is_empty() && beside.active_count == 0, "{beside:?}");
            // 0.3175 at its left side.
            assert!((0.29..0.3176).contains(&beside.min_det), "{beside:?}");
            let close = folds_over([0.385, 0.5], angle);
            assert!(close.cells.is_empty() && close.min_det > 0.0, "{close:?}");
            let folded = folds_over([0.2, 0.6], angle);
            assert_eq!((&folded.cells[..], folded.active_count), (&[[1, 1]][..], 1));
            assert!((-0.06..-0.049).contains(&folded.min_det), "{folded:?}");
            let touched = folds_over([0.375, 0.6], angle);
            assert!(touched.active_count == 1 && touched.min_det < 0.0, "{touched:?}");
        }
    }
}
