//! Least-squares rows over handles: pins, moved handles and regularisers all have the form Σ w ‖row·P − target‖².
//!
//! In: sparse rows, each with a weight and a target. Out: their contributions to the normal matrix, right-hand side and energy.

use super::cancel::Cancel;
use super::linalg::normal_matrix::{NormalMatrix, index_extent};
use super::linalg::syrk::SyrkRows;
use pulp::Simd;

/// Sparse rows of one energy term.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeastSquaresRows<const D: usize> {
    ends: Vec<usize>,
    entries: Vec<(usize, f64)>,
    weights: Vec<f64>,
    targets: Vec<[f64; D]>,
}

impl<const D: usize> LeastSquaresRows<D> {
    /// Creates a term without rows.
    pub(crate) fn new() -> Self {
        Self { ends: Vec::new(), entries: Vec::new(), weights: Vec::new(), targets: Vec::new() }
    }

    /// Appends a row of (handle, coefficient).
    pub(crate) fn push(&mut self, weight: f64, row: impl IntoIterator<Item = (usize, f64)>, target: [f64; D]) {
        self.entries.extend(row);
        self.ends.push(self.entries.len());
        self.weights.push(weight);
        self.targets.push(target);
    }

    /// Appends all rows of another term.
    pub(crate) fn extend(&mut self, other: &Self) {
        for index in 0..other.len() {
            self.push(other.weights[index], other.row(index).iter().copied(), other.targets[index]);
        }
    }

    /// Returns the rows over other unknowns; entries of handles without an unknown are left out.
    pub(crate) fn mapped(&self, unknown_of: impl Fn(usize) -> Option<usize>) -> Self {
        let mut mapped = Self::new();
        for index in 0..self.len() {
            let row = self.row(index).iter();
            let row = row.filter_map(|&(handle, value)| Some((unknown_of(handle)?, value)));
            mapped.push(self.weights[index], row, self.targets[index]);
        }
        mapped
    }

    /// Number of rows.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Replaces the target of a row.
    pub(crate) fn set_target(&mut self, row: usize, target: [f64; D]) {
        self.targets[row] = target;
    }

    /// Replaces the weight of a row.
    pub(crate) fn set_weight(&mut self, row: usize, weight: f64) {
        self.weights[row] = weight;
    }

    /// Weight of a row.
    pub(crate) fn weight(&self, row: usize) -> f64 {
        self.weights[row]
    }

    /// Target of a row.
    pub(crate) fn target(&self, row: usize) -> [f64; D] {
        self.targets[row]
    }

    /// Entries of a row as (handle, coefficient).
    pub(crate) fn row(&self, index: usize) -> &[(usize, f64)] {
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        &self.entries[start..self.ends[index]]
    }

    /// Largest difference of handle indices within a row.
    pub(crate) fn bandwidth(&self) -> usize {
        (0..self.len()).filter_map(|index| index_extent(self.row(index).iter().map(|entry| entry.0))).max().unwrap_or(0)
    }

    /// Adds scale · Σ w rowᵀ row to the normal matrix.
    pub(crate) fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        let is_full = |row: &[(usize, f64)]| row.len() == normal.size && row.is_sorted_by(|a, b| a.0 < b.0);
        if (0..self.len()).all(|index| is_full(self.row(index))) {
            return normal.add_syrk(scale, &mut FullRows(self), cancel);
        }
        for index in 0..self.len() {
            normal.add_row(scale * self.weights[index], self.row(index));
        }
    }

    /// Adds scale · Σ w rowᵀ target to the right-hand side.
    pub(crate) fn add_right_side(&self, scale: f64, right_side: &mut [[f64; D]]) {
        for index in 0..self.len() {
            let (weight, target) = (scale * self.weights[index], self.targets[index]);
            for &(handle, coefficient) in self.row(index) {
                (0..D).for_each(|d| right_side[handle][d] += weight * coefficient * target[d]);
            }
        }
    }

    /// Returns row·P.
    pub(crate) fn image(&self, index: usize, handles: &[[f64; D]]) -> [f64; D] {
        let mut image = [0.0; D];
        for &(handle, coefficient) in self.row(index) {
            (0..D).for_each(|d| image[d] += coefficient * handles[handle][d]);
        }
        image
    }

    /// Returns the residual row·P − target.
    pub(crate) fn residual(&self, index: usize, handles: &[[f64; D]]) -> [f64; D] {
        let mut residual = self.targets[index].map(|x| -x);
        for &(handle, coefficient) in self.row(index) {
            (0..D).for_each(|d| residual[d] += coefficient * handles[handle][d]);
        }
        residual
    }

    /// Energy Σ w ‖row·P − target‖².
    pub(crate) fn energy(&self, handles: &[[f64; D]]) -> f64 {
        (0..self.len())
            .map(|index| {
                let residual = self.residual(index, handles);
                self.weights[index] * residual.iter().map(|x| x * x).sum::<f64>()
            })
            .sum()
    }
}

/// Rows with an entry for every handle, in order.
struct FullRows<'a, const D: usize>(&'a LeastSquaresRows<D>);

impl<const D: usize> SyrkRows for FullRows<'_, D> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, _: S, row: usize, [a, b]: [&mut [f64]; 2]) {
        let (weight, entries) = (self.0.weights[row], self.0.row(row));
        for ((a, b), &(_, coefficient)) in a.iter_mut().zip(b).zip(entries) {
            (*a, *b) = (weight * coefficient, coefficient);
        }
    }
}
