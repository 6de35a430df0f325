//! Measures of how strongly a branching lattice bends.
//!
//! In: a [`BranchedLattice`]. Out: an upper estimate of its second derivative in each cell, and its strain in the cells at the
//! border of the box.

use super::BranchedLattice;
use crate::lattice::Grid;

impl<const D: usize> BranchedLattice<D> {
    /// An upper estimate of the norm of the second derivative of a branch in each cell, #cells; 0 where the branch has no part of the
    /// shape. Second derivatives of B-splines are averages of second differences of the surrounding handles (C. de Boor,
    /// "A Practical Guide to Splines", 1978, chapter X).
    #[must_use]
    pub(crate) fn bending(&self, branch: usize) -> Vec<f64> {
        let mut cells = vec![0.0_f64; self.grid().cell_count()];
        let differences = self.second_differences(branch);
        for (cell, handles) in self.cells_of(branch) {
            cells[cell] = handles.into_iter().map(|handle| differences[handle]).fold(cells[cell], f64::max);
        }
        cells
    }

    /// For every handle the largest second difference that begins at it, divided by the squared spacing; 0 if the branch lacks a
    /// handle that it needs.
    fn second_differences(&self, branch: usize) -> Vec<f64> {
        let grid = self.grid();
        let place = |handle: usize| self.copy_place(branch, handle);
        let mut greatest = vec![0.0_f64; grid.handle_count()];
        for (start, greatest) in greatest.iter_mut().enumerate() {
            for [a, b] in (0..D).flat_map(|a| (a..D).map(move |b| [a, b])) {
                let Some(corners) = corners(grid, start, [a, b]) else { continue };
                let [Some(p), Some(q), Some(r), Some(s)] = corners.map(place) else { continue };
                let square: f64 = (0..D).map(|d| (p[d] - q[d] - r[d] + s[d]).powi(2)).sum();
                // A mixed difference occurs twice in the Frobenius norm.
                let count = if a == b { 1.0 } else { std::f64::consts::SQRT_2 };
                *greatest = greatest.max(count * square.sqrt() / (grid.spacing(a) * grid.spacing(b)));
            }
        }
        greatest
    }

    /// The largest Frobenius norm of gradient minus identity at the centres of the cells of a branch along the border of the box.
    #[must_use]
    pub(crate) fn greatest_strain_at_border(&self, branch: usize) -> f64 {
        let grid = self.grid();
        let last: [usize; D] = std::array::from_fn(|axis| grid.basis.spans(grid.dims[axis]) - 1);
        let mut greatest = 0.0_f64;
        let lattice = self.lattice(branch);
        for (cell, _) in self.cells_of(branch) {
            let place = grid.cell_coords(cell);
            if (0..D).any(|axis| place[axis] == 0 || place[axis] == last[axis]) {
                let middle = grid.point_from_spans(place.map(|place| place as f64 + 0.5));
                let gradient = lattice.evaluate_with_gradient(middle).gradient;
                let square = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
                let square: f64 = square.map(|(i, j)| (gradient[i][j] - f64::from(u8::from(i == j))).powi(2)).sum();
                greatest = greatest.max(square.sqrt());
            }
        }
        greatest
    }
}

/// The four handles of a second difference that begins at a handle, with signs +, -, -, +; `None` if it would extend beyond the
/// grid.
fn corners<const D: usize>(grid: &Grid<D>, start: usize, [a, b]: [usize; 2]) -> Option<[usize; 4]> {
    let place = grid.handle_coords(start);
    let steps = |axis: usize| usize::from(axis == a) + usize::from(axis == b);
    if (0..D).any(|axis| place[axis] + steps(axis) >= grid.dims[axis]) {
        return None;
    }
    let [along_a, along_b] = [a, b].map(|axis| grid.stride(axis));
    Some([start, start + along_a, start + along_b, start + along_a + along_b])
}
