//! The cells in which a lattice folds on part of the model.
//!
//! In: a lattice, the layer's shape. Out: cells between handles.

use crate::lattice::Lattice;
use crate::solve::{ModelCells, Shape};

/// Returns the cells between handles that fold on part of the model. The shape is computed only if any cell folds.
pub(super) fn folded_model_cells<const D: usize>(
    lattice: &Lattice<D>,
    shape: impl FnOnce() -> Shape<D>,
) -> Vec<[usize; D]> {
    let folded = lattice.folded_cells();
    if folded.is_empty() {
        return folded;
    }
    ModelCells::of(&lattice.grid, &shape()).folds_and_active(lattice).1
}
