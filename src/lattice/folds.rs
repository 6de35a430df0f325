//! Cells of a lattice that turn over.
//!
//! In: a solved 2D lattice. Out: cells between rest handles with det J ≤ 0 at any of 4 x 4 probe points.

use super::{Basis, Grid, Lattice};
use crate::space::ScreenPoint;

/// Probe points a cell and axis; neighbours share the outer ones.
const PROBES: usize = 4;

impl<const D: usize> Lattice<D> {
    /// How many cells turn over; 0 in space, where cells are not probed.
    #[must_use]
    pub fn folded_cell_count(&self) -> usize {
        let Ok(dims) = <[usize; 2]>::try_from(self.grid.dims.as_slice()) else { return 0 };
        let plane = |corner: [f64; D]| [corner[0], corner[1]];
        let grid = Grid { dims, basis: self.grid.basis, lo: plane(self.grid.lo), hi: plane(self.grid.hi) };
        Lattice { grid, handles: self.handles.iter().map(|&handle| plane(handle)).collect() }.folded_cells().len()
    }
}

impl Lattice<2> {
    /// Cells between handles (column, row), 0..dims−1, in which the warp turns over (det J ≤ 0 at any probe point).
    ///
    /// B-spline cells outside the box hold no picture and never count.
    #[must_use]
    pub fn folded_cells(&self) -> Vec<[usize; 2]> {
        let margin = usize::from(self.grid.basis == Basis::Bspline);
        let spans = self.grid.dims.map(|count| self.grid.basis.spans(count));
        let cells = (0..spans[1]).flat_map(|row| (0..spans[0]).map(move |column| [column, row]));
        cells.filter(|&cell| self.is_folded(cell)).map(|cell| cell.map(|place| place + margin)).collect()
    }

    /// Whether any probe point of a cell, counted from the box's lower corner, turns over.
    fn is_folded(&self, cell: [usize; 2]) -> bool {
        (0..PROBES * PROBES).any(|probe| {
            let [x, y] = std::array::from_fn(|axis| {
                // Probes keep off the border by a hair so that each lies in its own cell.
                let step = [probe % PROBES, probe / PROBES][axis] as f64 / (PROBES - 1) as f64;
                let inside = 1e-9 + step * (1.0 - 2e-9);
                self.grid.lo[axis] + (cell[axis] as f64 + inside) * self.grid.pitch(axis)
            });
            let det = self.jacobian(ScreenPoint::new(x, y)).determinant();
            // A NaN counts as folded.
            !(det > 0.0)
        })
    }
}
