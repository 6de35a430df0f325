//! The normal matrix: symmetric over handles, banded, assembled term by term. Crate faer.
//!
//! In: least-squares rows, Gram matrices, symmetric products, downdates. Out: the matrix, for products and factorisations.

use super::band_storage::{padded_length, stride};
use super::gram_matrix::GramMatrix;
use super::simd::{LANES, multiply_add, store};
use super::syrk;
use super::syrk::{LowerColumns, SyrkRows};
use crate::simd::dispatch;
use crate::solve::cancel::Cancel;
use faer::Mat;
use pulp::{Simd, WithSimd};

/// The lower half of a symmetric #handles × #handles matrix. Column j holds rows j..=j+band, then zeros.
#[derive(Clone, Debug)]
pub(crate) struct NormalMatrix {
    pub(crate) size: usize,
    pub(super) band: usize,
    pub(super) columns: Vec<f64>,
    /// Low-rank part to subtract: Σ weight · column columnᵀ.
    pub(super) downdates: Vec<(f64, Vec<f64>)>,
}

impl NormalMatrix {
    /// A zero matrix of this bandwidth.
    pub(crate) fn zero(size: usize, band: usize) -> Self {
        let band = band.min(size.saturating_sub(1));
        Self { size, band, columns: vec![0.0; size * stride(band)], downdates: Vec::new() }
    }

    /// A copy with at least this bandwidth.
    pub(crate) fn widened(&self, band: usize) -> Self {
        let mut wide = Self { downdates: self.downdates.clone(), ..Self::zero(self.size, band.max(self.band)) };
        let (from, to) = (stride(self.band), stride(wide.band));
        for (column, slots) in self.columns.chunks_exact(from).zip(wide.columns.chunks_exact_mut(to)) {
            slots[..=self.band].copy_from_slice(&column[..=self.band]);
        }
        wide
    }

    /// Whether the band is full and every row has `shared` = #handles handles, as [`Self::add_syrk`] requires. The rows of a
    /// model inside one cell have a few handles only.
    pub(crate) fn is_full(&self, shared: usize) -> bool {
        self.band + 1 >= self.size && shared == self.size
    }

    /// Adds scale · aᵀb, which must be symmetric, to a dense matrix.
    pub(crate) fn add_syrk(&mut self, scale: f64, rows: &mut impl SyrkRows, cancel: &Cancel) {
        let lower = LowerColumns { numbers: &mut self.columns, size: self.size, stride: stride(self.band) };
        syrk::add_syrk(lower, scale, rows, cancel);
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

    /// Adds a Gram matrix times a scale. `rows` are the indices of its columns, ascending.
    #[inline(always)]
    pub(crate) fn add_gram(&mut self, scale: f64, rows: &[usize], gram: &GramMatrix) {
        let stride = stride(self.band);
        // Rows form runs of consecutive indices, over which loops vectorise.
        let runs: Vec<&[usize]> = rows.chunk_by(|a, b| a + 1 == *b).collect();
        let mut b = 0;
        for (number, &run) in runs.iter().enumerate() {
            for (k, &column) in run.iter().enumerate() {
                let slots = &mut self.columns[column * stride..][..stride];
                let mut sums = gram.column(b);
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

    /// Subtracts weight · column columnᵀ for each column (#handles). The matrix has to stay positive definite.
    pub(crate) fn downdate(&mut self, weight: f64, columns: &[Vec<f64>]) {
        self.downdates.extend(columns.iter().map(|column| (weight, column.clone())));
    }

    /// The Kronecker product with the identity of D coordinates; row D·handle + coordinate. `memory` is reused, because the first
    /// access to fresh pages costs as much as the factorisation.
    pub(crate) fn kron_identity<const D: usize>(&self, mut memory: Vec<f64>) -> Self {
        let (size, band) = (D * self.size, D * (self.band + 1) - 1);
        let wide = stride(band);
        memory.reserve(padded_length(size, band).saturating_sub(memory.len()));
        memory.resize(size * wide, 0.0);
        for (j, column) in self.columns.chunks_exact(stride(self.band)).enumerate() {
            for slots in memory[D * j * wide..][..D * wide].chunks_exact_mut(wide) {
                spread::<D>(&column[..=self.band], slots);
            }
        }
        let mut kron_identity = Self { size, band, columns: memory, downdates: Vec::new() };
        for (weight, square) in &self.downdates {
            kron_identity.downdates.extend((0..D).map(|d| {
                let spread = square.iter().flat_map(|&x| (0..D).map(move |other| if other == d { x } else { 0.0 }));
                (*weight, spread.collect())
            }));
        }
        kron_identity
    }

    /// A copy with capacity for the padding of its factor's last panel.
    pub(super) fn padded(&self) -> Self {
        let mut columns = Vec::with_capacity(padded_length(self.size, self.band));
        columns.extend_from_slice(&self.columns);
        Self { size: self.size, band: self.band, columns, downdates: self.downdates.clone() }
    }

    /// Subtracts the product with `x` from `y`.
    pub(crate) fn subtract_matvec<const D: usize>(&self, x: &[[f64; D]], y: &mut [[f64; D]]) {
        dispatch(SubtractMatvec { normal: self, x, y });
        for (weight, square) in &self.downdates {
            let mut share = [0.0; D];
            square.iter().zip(x).for_each(|(c, x)| (0..D).for_each(|d| share[d] += weight * c * x[d]));
            square.iter().zip(&mut *y).for_each(|(c, y)| (0..D).for_each(|d| y[d] += c * share[d]));
        }
    }

    /// Fused multiply-adds of a factorisation of the matrix over `repeats` coordinates, and of a solve with it for one right-hand
    /// side.
    pub(crate) fn flops(&self, repeats: usize) -> [f64; 2] {
        let (size, band) = ((repeats * self.size) as f64, (repeats * (self.band + 1) - 1) as f64);
        if self.is_banded_enough() {
            return [0.5 * size * band * band, 2.0 * size * band];
        }
        [size * size * size / 6.0, size * size]
    }

    /// Mean of the diagonal, without downdates.
    pub(crate) fn mean_diagonal(&self) -> f64 {
        self.diagonal().iter().sum::<f64>() / self.size.max(1) as f64
    }

    /// The diagonal, without downdates.
    pub(crate) fn diagonal(&self) -> Vec<f64> {
        self.columns.iter().step_by(stride(self.band)).take(self.size).copied().collect()
    }

    /// The columns of the lower half from the diagonal on, with downdates applied, in the storage of a full band.
    pub(super) fn dense_columns(&self) -> Vec<f64> {
        let (full, wide) = (self.full(), stride(self.size - 1));
        let mut columns = vec![0.0; self.size * wide];
        for (j, column) in columns.chunks_exact_mut(wide).enumerate() {
            column[..self.size - j].copy_from_slice(&full.col_as_slice(j)[j..]);
        }
        columns
    }

    /// The lower half with downdates applied, in faer's storage; zero above the diagonal.
    pub(crate) fn full(&self) -> Mat<f64> {
        let mut full = Mat::zeros(self.size, self.size);
        for (j, column) in self.columns.chunks_exact(stride(self.band)).enumerate() {
            let below = &mut full.col_as_slice_mut(j)[j..];
            below.iter_mut().zip(column).for_each(|(slot, x)| *slot = *x);
        }
        for (weight, square) in &self.downdates {
            for j in 0..self.size {
                let below = &mut full.col_as_slice_mut(j)[j..];
                below.iter_mut().zip(&square[j..]).for_each(|(slot, x)| *slot -= weight * square[j] * x);
            }
        }
        full
    }
}

/// Subtracts the product of the banded part with `x` from `y`.
struct SubtractMatvec<'a, const D: usize> {
    normal: &'a NormalMatrix,
    x: &'a [[f64; D]],
    y: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for SubtractMatvec<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { normal: NormalMatrix { size, band, columns, .. }, x, y } = self;
        let (stride, padded_band) = (stride(*band), band.next_multiple_of(LANES));
        // Entries beyond the band or the last row are zero.
        let (mut from, mut to) = (vec![0.0; size + padded_band], vec![0.0; size + padded_band]);
        for d in 0..D {
            from.iter_mut().zip(x).for_each(|(slot, x)| *slot = x[d]);
            to.iter_mut().zip(y.iter()).for_each(|(slot, y)| *slot = y[d]);
            for (j, column) in columns.chunks_exact(stride).take(*size).enumerate() {
                let factor = simd.splat_f64s(-from[j]);
                let mut sum = simd.splat_f64s(0.0);
                let entries = S::as_simd_f64s(&column[1..=padded_band]).0;
                let values = S::as_simd_f64s(&from[j + 1..][..padded_band]).0;
                let targets = S::as_mut_simd_f64s(&mut to[j + 1..][..padded_band]).0;
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

/// Writes every number followed by D − 1 zeros, and fills the rest with zeros.
fn spread<const D: usize>(numbers: &[f64], slots: &mut [f64]) {
    let (used, rest) = slots.split_at_mut(D * numbers.len());
    for (slots, &x) in used.as_chunks_mut::<D>().0.iter_mut().zip(numbers) {
        *slots = std::array::from_fn(|d| if d == 0 { x } else { 0.0 });
    }
    rest.fill(0.0);
}

/// Below this size the banded factorisation is faster for any bandwidth.
pub(super) const MIN_DENSE_SIZE: usize = 48;

/// Largest number minus smallest; `None` if there are none.
pub(crate) fn index_extent(numbers: impl Iterator<Item = usize> + Clone) -> Option<usize> {
    Some(numbers.clone().max()? - numbers.min()?)
}

impl NormalMatrix {
    /// Whether the banded factorisation is faster than faer's dense kernels: the bandwidth is well below the size.
    pub(crate) fn is_banded_enough(&self) -> bool {
        self.size < MIN_DENSE_SIZE || self.band * 2 < self.size
    }
}
