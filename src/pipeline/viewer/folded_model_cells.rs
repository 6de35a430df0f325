//! The folded cells of a lattice in which part of the model is.
//!
//! In: a lattice, the layer's shape. Out: cells between handles.

use crate::lattice::Lattice;
use crate::solve::{Shape, active_cells};

/// Returns the folded cells between handles that contain part of the model. The shape is computed only if any cell folds.
pub(super) fn folded_model_cells<const D: usize>(
    lattice: &Lattice<D>,
    shape: impl FnOnce() -> Shape<D>,
) -> Vec<[usize; D]> {
    let folded = lattice.folded_cells();
    if folded.is_empty() {
        return folded;
    }
    let grid = &lattice.grid;
    let (is_active, margin) = (active_cells(grid, &shape()), grid.basis.margin());
    let number = |cell: &[usize; D]| {
        (0..D).rev().fold(0, |number, axis| number * grid.basis.spans(grid.dims[axis]) + cell[axis] - margin)
    };
    folded.into_iter().filter(|cell| is_active.get(number(cell)).copied().unwrap_or(false)).collect()
}
