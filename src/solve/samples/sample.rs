//! A sample of the model, and the sub-cells of a grid that samples represent.

use crate::lattice::Grid;

/// A point that represents a piece of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const D: usize> {
    /// Where.
    pub(crate) at: [f64; D],
    /// Area of the piece.
    pub(crate) area: f64,
    /// Its stiffness.
    pub(crate) stiffness: f64,
}

/// Sub-cells per lattice span and axis: a solve is within 4e-4 of a cell of one with fifteen (docs/METHOD.md).
const SUBCELLS: usize = 3;
/// From this number of spans on, two are enough, in the plane and in space, where a sub-cell has six points.
const MANY_SPANS: [usize; 2] = [12, 5];
/// Most sub-cells an axis of a Bernstein grid: its functions are about √n spans wide, so more see nothing new.
const BERNSTEIN_LIMIT: usize = 64;

/// Sub-cells of a grid, per axis.
pub(crate) fn subcell_dims<const D: usize>(grid: &Grid<D>) -> [usize; D] {
    let many = MANY_SPANS[usize::from(D > 2)];
    grid.dims.map(|count| {
        let spans = grid.basis.spans(count);
        let wanted = spans * if spans < many { SUBCELLS } else { SUBCELLS - 1 };
        if grid.basis.is_local() { wanted } else { wanted.min(BERNSTEIN_LIMIT) }
    })
}
