//! A sample of the model, and the sub-cells of a grid that samples represent.

use crate::lattice::Grid;

/// A point that represents a piece of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const D: usize> {
    /// Position.
    pub(crate) at: [f64; D],
    /// Area of the piece.
    pub(crate) area: f64,
    /// Stiffness of the piece.
    pub(crate) stiffness: f64,
}

/// Sub-cells per lattice span and axis. The solution is within 4e-4 of a cell of that with fifteen (docs/METHOD.md, "Samples").
const SUBCELLS: usize = 3;
/// Number of spans from which on two sub-cells per span suffice, in 2D, and in 3D, where a sub-cell has six points.
const MANY_SPANS: [usize; 2] = [12, 5];
/// Maximum number of sub-cells per axis of a Bernstein grid: its basis functions are about √n spans wide, so more would add no
/// information.
const BERNSTEIN_LIMIT: usize = 64;

/// Number of sub-cells of a grid along each axis.
pub(crate) fn subcell_dims<const D: usize>(grid: &Grid<D>) -> [usize; D] {
    let many = MANY_SPANS[usize::from(D > 2)];
    grid.dims.map(|count| {
        let spans = grid.basis.spans(count);
        let wanted = spans * if spans < many { SUBCELLS } else { SUBCELLS - 1 };
        if grid.basis.is_local() { wanted } else { wanted.min(BERNSTEIN_LIMIT) }
    })
}
