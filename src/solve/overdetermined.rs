//! Hard constraints with more rows than handles: the rows determine the handles and cannot all be met.
//!
//! In: the normal matrix A = L Lᵀ and n rows C. Out: the map from Cᵀ(C P − d) to the correction of the handles, a matrix of
//! #handles², and for each row in conflict its rival. With B = C L⁻ᵀ and BᵀB = V Σ Vᵀ, A⁻¹Cᵀ(C A⁻¹ Cᵀ)⁺ = L⁻ᵀ V Σ⁺ Vᵀ L⁻¹ Cᵀ. The
//! cost grows with n, not with n³.

use super::cancel::{Cancel, Cancelled};
use super::linalg::normal_matrix::NormalMatrix;
use super::linalg::pseudo_inverse::fade_weight;
use super::linalg::syrk::SyrkRows;
use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use pulp::Simd;
use std::collections::BTreeMap;

/// Correction of the handles, and the rivals of the rows.
pub(crate) struct Overdetermined {
    /// Symmetric matrix of #handles², row-major.
    pub(crate) correction: Vec<f64>,
    /// For each row in conflict the row on which it depends most, or its own index.
    pub(crate) rivals: Vec<Option<usize>>,
}

/// Limits below which eigenvectors and rows are left out.
#[derive(Clone, Copy)]
pub(crate) struct Limits {
    /// Eigenvectors with eigenvalues below this fraction of the largest fade out.
    pub(crate) cutoff: f64,
    /// Part of a row that must lie in the directions left out for the row to count as in conflict.
    pub(crate) conflict: f64,
}

impl Overdetermined {
    /// Computes the correction for the rows C, given by their entries. `owner` returns the index of the pin or handle that a row
    /// belongs to. Returns `None` if A is not positive definite.
    pub(crate) fn new(
        normal: &NormalMatrix,
        (rows, owner): (&[&[(usize, f64)]], &impl Fn(usize) -> usize),
        limits: Limits,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Cancelled> {
        let Ok(llt) = Llt::new(normal.full().as_ref(), Side::Lower) else { return Ok(None) };
        let lower = Lower { columns: (0..normal.size).map(|j| column(&llt, j)).collect() };
        let mut meter = cancel.meter();
        let mut b = Vec::with_capacity(rows.len());
        for row in rows {
            b.push(lower.forward(row));
            if meter.count_and_poll(normal.size * normal.size / 2) {
                return Err(Cancelled);
            }
        }
        let mut gram = NormalMatrix::zero(normal.size, normal.size);
        gram.add_syrk(1.0, &mut Squares(&b), cancel);
        cancel.check()?;
        let Ok(eigen) = gram.full().self_adjoint_eigen(Side::Lower) else { return Ok(None) };
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let largest = (0..normal.size).map(|k| values[k]).fold(0.0, f64::max);
        let kept: Vec<(f64, Vec<f64>)> = (0..normal.size)
            .map(|k| (k, fade_weight(values[k], limits.cutoff * largest)))
            .filter(|&(_, share)| share > 0.0)
            .map(|(k, share)| (values[k] / share, (0..normal.size).map(|i| vectors[(i, k)]).collect()))
            .collect();
        let mut correction = vec![0.0; normal.size * normal.size];
        for (value, vector) in &kept {
            let direction = lower.backward(vector);
            for (row, x) in correction.chunks_exact_mut(normal.size).zip(&direction) {
                row.iter_mut().zip(&direction).for_each(|(slot, y)| *slot += x / value * y);
            }
        }
        let directions = Mat::from_fn(kept.len(), normal.size, |k, i| kept[k].1[i] / kept[k].0.sqrt());
        let shares: Vec<Vec<f64>> = b
            .iter()
            .map(|row| {
                let share = |k: usize| row.iter().enumerate().map(|(i, x)| directions[(k, i)] * x).sum();
                (0..kept.len()).map(share).collect()
            })
            .collect();
        let rivals = rivals(&shares, (rows, owner), limits.conflict, cancel)?;
        Ok(Some(Self { correction, rivals }))
    }
}

/// Returns for each row in conflict the row of another owner with the largest common component, among the rows with the same
/// first handle; the row itself if there is none.
fn rivals(
    shares: &[Vec<f64>],
    (rows, owner): (&[&[(usize, f64)]], &impl Fn(usize) -> usize),
    conflict: f64,
    cancel: &Cancel,
) -> Result<Vec<Option<usize>>, Cancelled> {
    let first_handle = |row: usize| rows[row].first().map_or(0, |entry| entry.0);
    let mut neighbours: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    (0..rows.len()).for_each(|row| neighbours.entry(first_handle(row)).or_default().push(row));
    let mut meter = cancel.meter();
    let mut found = Vec::with_capacity(rows.len());
    for (row, own) in shares.iter().enumerate() {
        if 1.0 - dot(own, own) <= conflict {
            found.push(None);
            continue;
        }
        let mut best: Option<(f64, usize)> = None;
        let others = neighbours.get(&first_handle(row)).into_iter().flatten();
        for &other in others.filter(|&&other| owner(other) != owner(row)) {
            let shared = dot(own, &shares[other]).abs();
            if shared > best.map_or(conflict, |best| best.0) {
                best = Some((shared, other));
            }
            if meter.count_and_poll(own.len()) {
                return Err(Cancelled);
            }
        }
        found.push(Some(best.map_or(row, |best| best.1)));
    }
    Ok(found)
}

/// Rows of B, as both factors of the product.
struct Squares<'a>(&'a [Vec<f64>]);

impl SyrkRows for Squares<'_> {
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, _: S, row: usize, [a, b]: [&mut [f64]; 2]) {
        let numbers = &self.0[row];
        a[..numbers.len()].copy_from_slice(numbers);
        b[..numbers.len()].copy_from_slice(numbers);
    }
}

/// The factor L, column by column from the diagonal on.
struct Lower {
    columns: Vec<Vec<f64>>,
}

fn column(llt: &Llt<f64>, j: usize) -> Vec<f64> {
    let lower = llt.L();
    (j..lower.nrows()).map(|i| lower[(i, j)]).collect()
}

impl Lower {
    /// Returns L⁻¹ times a sparse vector.
    fn forward(&self, entries: &[(usize, f64)]) -> Vec<f64> {
        let mut x = vec![0.0; self.columns.len()];
        entries.iter().for_each(|&(handle, coefficient)| x[handle] += coefficient);
        let first = entries.iter().map(|entry| entry.0).min().unwrap_or(0);
        for j in first..x.len() {
            let (head, rest) = x[j..].split_at_mut(1);
            let column = &self.columns[j];
            head[0] /= column[0];
            rest.iter_mut().zip(&column[1..]).for_each(|(x, l)| *x -= l * head[0]);
        }
        x
    }

    /// Returns L⁻ᵀ times a vector.
    fn backward(&self, vector: &[f64]) -> Vec<f64> {
        let mut x = vector.to_vec();
        for j in (0..x.len()).rev() {
            let (head, rest) = x[j..].split_at_mut(1);
            let column = &self.columns[j];
            head[0] = (head[0] - dot(rest, &column[1..])) / column[0];
        }
        x
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
