//! Symmetric matrices over handles: built term by term, factored once, solved often. The only place that knows faer.
//!
//! In: least-squares rows and Gram blocks. Out: a Cholesky factor (banded for local bases) and its solutions.

use super::packs::dispatch;
use super::small::{Square, identity, symmetric_eigen};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Accum, Mat, MatRef, Par, Side};
use pulp::{Simd, WithSimd};

/// The lower half of a symmetric #handles × #handles matrix; column j holds rows j..=j+band.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    size: usize,
    band: usize,
    columns: Vec<f64>,
    /// What is taken off: Σ weight · column columnᵀ, dense but of low rank.
    squares: Vec<(f64, Vec<f64>)>,
}

impl Normal {
    /// A zero matrix in which handles farther than `band` apart never meet.
    pub(crate) fn zero(size: usize, band: usize) -> Self {
        let band = band.min(size.saturating_sub(1));
        Self { size, band, columns: vec![0.0; size * (band + 1)], squares: Vec::new() }
    }

    /// Every handle may meet every other.
    pub(crate) fn is_dense(&self) -> bool {
        self.band + 1 >= self.size
    }

    /// Adds to one entry of the symmetric matrix.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        let (high, low) = (row.max(column), row.min(column));
        debug_assert!(high - low <= self.band, "entry outside the band");
        self.columns[low * (self.band + 1) + high - low] += value;
    }

    /// Adds weight · row rowᵀ.
    pub(crate) fn add_row(&mut self, weight: f64, row: impl Iterator<Item = (usize, f64)> + Clone) {
        let mut rest = row;
        while let Some((handle, coefficient)) = rest.next() {
            self.add(handle, handle, weight * coefficient * coefficient);
            for (other, factor) in rest.clone() {
                self.add(handle, other, weight * coefficient * factor);
            }
        }
    }

    /// Takes off weight · column columnᵀ for each column (#handles); the sum has to stay positive definite.
    pub(crate) fn subtract_squares(&mut self, weight: f64, columns: &[Vec<f64>]) {
        self.squares.extend(columns.iter().map(|column| (weight, column.clone())));
    }

    /// Adds scale · aᵀb, known to be symmetric; a and b are #rows × #handles, row by row. Dense matrices only.
    pub(crate) fn add_product(&mut self, scale: f64, a: &[f64], b: &[f64]) {
        let rows = a.len() / self.size;
        let [a, b] = [a, b].map(|rows_of| MatRef::from_column_major_slice(rows_of, self.size, rows));
        let mut product = Mat::<f64>::zeros(self.size, self.size);
        matmul(
            &mut product,
            BlockStructure::TriangularLower,
            Accum::Replace,
            a,
            BlockStructure::Rectangular,
            b.transpose(),
            BlockStructure::Rectangular,
            scale,
            Par::Seq,
        );
        let stride = self.band + 1;
        for (j, column) in self.columns.chunks_exact_mut(stride).enumerate() {
            let below = &product.col_as_slice(j)[j..];
            column.iter_mut().zip(below).for_each(|(slot, x)| *slot += x);
        }
    }

    /// Mean of the diagonal.
    pub(crate) fn mean_diagonal(&self) -> f64 {
        (0..self.size).map(|j| self.columns[j * (self.band + 1)]).sum::<f64>() / self.size.max(1) as f64
    }

    /// The lower half in faer's storage; zero above the diagonal.
    fn full(&self) -> Mat<f64> {
        let stride = self.band + 1;
        let mut full = Mat::zeros(self.size, self.size);
        for (j, column) in self.columns.chunks_exact(stride).enumerate() {
            let below = &mut full.col_as_slice_mut(j)[j..];
            below.iter_mut().zip(column).for_each(|(slot, x)| *slot = *x);
        }
        for (weight, square) in &self.squares {
            for j in 0..self.size {
                let below = &mut full.col_as_slice_mut(j)[j..];
                below.iter_mut().zip(&square[j..]).for_each(|(slot, x)| *slot -= weight * square[j] * x);
            }
        }
        full
    }
}

/// Up to here banded loops beat dense kernels whatever the band.
const SMALL: usize = 48;

/// The pseudo-inverse of a small symmetric positive semidefinite matrix (size x size, any order), and the projector onto
/// the directions it leaves out: those whose eigenvalue is below `cutoff` times the largest.
pub(crate) fn pseudo_inverse(entries: &[f64], size: usize, cutoff: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut inverse, mut dropped) = (vec![0.0; size * size], vec![0.0; size * size]);
    let symmetric = Mat::from_fn(size, size, |i, j| 0.5 * (entries[i * size + j] + entries[j * size + i]));
    let Ok(eigen) = symmetric.self_adjoint_eigen(Side::Lower) else { return (inverse, dropped) };
    let (values, vectors) = (eigen.S().column_vector(), eigen.U());
    let largest = (0..size).map(|k| values[k]).fold(0.0, f64::max);
    for k in 0..size {
        let is_kept = values[k] > cutoff * largest;
        let (target, factor) = if is_kept { (&mut inverse, 1.0 / values[k]) } else { (&mut dropped, 1.0) };
        for (i, row) in target.chunks_exact_mut(size).enumerate() {
            row.iter_mut().enumerate().for_each(|(j, slot)| *slot += factor * vectors[(i, k)] * vectors[(j, k)]);
        }
    }
    (inverse, dropped)
}

/// A factored matrix.
#[derive(Debug)]
pub(crate) enum Factor {
    /// L Lᵀ.
    Cholesky(Cholesky),
    /// L Lᵀ − U Uᵀ.
    Corrected(Corrected),
    /// For matrices that negative cotangents make indefinite.
    Lu(Box<PartialPivLu<f64>>),
}

/// L, by columns and by rows, so that both substitutions run over contiguous numbers.
#[derive(Debug)]
pub(crate) struct Cholesky {
    size: usize,
    band: usize,
    /// L[j+k][j] at j·(band+1) + k; the diagonal holds 1/L[j][j].
    columns: Vec<f64>,
    /// L[i][i−k] at i·(band+1) + band − k.
    rows: Vec<f64>,
}

impl Factor {
    /// Factors a matrix; `None` where it is singular or holds a NaN.
    pub(crate) fn new(normal: Normal) -> Option<Self> {
        if let Some(corrected) = Corrected::new(&normal) {
            return Some(Self::Corrected(corrected));
        }
        let full = (!normal.is_banded_enough() || !normal.squares.is_empty()).then(|| normal.full());
        let columns = match &full {
            None => dispatch(Banded(&normal)),
            Some(full) => dense_cholesky(full),
        };
        if let Some(columns) = columns {
            return Some(Self::Cholesky(Cholesky::new(normal.size, normal.band, columns)));
        }
        let mut full = full.unwrap_or_else(|| normal.full());
        for j in 0..normal.size {
            (j + 1..normal.size).for_each(|i| full[(j, i)] = full[(i, j)]);
        }
        let lu = PartialPivLu::new(full.as_ref());
        let diagonal = (0..normal.size).map(|k| lu.U()[(k, k)].abs());
        let (least, most) = diagonal.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (least > 1e-15 * most && most.is_finite()).then(|| Self::Lu(Box::new(lu)))
    }

    /// Solves in place for D right sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        match self {
            Self::Cholesky(cholesky) => dispatch(Substitution { cholesky, x }),
            Self::Corrected(corrected) => corrected.solve(x),
            Self::Lu(lu) => {
                let solved = lu.solve(Mat::from_fn(x.len(), D, |row, column| x[row][column]));
                for (row, values) in x.iter_mut().enumerate() {
                    *values = std::array::from_fn(|column| solved[(row, column)]);
                }
            }
        }
    }
}

impl Normal {
    /// Banded storage pays where the band is well below the size; else faer's dense kernels win.
    fn is_banded_enough(&self) -> bool {
        self.size < SMALL || self.band * 2 < self.size
    }
}

/// A banded factor with a correction of low rank: (N − UUᵀ)⁻¹ = N⁻¹ + Y UᵀN⁻¹ with Y = N⁻¹U (I − UᵀN⁻¹U)⁻¹
/// (M. A. Woodbury, "Inverting modified matrices", 1950). It costs a few products of vectors more than the band.
#[derive(Debug)]
pub(crate) struct Corrected {
    banded: Cholesky,
    /// A column of U and of Y each.
    pairs: Vec<[Vec<f64>; 2]>,
}

/// Most columns of U: as many as an affine map of space has coefficients a coordinate.
const MOST_SQUARES: usize = 4;

/// Least eigenvalue of I − UᵀN⁻¹U, which lie in 0..=1: below it cancellation eats digits, and a dense factor is used.
const LEAST_LEFT: f64 = 1e-3;

impl Corrected {
    /// The factor of a banded matrix from which squares are taken off; `None` where a dense factor does better.
    fn new(normal: &Normal) -> Option<Self> {
        let count = normal.squares.len();
        let fits = (1..=MOST_SQUARES).contains(&count) && normal.size >= SMALL && normal.is_banded_enough();
        let columns = if fits { dispatch(Banded(normal)) } else { None }?;
        let banded = Cholesky::new(normal.size, normal.band, columns);
        let roots = |(weight, square): &(f64, Vec<f64>)| square.iter().map(|x| weight.sqrt() * x).collect();
        let u: Vec<Vec<f64>> = normal.squares.iter().map(roots).collect();
        let solved: Vec<Vec<[f64; 1]>> = u.iter().map(|column| banded.solved(column)).collect();
        let mut left: Square<MOST_SQUARES> = identity();
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
        dispatch(Substitution { cholesky: &self.banded, x });
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

/// The inverse of a symmetric matrix, unless an eigenvalue is below [`LEAST_LEFT`].
fn inverse_of_positive<const N: usize>(m: &Square<N>) -> Option<Square<N>> {
    let (values, vectors) = symmetric_eigen(m);
    let entry = |a: usize, b: usize| (0..N).map(|k| vectors[a][k] * vectors[b][k] / values[k]).sum();
    let inverse = std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)));
    values.iter().all(|&value| value > LEAST_LEFT).then_some(inverse)
}

/// Right-looking Cholesky inside the band; columns as in [`Cholesky`].
#[inline(always)]
fn banded_cholesky(normal: &Normal) -> Option<Vec<f64>> {
    let (size, stride) = (normal.size, normal.band + 1);
    let mut columns = normal.columns.clone();
    for j in 0..size {
        let (done, below) = columns.split_at_mut((j + 1) * stride);
        let column = &mut done[j * stride..];
        // `!(>)` also catches NaN.
        if !(column[0] > 0.0 && column[0].is_finite()) {
            return None;
        }
        let inverse = 1.0 / column[0].sqrt();
        column[0] = inverse;
        column[1..].iter_mut().for_each(|x| *x *= inverse);
        let reach = normal.band.min(size - 1 - j);
        for k in 1..=reach {
            let factor = column[k];
            let target = &mut below[(k - 1) * stride..][..reach + 1 - k];
            for (slot, x) in target.iter_mut().zip(&column[k..=reach]) {
                *slot -= factor * x;
            }
        }
    }
    Some(columns)
}

/// faer's dense Cholesky; columns as in [`Cholesky`] with band = size − 1.
fn dense_cholesky(full: &Mat<f64>) -> Option<Vec<f64>> {
    let size = full.nrows();
    let llt = Llt::new(full.as_ref(), Side::Lower).ok()?;
    let lower = llt.L();
    let mut columns = vec![0.0; size * size];
    for j in 0..size {
        let column = &mut columns[j * size..(j + 1) * size - j];
        (0..size - j).for_each(|k| column[k] = lower[(j + k, j)]);
        column[0] = 1.0 / column[0];
    }
    columns.iter().all(|x| x.is_finite()).then_some(columns)
}

/// Kernel of [`Factor::solve`].
struct Substitution<'a, const D: usize> {
    cholesky: &'a Cholesky,
    x: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Substitution<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.cholesky.solve(self.x);
    }
}

/// Kernel of the banded factorisation.
struct Banded<'a>(&'a Normal);

impl WithSimd for Banded<'_> {
    type Output = Option<Vec<f64>>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        banded_cholesky(self.0)
    }
}

impl Cholesky {
    fn new(size: usize, band: usize, columns: Vec<f64>) -> Self {
        // The dense path returns full columns whatever the band was.
        let band = if columns.len() == size * size { size.saturating_sub(1) } else { band };
        let stride = band + 1;
        let mut rows = vec![0.0; size * stride];
        for j in 0..size {
            for k in 1..=band.min(size - 1 - j) {
                rows[(j + k) * stride + band - k] = columns[j * stride + k];
            }
        }
        Self { size, band, columns, rows }
    }

    /// The solution for one right side.
    fn solved(&self, right_side: &[f64]) -> Vec<[f64; 1]> {
        let mut x: Vec<[f64; 1]> = right_side.iter().map(|&value| [value]).collect();
        dispatch(Substitution { cholesky: self, x: &mut x });
        x
    }

    /// L y = b, then Lᵀ x = y; both by subtracting multiples of contiguous columns.
    #[inline(always)]
    fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        let stride = self.band + 1;
        for j in 0..self.size {
            let (done, below) = x.split_at_mut(j + 1);
            let pivot = &mut done[j];
            pivot.iter_mut().for_each(|value| *value *= self.columns[j * stride]);
            for (target, factor) in below.iter_mut().zip(&self.columns[j * stride + 1..(j + 1) * stride]) {
                (0..D).for_each(|d| target[d] -= factor * pivot[d]);
            }
        }
        for i in (0..self.size).rev() {
            let (above, done) = x.split_at_mut(i);
            let pivot = &mut done[0];
            pivot.iter_mut().for_each(|value| *value *= self.columns[i * stride]);
            let reach = self.band.min(i);
            let factors = &self.rows[i * stride + self.band - reach..i * stride + self.band];
            for (target, factor) in above[i - reach..].iter_mut().zip(factors) {
                (0..D).for_each(|d| target[d] -= factor * pivot[d]);
            }
        }
    }
}
