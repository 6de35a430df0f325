//! Symmetric matrices over handles: built term by term, factored once, solved often. Crate faer.
//!
//! In: least-squares rows and Gram blocks. Out: a Cholesky factor (banded for local bases) and its solutions.

use super::cholesky::{Cholesky, padded_length, stride};
use super::gram::Gram;
use super::packs::{LANES, dispatch, multiply_add, store};
use super::small::{Square, identity, symmetric_eigen};
use faer::linalg::solvers::{Llt, PartialPivLu, Solve};
use faer::{Mat, Side};
use pulp::{Simd, WithSimd};

/// The lower half of a symmetric #handles × #handles matrix; column j holds rows j..=j+band, then zeros.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(super) size: usize,
    pub(super) band: usize,
    pub(super) columns: Vec<f64>,
    /// What is taken off: Σ weight · column columnᵀ, dense but of low rank.
    squares: Vec<(f64, Vec<f64>)>,
}

impl Normal {
    /// A zero matrix in which handles farther than `band` apart never meet.
    pub(crate) fn zero(size: usize, band: usize) -> Self {
        let band = band.min(size.saturating_sub(1));
        Self { size, band, columns: vec![0.0; size * stride(band)], squares: Vec::new() }
    }

    /// Every handle may meet every other, and rows on `shared` handles each are rows on all of them: what
    /// [`Self::add_product`] asks for. A model within one cell shares a few handles only.
    pub(crate) fn is_full(&self, shared: usize) -> bool {
        self.band + 1 >= self.size && shared == self.size
    }

    /// Adds to one entry of the symmetric matrix.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        let (high, low) = (row.max(column), row.min(column));
        debug_assert!(high - low <= self.band, "entry outside the band");
        self.columns[low * stride(self.band) + high - low] += value;
    }

    /// Adds weight · row rowᵀ.
    pub(crate) fn add_row(&mut self, weight: f64, row: &[(usize, f64)]) {
        let stride = stride(self.band);
        let is_sorted = row.is_sorted_by(|a, b| a.0 < b.0);
        for (k, &(column, coefficient)) in row.iter().enumerate() {
            let factor = weight * coefficient;
            if is_sorted {
                let slots = &mut self.columns[column * stride..][..stride];
                row[k..].iter().for_each(|&(handle, other)| slots[handle - column] += factor * other);
            } else {
                row[k..].iter().for_each(|&(handle, other)| self.add(handle, column, factor * other));
            }
        }
    }

    /// Adds scale times a Gram matrix; `rows`: where its columns belong, ascending.
    #[inline(always)]
    pub(crate) fn add_gram(&mut self, scale: f64, rows: &[usize], gram: &Gram) {
        let stride = stride(self.band);
        // Rows come in runs of neighbours: so loops run over whole registers.
        let runs: Vec<&[usize]> = rows.chunk_by(|a, b| a + 1 == *b).collect();
        let mut b = 0;
        for (number, &run) in runs.iter().enumerate() {
            for (k, &column) in run.iter().enumerate() {
                let slots = &mut self.columns[column * stride..][..stride];
                let mut sums = gram.below(b);
                for below in std::iter::once(&run[k..]).chain(runs[number + 1..].iter().copied()) {
                    let (own, rest) = sums.split_at(below.len());
                    let targets = slots[below[0] - column..].iter_mut();
                    targets.zip(own).for_each(|(slot, sum)| *slot += scale * sum);
                    sums = rest;
                }
                b += 1;
            }
        }
    }

    /// Takes off weight · column columnᵀ for each column (#handles); the sum has to stay positive definite.
    pub(crate) fn subtract_squares(&mut self, weight: f64, columns: &[Vec<f64>]) {
        self.squares.extend(columns.iter().map(|column| (weight, column.clone())));
    }

    /// The matrix that does the same to every one of D coordinates; rows are D·handle + coordinate. `memory` is used
    /// again: fresh pages cost as much as the factorisation.
    pub(crate) fn repeated<const D: usize>(&self, mut memory: Vec<f64>) -> Self {
        let (size, band) = (D * self.size, D * (self.band + 1) - 1);
        let wide = stride(band);
        memory.reserve(padded_length(size, band).saturating_sub(memory.len()));
        memory.resize(size * wide, 0.0);
        for (j, column) in self.columns.chunks_exact(stride(self.band)).enumerate() {
            for slots in memory[D * j * wide..][..D * wide].chunks_exact_mut(wide) {
                spread::<D>(&column[..=self.band], slots);
            }
        }
        let mut repeated = Self { size, band, columns: memory, squares: Vec::new() };
        for (weight, square) in &self.squares {
            repeated.squares.extend((0..D).map(|d| {
                let spread = square.iter().flat_map(|&x| (0..D).map(move |other| if other == d { x } else { 0.0 }));
                (*weight, spread.collect())
            }));
        }
        repeated
    }

    /// A copy with room for the last panel of its factor.
    fn with_room(&self) -> Self {
        let mut columns = Vec::with_capacity(padded_length(self.size, self.band));
        columns.extend_from_slice(&self.columns);
        Self { size: self.size, band: self.band, columns, squares: self.squares.clone() }
    }

    /// Takes the product with `x` off `y`.
    pub(crate) fn subtract_product<const D: usize>(&self, x: &[[f64; D]], y: &mut [[f64; D]]) {
        dispatch(SubtractProduct { normal: self, x, y });
        for (weight, square) in &self.squares {
            let mut share = [0.0; D];
            square.iter().zip(x).for_each(|(c, x)| (0..D).for_each(|d| share[d] += weight * c * x[d]));
            square.iter().zip(&mut *y).for_each(|(c, y)| (0..D).for_each(|d| y[d] += c * share[d]));
        }
    }

    /// Fused multiplications and additions of a factorisation of the matrix of `repeats` coordinates, and of a solve
    /// with it for one right side.
    pub(crate) fn work(&self, repeats: usize) -> [f64; 2] {
        let (size, band) = ((repeats * self.size) as f64, (repeats * (self.band + 1) - 1) as f64);
        if self.is_banded_enough() {
            return [0.5 * size * band * band, 2.0 * size * band];
        }
        [size * size * size / 6.0, size * size]
    }

    /// Mean of the diagonal.
    pub(crate) fn mean_diagonal(&self) -> f64 {
        (0..self.size).map(|j| self.columns[j * stride(self.band)]).sum::<f64>() / self.size.max(1) as f64
    }

    /// The lower half in faer's storage; zero above the diagonal.
    fn full(&self) -> Mat<f64> {
        let mut full = Mat::zeros(self.size, self.size);
        for (j, column) in self.columns.chunks_exact(stride(self.band)).enumerate() {
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

/// Takes the product of the columns with `x` off `y`.
struct SubtractProduct<'a, const D: usize> {
    normal: &'a Normal,
    x: &'a [[f64; D]],
    y: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for SubtractProduct<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { normal: Normal { size, band, columns, .. }, x, y } = self;
        let (stride, reach) = (stride(*band), band.next_multiple_of(LANES));
        // What lies beyond the band or the last row is zero.
        let (mut from, mut to) = (vec![0.0; size + reach], vec![0.0; size + reach]);
        for d in 0..D {
            from.iter_mut().zip(x).for_each(|(slot, x)| *slot = x[d]);
            to.iter_mut().zip(y.iter()).for_each(|(slot, y)| *slot = y[d]);
            for (j, column) in columns.chunks_exact(stride).take(*size).enumerate() {
                let factor = simd.splat_f64s(-from[j]);
                let mut sum = simd.splat_f64s(0.0);
                let entries = S::as_simd_f64s(&column[1..=reach]).0;
                let values = S::as_simd_f64s(&from[j + 1..][..reach]).0;
                let targets = S::as_mut_simd_f64s(&mut to[j + 1..][..reach]).0;
                for ((&entry, &value), target) in entries.iter().zip(values).zip(targets) {
                    sum = multiply_add(simd, entry, value, sum);
                    *target = multiply_add(simd, entry, factor, *target);
                }
                to[j] -= column[0] * from[j] + store::<S>(sum).iter().sum::<f64>();
            }
            y.iter_mut().zip(&to).for_each(|(y, x)| y[d] = *x);
        }
    }
}

/// Every number with D − 1 zeros after it, and zeros to the end.
fn spread<const D: usize>(numbers: &[f64], slots: &mut [f64]) {
    let (used, rest) = slots.split_at_mut(D * numbers.len());
    for (slots, &x) in used.as_chunks_mut::<D>().0.iter_mut().zip(numbers) {
        *slots = std::array::from_fn(|d| if d == 0 { x } else { 0.0 });
    }
    rest.fill(0.0);
}

/// Up to here banded loops beat dense kernels whatever the band.
const SMALL: usize = 48;

/// Up to here they do so because dense kernels want a copy of the matrix first; it stays in the second-level cache.
const CACHED: usize = 256;

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

impl Factor {
    /// Factors a matrix; `None` where it is singular or holds a NaN.
    pub(crate) fn new(normal: &Normal) -> Option<Self> {
        if let Some(factor) = Self::of_positive(normal.with_room()) {
            return Some(factor);
        }
        let mut full = normal.full();
        for j in 0..normal.size {
            (j + 1..normal.size).for_each(|i| full[(j, i)] = full[(i, j)]);
        }
        let lu = PartialPivLu::new(full.as_ref());
        let diagonal = (0..normal.size).map(|k| lu.U()[(k, k)].abs());
        let (least, most) = diagonal.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (least > 1e-15 * most && most.is_finite()).then(|| Self::Lu(Box::new(lu)))
    }

    /// Factors a positive definite matrix; `None` where it is not.
    pub(crate) fn of_positive(normal: Normal) -> Option<Self> {
        if let Some(corrected) = Corrected::new(&normal) {
            return Some(Self::Corrected(corrected));
        }
        if (normal.is_banded_enough() || normal.size <= CACHED) && normal.squares.is_empty() {
            return Cholesky::new(normal.band, normal.columns).map(Self::Cholesky);
        }
        let columns = dense_cholesky(&normal.full())?;
        Some(Self::Cholesky(Cholesky::known(normal.size.saturating_sub(1), columns)))
    }

    /// The memory of a factor nobody needs any more.
    pub(crate) fn into_memory(self) -> Vec<f64> {
        match self {
            Self::Cholesky(cholesky) => cholesky.into_memory(),
            Self::Corrected(_) | Self::Lu(_) => Vec::new(),
        }
    }

    /// Solves in place for D right sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        match self {
            Self::Cholesky(cholesky) => cholesky.solve(x),
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
    pub(crate) fn is_banded_enough(&self) -> bool {
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

/// Most columns of U: an affine map of the plane has six coefficients, one coordinate of space four.
const MOST_SQUARES: usize = 8;

/// Least eigenvalue of I − UᵀN⁻¹U, which lie in 0..=1: below it cancellation eats digits, and a dense factor is used.
const LEAST_LEFT: f64 = 1e-3;

impl Corrected {
    /// The factor of a banded matrix from which squares are taken off; `None` where a dense factor does better.
    fn new(normal: &Normal) -> Option<Self> {
        let count = normal.squares.len();
        let fits = (1..=MOST_SQUARES).contains(&count) && normal.size >= SMALL && normal.is_banded_enough();
        let banded = if fits { Cholesky::new(normal.band, normal.columns.clone()) } else { None }?;
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

/// The inverse of a symmetric matrix, unless an eigenvalue is below [`LEAST_LEFT`].
fn inverse_of_positive<const N: usize>(m: &Square<N>) -> Option<Square<N>> {
    let (values, vectors) = symmetric_eigen(m);
    let entry = |a: usize, b: usize| (0..N).map(|k| vectors[a][k] * vectors[b][k] / values[k]).sum();
    let inverse = std::array::from_fn(|a| std::array::from_fn(|b| entry(a, b)));
    values.iter().all(|&value| value > LEAST_LEFT).then_some(inverse)
}

/// faer's dense Cholesky; columns as in [`Cholesky`], the band as wide as the matrix.
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
