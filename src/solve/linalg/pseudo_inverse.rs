//! Pseudo-inverses of symmetric positive semidefinite matrices. Crate faer.
//!
//! In: a matrix of any size. Out: its pseudo-inverse, and the projection onto the directions that it omits. Directions fade out
//! with decreasing eigenvalue, so that the pseudo-inverse is a continuous function of the matrix.

use super::band_storage::stride;
use super::cholesky::Cholesky;
use crate::solve::cancel::{Cancel, Cancelled};
use faer::{Mat, Side};

/// Up to this size eigenvectors are computed at once: that is as fast as an inverse, and works for every matrix.
const MAX_EIGEN: usize = 128;

/// Number of right-hand sides that are solved together.
const BATCH: usize = 8;

/// A pseudo-inverse.
pub(crate) struct PseudoInverse {
    /// The pseudo-inverse, row by row.
    pub(crate) inverse: Vec<f64>,
    /// Σ (1 − share) v vᵀ over the eigenvectors v, row by row, with the share of [`fade_weight`]; empty if no direction is
    /// omitted.
    pub(crate) dropped: Vec<f64>,
}

impl PseudoInverse {
    /// Inverts a matrix (size x size). Directions whose eigenvalue is below `cutoff` times the largest fade out.
    pub(crate) fn new(entries: &[f64], size: usize, cutoff: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let symmetric = |i: usize, j: usize| 0.5 * (entries[i * size + j] + entries[j * size + i]);
        if size > MAX_EIGEN
            && let Some(inverse) = inverse_of_well_conditioned(&symmetric, size, cutoff, cancel)?
        {
            return Ok(Self { inverse, dropped: Vec::new() });
        }
        Self::by_eigenvectors(&Mat::from_fn(size, size, symmetric), cutoff, cancel)
    }

    fn by_eigenvectors(matrix: &Mat<f64>, cutoff: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let size = matrix.nrows();
        let mut found = Self { inverse: vec![0.0; size * size], dropped: vec![0.0; size * size] };
        cancel.check()?;
        let Ok(eigen) = matrix.self_adjoint_eigen(Side::Lower) else { return Ok(found) };
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let columns: Vec<Vec<f64>> = (0..size).map(|k| (0..size).map(|i| vectors[(i, k)]).collect()).collect();
        let largest = (0..size).map(|k| values[k]).fold(0.0, f64::max);
        let mut meter = cancel.meter();
        for (i, (inverse, dropped)) in
            found.inverse.chunks_exact_mut(size).zip(found.dropped.chunks_exact_mut(size)).enumerate()
        {
            for (k, column) in columns.iter().enumerate() {
                let share = fade_weight(values[k], cutoff * largest);
                if share > 0.0 {
                    let factor = share / values[k] * column[i];
                    inverse.iter_mut().zip(column).for_each(|(slot, x)| *slot += factor * x);
                }
                if share < 1.0 {
                    let factor = (1.0 - share) * column[i];
                    dropped.iter_mut().zip(column).for_each(|(slot, x)| *slot += factor * x);
                }
            }
            if meter.count_and_poll(size * size) {
                return Err(Cancelled);
            }
        }
        Ok(found)
    }
}

/// Fraction of the limit at which a direction has faded out.
const FADE: f64 = 0.1;

/// The fraction of a direction that is kept: 1 from the limit on, 0 below a tenth of it, smooth in the logarithm between.
pub(crate) fn fade_weight(value: f64, limit: f64) -> f64 {
    if value >= limit {
        return 1.0;
    }
    if value <= FADE * limit {
        return 0.0;
    }
    let t = 1.0 - (value / limit).ln() / FADE.ln();
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// The inverse, if the norms of matrix and inverse prove that every eigenvalue is above `cutoff` times the largest.
fn inverse_of_well_conditioned(
    entry: &impl Fn(usize, usize) -> f64,
    size: usize,
    cutoff: f64,
    cancel: &Cancel,
) -> Result<Option<Vec<f64>>, Cancelled> {
    let wide = stride(size - 1);
    let mut columns = vec![0.0; size * wide];
    for (j, column) in columns.chunks_exact_mut(wide).enumerate() {
        column.iter_mut().take(size - j).enumerate().for_each(|(k, slot)| *slot = entry(j + k, j));
    }
    let norm = (0..size * size).map(|k| entry(k / size, k % size).powi(2)).sum::<f64>().sqrt();
    let factor = Cholesky::new(size - 1, columns, cancel);
    cancel.check()?;
    let Some(factor) = factor else { return Ok(None) };
    let mut inverse = vec![0.0; size * size];
    let mut meter = cancel.meter();
    for (batch, rows) in inverse.chunks_mut(BATCH * size).enumerate() {
        let mut x = vec![[0.0; BATCH]; size];
        let count = rows.len() / size;
        (0..count).for_each(|k| x[batch * BATCH + k][k] = 1.0);
        factor.solve(&mut x);
        for (k, row) in rows.chunks_exact_mut(size).enumerate() {
            row.iter_mut().zip(&x).for_each(|(slot, x)| *slot = x[k]);
        }
        if meter.count_and_poll(BATCH * size * size) {
            return Err(Cancelled);
        }
    }
    // The smallest eigenvalue is at least 1/‖inverse‖, the largest at most ‖matrix‖ (Frobenius norms).
    let inverse_norm = inverse.iter().map(|x| x * x).sum::<f64>().sqrt();
    Ok((inverse_norm * norm * cutoff < 1.0).then_some(inverse))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dense matrix with one eigenvalue `least` and the others between 1/2 and 1, made by a Householder reflection.
    fn matrix(size: usize, least: f64) -> Vec<f64> {
        let axis: Vec<f64> = (0..size).map(|k| 1.0 + (k as f64).sin()).collect();
        let square: f64 = axis.iter().map(|x| x * x).sum();
        let value = |k: usize| if k == 3 { least } else { 1.0 - 0.5 * k as f64 / size as f64 };
        let reflected = |i: usize, k: usize| f64::from(u8::from(i == k)) - 2.0 * axis[i] * axis[k] / square;
        let entry = |n: usize| {
            let (i, j) = (n / size, n % size);
            (0..size).map(|k| reflected(i, k) * value(k) * reflected(j, k)).sum()
        };
        (0..size * size).map(entry).collect()
    }

    #[test]
    fn large_and_small_matrices_are_inverted_alike() {
        for (size, least) in [(20, 0.3), (20, 1e-7), (140, 0.3), (140, 1e-7)] {
            let entries = matrix(size, least);
            let found = PseudoInverse::new(&entries, size, 1e-4, &Cancel::never()).expect("not cancelled");
            let is_dropped = least < 1e-4;
            let trace: f64 = (0..size).filter_map(|k| found.dropped.get(k * size + k)).sum();
            assert!((trace - f64::from(u8::from(is_dropped))).abs() < 1e-9, "{size} {least}: {trace}");
            for i in 0..size {
                for j in 0..size {
                    let product: f64 = (0..size).map(|k| found.inverse[i * size + k] * entries[k * size + j]).sum();
                    let dropped = found.dropped.get(i * size + j).copied().unwrap_or(0.0);
                    let wanted = f64::from(u8::from(i == j)) - dropped;
                    assert!((product - wanted).abs() < 1e-9, "{size} {least} {i} {j}: {product} {wanted}");
                }
            }
        }
    }
}
