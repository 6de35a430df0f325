//! Cells of a lattice that turn over.
//!
//! In: a solved 2D lattice. Out: cells between rest handles with det J ≤ 0 at any of 3 x 3 probe points.

use super::{AxisTerms, Basis, Grid, Lattice};
use crate::space::ScreenPoint;
use glam::DVec2;

/// Probe points a cell and axis; the outer ones lie on its border.
const PROBES: usize = 3;
/// Probes keep off the border by this part of a cell, so that each lies in its own.
const INSET: f64 = 1e-9;

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
        let columns: Vec<Column> = (0..spans[0] * PROBES).map(|probe| self.column(probe)).collect();
        let rows: Vec<AxisTerms> = (0..spans[1] * PROBES).map(|probe| self.terms(1, probe)).collect();
        let is_folded = |[column, row]: [usize; 2]| {
            (0..PROBES * PROBES).any(|probe| {
                let at = [column * PROBES + probe % PROBES, row * PROBES + probe / PROBES];
                let det = match self.grid.basis {
                    Basis::Barytri => self.probe_gradient(at),
                    _ => columns[at[0]].determinant(&rows[at[1]]),
                };
                det.is_nan() || det <= 0.0
            })
        };
        let cells = (0..spans[1]).flat_map(|row| (0..spans[0]).map(move |column| [column, row]));
        cells.filter(|&cell| is_folded(cell)).map(|cell| cell.map(|place| place + margin)).collect()
    }

    /// Box coordinate of a probe.
    fn unit(&self, axis: usize, probe: usize) -> f64 {
        let step = (probe % PROBES) as f64 / (PROBES - 1) as f64;
        let inside = INSET + step * (1.0 - 2.0 * INSET);
        ((probe / PROBES) as f64 + inside) / self.grid.basis.spans(self.grid.dims[axis]) as f64
    }

    fn terms(&self, axis: usize, probe: usize) -> AxisTerms {
        AxisTerms::at(self.grid.basis, self.grid.dims[axis], self.unit(axis, probe))
    }

    /// Every row of handles, blended along x at one probe.
    fn column(&self, probe: usize) -> Column {
        let terms = self.terms(0, probe);
        let blend = |row: &[[f64; 2]], factors: &[f64]| -> DVec2 {
            row[terms.first..].iter().zip(factors).map(|(&handle, &factor)| DVec2::from(handle) * factor).sum()
        };
        let rows = self.handles.chunks_exact(self.grid.dims[0]);
        Column(rows.map(|row| [blend(row, terms.values()), blend(row, terms.slopes())]).collect())
    }

    /// Determinant at a probe, without blending by axes.
    fn probe_gradient(&self, at: [usize; 2]) -> f64 {
        let [x, y] = std::array::from_fn(|axis| self.grid.lo[axis] + self.unit(axis, at[axis]) * self.grid.size(axis));
        self.jacobian(ScreenPoint::new(x, y)).determinant()
    }
}

/// Value and x slope of every row of handles at one x.
struct Column(Vec<[DVec2; 2]>);

impl Column {
    /// The determinant's sign at one y (its size is per unit of box coordinates).
    fn determinant(&self, y: &AxisTerms) -> f64 {
        let (mut along, mut across) = (DVec2::ZERO, DVec2::ZERO);
        for ([value, slope], (weight, rise)) in self.0[y.first..].iter().zip(y.values().iter().zip(y.slopes())) {
            along += *slope * *weight;
            across += *value * *rise;
        }
        along.perp_dot(across)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handle_pulled_across_its_neighbours_folds_cells_around_it() {
        for basis in [Basis::Bspline, Basis::Bilinear, Basis::Barytri] {
            let mut lattice = Grid { dims: [8, 8], basis, lo: [0.0, 0.0], hi: [1.0, 1.0] }.at_rest();
            assert_eq!(lattice.folded_cells(), Vec::<[usize; 2]>::new());
            lattice.handles[4 + 8 * 4][0] += 2.0;
            let folded = lattice.folded_cells();
            assert!(!folded.is_empty() && folded.iter().all(|cell| cell.iter().all(|place| (2..=6).contains(place))));
            assert_eq!(folded.len(), lattice.folded_cell_count());
        }
    }

    #[test]
    fn a_mirrored_lattice_is_folded_everywhere() {
        let mut lattice = Grid { dims: [4, 5], basis: Basis::Bernstein, lo: [0.0, 0.0], hi: [1.0, 1.0] }.at_rest();
        lattice.handles.iter_mut().for_each(|handle| handle[0] = -handle[0]);
        assert_eq!(lattice.folded_cells().len(), 3 * 4);
    }
}
