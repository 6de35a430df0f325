//! Factorisations of the normal matrix: banded, dense or sparse Cholesky, banded with a low-rank correction, or LU. Crate faer.
//!
//! In: a symmetric matrix. Out: solutions for its right-hand sides.

use super::band_storage::stride;
use super::cholesky::Cholesky;
use super::normal_matrix::{MIN_DENSE_SIZE, NormalMatrix};
use super::small_matrix::{SquareMatrix, identity, symmetric_eigen};
use super::sparse::SparseFactor;
use crate::solve::cancel::Cancel;
use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Mat, Side};

/// Up to this size the banded factorisation is faster even for dense matrices, which faer would have to copy first.
const MAX_BANDED_DENSE: usize = 256;

/// Above this size faer's dense kernels, which cannot be interrupted, take too long.
const MAX_UNPOLLED: usize = 1024;

/// A factored matrix.
#[derive(Debug)]
pub(crate) enum Factorization {
    /// L Lᵀ.
    Cholesky(Cholesky),
    /// L Lᵀ − U Uᵀ.
    Corrected(Corrected),
    /// P L Lᵀ Pᵀ, for wide bands with few entries.
    Sparse(SparseFactor),
    /// LU with partial pivoting, for matrices that negative cotangents make indefinite.
    Lu(Box<PartialPivLu<f64>>),
}

impl Factorization {
    /// Factors a matrix; `None` if it is singular, contains a NaN, or the solve is cancelled.
    pub(crate) fn new(normal: &NormalMatrix, cancel: &Cancel) -> Option<Self> {
        if let Some(factor) = Self::of_positive(normal.padded(), cancel) {
            return Some(factor);
        }
        cancel.check().ok()?;
        let mut full = normal.full();
        for j in 0..normal.size {
            (j + 1..normal.size).for_each(|i| full[(j, i)] = full[(i, j)]);
        }
        let lu = PartialPivLu::new(full.as_ref());
        let diagonal = (0..normal.size).map(|k| lu.U()[(k, k)].abs());
        let (least, most) = diagonal.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (least > 1e-15 * most && most.is_finite()).then(|| Self::Lu(Box::new(lu)))
    }

    /// Factors a positive definite matrix; `None` if it is not positive definite, or the solve is cancelled.
    pub(crate) fn of_positive(normal: NormalMatrix, cancel: &Cancel) -> Option<Self> {
        if let Some(corrected) = Corrected::new(&normal, cancel) {
            return Some(Self::Corrected(corrected));
        }
        if let Some(entries) = SparseFactor::entries(&normal) {
            drop(normal);
            return SparseFactor::of(&entries).map(Self::Sparse);
        }
        let is_large = normal.size > MAX_UNPOLLED;
        if (normal.is_banded_enough() || normal.size <= MAX_BANDED_DENSE || is_large) && normal.downdates.is_empty() {
            return Cholesky::new(normal.band, normal.columns, cancel).map(Self::Cholesky);
        }
        let band = normal.size.saturating_sub(1);
        if is_large {
            return Cholesky::new(band, normal.dense_columns(), cancel).map(Self::Cholesky);
        }
        let columns = dense_cholesky(&normal.full())?;
        Some(Self::Cholesky(Cholesky::from_factor(band, columns)))
    }

    /// The memory of the factor, for reuse; empty for factors without a reusable buffer.
    pub(crate) fn into_buffer(self) -> Vec<f64> {
        match self {
            Self::Cholesky(cholesky) => cholesky.into_buffer(),
            Self::Corrected(_) | Self::Sparse(_) | Self::Lu(_) => Vec::new(),
        }
    }

    /// Solves in place for D right-hand sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        match self {
            Self::Cholesky(cholesky) => cholesky.solve(x),
            Self::Corrected(corrected) => corrected.solve(x),
            Self::Sparse(sparse) => sparse.solve(x),
            Self::Lu(lu) => {
                let solved = lu.solve(Mat::from_fn(x.len(), D, |row, column| x[row][column]));
                for (row, values) in x.iter_mut().enumerate() {
                    *values = std::array::from_fn(|column| solved[(row, column)]);
                }
            }
        }
    }
}

/// A banded factor with a low-rank correction: (N − UUᵀ)⁻¹ = N⁻¹ + Y UᵀN⁻¹ with Y = N⁻¹U (I − UᵀN⁻¹U)⁻¹ (M. A. Woodbury,
/// "Inverting modified matrices", 1950). A solve costs a few dot products more than that of the band.
#[derive(Debug)]
pub(crate) struct Corrected {
    banded: Cholesky,
    /// Pairs of columns of U and Y.
    pairs: Vec<[Vec<f64>; 2]>,
}

/// Largest number of columns of U. An affine map has six coefficients in 2D, and four per coordinate in 3D.
const MAX_RANK: usize = 8;

/// Smallest accepted eigenvalue of I − UᵀN⁻¹U, all of which lie in 0..=1. Below it cancellation loses digits, and a dense factor
/// is used.
const MIN_EIGENVALUE: f64 = 1e-3;

impl Corrected {
    /// Factors a banded matrix with downdates; `None` if a dense factor is preferable.
    fn new(normal: &NormalMatrix, cancel: &Cancel) -> Option<Self> {
        let count = normal.downdates.len();
        let fits = (1..=MAX_RANK).contains(&count) && normal.size >= MIN_DENSE_SIZE && normal.is_banded_enough();
        let banded = if fits { Cholesky::new(normal.band, normal.columns.clone(), cancel) } else { None }?;
        let roots = |(weight, square): &(f64, Vec<f64>)| square.iter().map(|x| weight.sqrt() * x).collect();
        let u: Vec<Vec<f64>> = normal.downdates.iter().map(roots).collect();
        let solved: Vec<Vec<[f64; 1]>> = u.iter().map(|column| banded.solved(column)).collect();
        let mut left: SquareMatrix<MAX_RANK> = identity();
        for a in 0..count {
            for b in 0..count {
                left[a][b] -= u[a].iter().zip(&solved[b]).map(|(x, [y])| x * y).sum::<f64>();
            }
        }
        let inverse = inverse_of_positive(&left)?;
        let corrections = inverse.map(|row| {
            let entry = |k: usize| (0..count).map(|a| row[a] * solved[a][k][0]).sum::<f64>();
            (0..normal.size).map(entry).collect::<Vec<f64>>()
        });
        Some(Self { banded, pairs: u.into_iter().zip(corrections).map(|(u, y)| [u, y]).collect() })
    }

    fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        self.banded.solve(x);
        let share = |u: &Vec<f64>| -> [f64; D] {
            let mut sum = [0.0; D];
            u.iter().zip(x.iter()).for_each(|(u, x)| (0..D).for_each(|d| sum[d] += u * x[d]));
            sum
        };
        let shares: Vec<[f64; D]> = self.pairs.iter().map(|[u, _]| share(u)).collect();
        for ([_, y], share) in self.pairs.iter().zip(shares) {
            x.iter_mut().zip(y).for_each(|(x, y)| (0..D).for_each(|d| x[d] += y * share[d]));
        }
    }
}

/// The inverse of a symmetric matrix; `None` if an eigenvalue is not above [`MIN_EIGENVALUE`].
fn inverse_of_positive<const N: usize>(m: &SquareMatrix<N>) -> Option<SquareMatrix<N>> {
    let (values, vectors) = symmetric_eigen(m);
    let entry = |a: usize, b: usize| (0..N).map(|k| vectors[a][k] * vectors[b][k] / values[k]).sum();
    let inverse = std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)));
    values.iter().all(|&value| value > MIN_EIGENVALUE).then_some(inverse)
}

/// Dense Cholesky by faer, with columns as in [`Cholesky`] and a full band.
fn dense_cholesky(full: &Mat<f64>) -> Option<Vec<f64>> {
    let size = full.nrows();
    let llt = Llt::new(full.as_ref(), Side::Lower).ok()?;
    let lower = llt.L();
    let mut columns = vec![0.0; size * stride(size - 1)];
    for (j, column) in columns.chunks_exact_mut(stride(size - 1)).enumerate() {
        (0..size - j).for_each(|k| column[k] = lower[(j + k, j)]);
        column[0] = 1.0 / column[0];
    }
    columns.iter().all(|x| x.is_finite()).then_some(columns)
}
