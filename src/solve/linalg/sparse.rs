//! Sparse Cholesky factorisation, for meshes and for wide bands with few entries, which a banded factor would fill. Crate faer,
//! with its approximate minimum degree ordering (P. Amestoy, T. Davis and I. Duff, "An Approximate Minimum Degree Ordering
//! Algorithm", 1996).
//!
//! In: the lower half of a symmetric positive definite matrix. Out: solutions for its right-hand sides.

use super::band_storage::stride;
use super::normal_matrix::NormalMatrix;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat, Triplet};
use faer::{Mat, Side};

/// Smallest size · bandwidth² (twice the multiply-adds of a banded factorisation) for which a sparse factorisation is considered.
const MIN_BANDED_COST: f64 = 2e9;

/// Largest fraction of entries in the band for which a sparse factorisation is faster.
const MAX_FILL: f64 = 0.1;

/// A factored sparse matrix.
#[derive(Debug)]
pub(crate) struct SparseFactor {
    factor: Llt<usize, f64>,
}

impl SparseFactor {
    /// Factors the matrix with these entries, row ≥ column; entries in the same position add up. `None` if it is not positive
    /// definite.
    pub(crate) fn new(size: usize, entries: &[(usize, usize, f64)]) -> Option<Self> {
        let entries: Vec<_> = entries.iter().map(|&(row, column, value)| Triplet::new(row, column, value)).collect();
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries).ok()?;
        Some(Self { factor: matrix.sp_cholesky(Side::Lower).ok()? })
    }

    /// The entries of a matrix with a wide band and few entries; `None` if a banded factorisation is preferable.
    pub(super) fn entries(normal: &NormalMatrix) -> Option<SparseColMat<usize, f64>> {
        let (size, band) = (normal.size, normal.band);
        if size as f64 * (band as f64).powi(2) < MIN_BANDED_COST || !normal.downdates.is_empty() {
            return None;
        }
        let most = (MAX_FILL * (size * band) as f64) as usize;
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for (j, column) in normal.columns.chunks_exact(stride(band)).take(size).enumerate() {
            for (k, &value) in column[..=band.min(size - 1 - j)].iter().enumerate() {
                // A zero on the diagonal is stored too, so that the factorisation detects that the matrix is singular.
                if value != 0.0 || k == 0 {
                    rows.push(j + k);
                    values.push(value);
                }
            }
            if rows.len() > most {
                return None;
            }
            starts.push(rows.len());
        }
        let pattern = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        Some(SparseColMat::new(pattern, values))
    }

    /// Factors a matrix given by its entries; `None` if it is not positive definite or contains a NaN.
    pub(super) fn of(entries: &SparseColMat<usize, f64>) -> Option<Self> {
        if !entries.val().iter().all(|value| value.is_finite()) {
            return None;
        }
        let pattern = SymbolicLlt::try_new(entries.symbolic(), Side::Lower).ok()?;
        Some(Self { factor: Llt::try_new_with_symbolic(pattern, entries.as_ref(), Side::Lower).ok()? })
    }

    /// Solves in place for D right-hand sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        let solved = self.factor.solve(Mat::from_fn(x.len(), D, |row, column| x[row][column]));
        for (row, values) in x.iter_mut().enumerate() {
            *values = std::array::from_fn(|column| solved[(row, column)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::cancel::Cancel;
    use crate::solve::linalg::factorization::Factorization;

    /// Chains of coupled unknowns. They are numbered across the chains, so the band is wide with few entries.
    fn crosswise(diagonal: f64) -> NormalMatrix {
        let (chains, length) = (1200, 4);
        let mut normal = NormalMatrix::zero(chains * length, chains);
        for k in 0..chains * length {
            normal.add(k, k, diagonal + (k as f64).sin());
            if k + chains < chains * length {
                normal.add(k + chains, k, (k as f64).cos());
            }
        }
        normal
    }

    #[test]
    fn wide_bands_with_few_entries_have_sparse_factors() {
        let normal = crosswise(9.0);
        let factor = Factorization::new(&normal, &Cancel::never()).expect("a positive definite matrix");
        assert!(matches!(factor, Factorization::Sparse(_)));
        let wanted: Vec<[f64; 2]> = (0..normal.size).map(|k| [(k as f64).cos(), k as f64]).collect();
        let mut product = vec![[0.0; 2]; normal.size];
        normal.subtract_matvec(&wanted, &mut product);
        let mut x: Vec<[f64; 2]> = product.iter().map(|values| values.map(|value| -value)).collect();
        factor.solve(&mut x);
        for (x, wanted) in x.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((x - wanted).abs() < 1e-12 * (1.0 + wanted.abs()), "{x} {wanted}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_sparse_factor() {
        for diagonal in [-9.0, f64::NAN] {
            assert!(Factorization::of_positive(crosswise(diagonal), &Cancel::never()).is_none(), "{diagonal}");
        }
    }

    #[test]
    fn full_bands_have_no_sparse_factors() {
        let mut normal = crosswise(2000.0);
        for column in 0..normal.size - 400 {
            (1..400).for_each(|below| normal.add(column + below, column, 0.1));
        }
        assert!(SparseFactor::entries(&normal).is_none());
    }
}
