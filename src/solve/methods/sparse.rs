//! Sparse Cholesky over vertices, for methods whose unknowns are the mesh itself. Crate faer.
//!
//! In: the lower half of a symmetric positive definite matrix. Out: its solutions.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// A factored sparse matrix.
#[derive(Debug)]
pub(super) struct SparseFactor {
    factor: Llt<usize, f64>,
}

impl SparseFactor {
    /// Factors the matrix with these entries, row ≥ column; entries at one place add up. `None` where it is not positive
    /// definite.
    pub(super) fn new(size: usize, entries: &[(usize, usize, f64)]) -> Option<Self> {
        let entries: Vec<_> = entries.iter().map(|&(row, column, value)| Triplet::new(row, column, value)).collect();
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries).ok()?;
        Some(Self { factor: matrix.sp_cholesky(Side::Lower).ok()? })
    }

    /// Solves in place for D right sides.
    pub(super) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        let solved = self.factor.solve(Mat::from_fn(x.len(), D, |row, column| x[row][column]));
        for (row, values) in x.iter_mut().enumerate() {
            *values = std::array::from_fn(|column| solved[(row, column)]);
        }
    }
}
