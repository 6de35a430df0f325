//! Cholesky factorisation of banded matrices in panels of four columns, vectorised over rows.
//!
//! In: the lower half of a matrix by columns. Out: L in the same layout, and solutions for several right-hand sides.

use super::band_storage::{PANEL, stride};
use super::simd::{LANES, store};
use super::syrk::{LowerColumns, PackedPanels};
use crate::simd::dispatch;
use crate::solve::cancel::{Cancel, WorkMeter};
use pulp::{Simd, WithSimd};

/// The factor L. Entry (j + k, j) is at j·stride + k; the diagonal is stored inverted. Padding columns are those of the identity.
#[derive(Debug)]
pub(crate) struct Cholesky {
    band: usize,
    columns: Vec<f64>,
    /// Number of rows below each panel that contain entries, in whole registers; the band need not be full.
    profile: Vec<usize>,
}

impl Cholesky {
    /// Factors a matrix given by its columns; `None` if it is not positive definite, contains a NaN, or the solve is cancelled.
    pub(crate) fn new(band: usize, columns: Vec<f64>, cancel: &Cancel) -> Option<Self> {
        let mut factor = Self::padded(band, columns);
        dispatch(Factorisation(&mut factor, cancel.meter())).then_some(factor)
    }

    /// Wraps the columns of a factor that was computed elsewhere.
    pub(crate) fn from_factor(band: usize, columns: Vec<f64>) -> Self {
        Self::padded(band, columns)
    }

    fn padded(band: usize, mut columns: Vec<f64>) -> Self {
        let stride = stride(band);
        while !columns.len().is_multiple_of(PANEL * stride) {
            columns.push(1.0);
            columns.resize(columns.len() + stride - 1, 0.0);
        }
        let profile = profile(&columns, stride);
        Self { band, columns, profile }
    }

    /// The memory of the factor, for reuse.
    pub(crate) fn into_buffer(self) -> Vec<f64> {
        self.columns
    }

    /// Solves in place for D right-hand sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        dispatch(Substitution { factor: self, x });
    }

    /// The solution for one right-hand side.
    pub(crate) fn solved(&self, right_side: &[f64]) -> Vec<[f64; 1]> {
        let mut x: Vec<[f64; 1]> = right_side.iter().map(|&value| [value]).collect();
        self.solve(&mut x);
        x
    }
}

/// Height of every panel. Because of fill-in, a column extends at least to the end of every previous column.
fn profile(columns: &[f64], stride: usize) -> Vec<usize> {
    let count = columns.len() / stride;
    let mut last = 0;
    let mut profile = Vec::with_capacity(count / PANEL);
    for (j, column) in columns.chunks_exact(stride).enumerate() {
        // Only rows of the matrix are searched, not the padding.
        let column = &column[..stride.min(count - j)];
        last = last.max(j + column.iter().rposition(|&x| x != 0.0).unwrap_or(0));
        if j % PANEL == PANEL - 1 {
            profile.push((last - j).next_multiple_of(LANES));
        }
    }
    profile
}

/// Columns of a wide band that are subtracted from the rest together, in register tiles.
const BLOCK: usize = 48;

/// Narrower bands fit into the first-level cache; each panel is subtracted at once.
const NARROW: usize = 64;

/// Right-looking factorisation.
struct Factorisation<'a>(&'a mut Cholesky, WorkMeter<'a>);

impl WithSimd for Factorisation<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self(Cholesky { band, columns, profile }, mut meter) = self;
        let stride = stride(*band);
        let count = columns.len() / stride;
        let block = if *band < NARROW { count } else { BLOCK };
        let mut panels = None;
        for first in (0..count).step_by(block) {
            let next = (first + block).min(count);
            let mut end = next;
            for start in (first..next).step_by(PANEL) {
                let height = profile[start / PANEL];
                end = end.max((start + PANEL + height).min(count));
                let (panel, below) = columns[start * stride..next * stride].split_at_mut(PANEL * stride);
                if !factor_panel(panel, stride) {
                    return false;
                }
                let touched = (height * stride).min(below.len());
                if meter.count_and_poll(PANEL * touched) {
                    return false;
                }
                for (pair, targets) in below[..touched].chunks_exact_mut(2 * stride).enumerate() {
                    update_pair(simd, panel, [PANEL + 2 * pair, height], targets);
                }
            }
            if end > next {
                let panels = panels.get_or_insert_with(|| PackedPanels::new(block, *band + block));
                let lower = LowerColumns { numbers: columns, size: end, stride };
                subtract_block(simd, panels, [first, next], lower, &mut meter);
                if meter.is_stopped() {
                    return false;
                }
            }
        }
        true
    }
}

/// Subtracts the contribution of the columns first..next from the columns after them.
#[inline(always)]
fn subtract_block<S: Simd>(
    simd: S,
    panels: &mut PackedPanels,
    [first, next]: [usize; 2],
    LowerColumns { numbers, size: end, stride }: LowerColumns,
    meter: &mut WorkMeter,
) {
    let (block, rest) = numbers.split_at_mut(next * stride);
    panels.resize([next - first, end - next]);
    for (k, column) in block[first * stride..].chunks_exact(stride).enumerate() {
        let below = &column[next - first - k..];
        let below = &below[..below.len().min(end - next)];
        panels.put(k, [below, below]);
    }
    panels.add_to(simd, -1.0, &mut LowerColumns { numbers: rest, size: end - next, stride }, meter);
}

/// Factors the four columns of a panel; returns false if a diagonal entry is not positive and finite.
#[inline(always)]
fn factor_panel(panel: &mut [f64], stride: usize) -> bool {
    for k in 0..PANEL {
        let (column, others) = panel[k * stride..].split_at_mut(stride);
        // `!(>)` also catches NaN.
        if !(column[0] > 0.0 && column[0].is_finite()) {
            return false;
        }
        let inverse = 1.0 / column[0].sqrt();
        column[0] = inverse;
        column[1..].iter_mut().for_each(|x| *x *= inverse);
        for (m, target) in others.chunks_exact_mut(stride).enumerate() {
            let factor = -column[m + 1];
            target.iter_mut().zip(&column[m + 1..]).for_each(|(slot, &x)| *slot = factor.mul_add(x, *slot));
        }
    }
    true
}

/// Subtracts the contribution of a panel of the given height from two columns that begin `ahead` columns after its first.
#[inline(always)]
fn update_pair<S: Simd>(simd: S, panel: &[f64], [ahead, height]: [usize; 2], targets: &mut [f64]) {
    let stride = targets.len() / 2;
    let column = |k: usize| &panel[k * stride + ahead - k..(k + 1) * stride];
    let factors: [[f64; 2]; PANEL] = std::array::from_fn(|k| [-column(k)[0], -column(k)[1]]);
    let (one, two) = targets.split_at_mut(stride);
    factors.iter().for_each(|factor| one[0] -= factor[0] * factor[0]);
    let wanted = (height + PANEL - 1 - ahead).next_multiple_of(LANES);
    let length = wanted.min((stride - ahead - 1) / LANES * LANES);
    let sources: [&[S::f64s]; PANEL] = std::array::from_fn(|k| registers::<S>(&column(k)[1..=length]));
    let one = S::as_mut_simd_f64s(&mut one[1..=length]).0;
    let two = S::as_mut_simd_f64s(&mut two[..length]).0;
    // A loop, because closures of `map` would not be inlined here.
    let mut splats = [[simd.splat_f64s(0.0); 2]; PANEL];
    for k in 0..PANEL {
        splats[k] = [simd.splat_f64s(factors[k][0]), simd.splat_f64s(factors[k][1])];
    }
    for i in 0..length / LANES {
        let (mut first, mut second) = (one[i], two[i]);
        for k in 0..PANEL {
            let source = sources[k][i];
            first = simd.mul_add_f64s(splats[k][0], source, first);
            second = simd.mul_add_f64s(splats[k][1], source, second);
        }
        (one[i], two[i]) = (first, second);
    }
}

#[inline(always)]
fn registers<S: Simd>(numbers: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(numbers).0
}

/// Solves L y = b, then Lᵀ x = y.
struct Substitution<'a, const D: usize> {
    factor: &'a Cholesky,
    x: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Substitution<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, x } = self;
        let stride = stride(factor.band);
        let length = factor.columns.len() / stride + factor.band.next_multiple_of(LANES);
        // One plane per coordinate.
        let mut planes: [Vec<f64>; D] = std::array::from_fn(|d| {
            let mut plane = Vec::with_capacity(length);
            plane.extend(x.iter().map(|values| values[d]));
            plane.resize(length, 0.0);
            plane
        });
        let panels = || factor.columns.chunks_exact(PANEL * stride).zip(&factor.profile).enumerate();
        for (number, (panel, height)) in panels() {
            let windows = planes.each_mut().map(|plane| &mut plane[number * PANEL..][..PANEL + height]);
            forward(simd, panel, windows);
        }
        for (number, (panel, height)) in panels().rev() {
            let windows = planes.each_mut().map(|plane| &mut plane[number * PANEL..][..PANEL + height]);
            backward(simd, panel, windows);
        }
        for (k, values) in x.iter_mut().enumerate() {
            *values = std::array::from_fn(|d| planes[d][k]);
        }
    }
}

/// Solves for the first four numbers of each window and subtracts their contribution from the others.
#[inline(always)]
fn forward<S: Simd, const D: usize>(simd: S, panel: &[f64], windows: [&mut [f64]; D]) {
    let stride = panel.len() / PANEL;
    let height = windows[0].len() - PANEL;
    let sources: [&[S::f64s]; PANEL] =
        std::array::from_fn(|k| registers::<S>(&panel[k * stride + PANEL - k..][..height]));
    let mut factors = [[simd.splat_f64s(0.0); PANEL]; D];
    for d in 0..D {
        let x = &mut *windows[d];
        for k in 0..PANEL {
            x[k] *= panel[k * stride];
            (k + 1..PANEL).for_each(|m| x[m] = (-panel[k * stride + m - k]).mul_add(x[k], x[m]));
            factors[d][k] = simd.splat_f64s(-x[k]);
        }
    }
    let mut targets = windows.map(|window| S::as_mut_simd_f64s(&mut window[PANEL..]).0);
    for i in 0..height / LANES {
        let mut values: [S::f64s; D] = std::array::from_fn(|d| targets[d][i]);
        for k in 0..PANEL {
            let source = sources[k][i];
            (0..D).for_each(|d| values[d] = simd.mul_add_f64s(factors[d][k], source, values[d]));
        }
        (0..D).for_each(|d| targets[d][i] = values[d]);
    }
}

/// Solves for the first four numbers of each window from the others.
#[inline(always)]
fn backward<S: Simd, const D: usize>(simd: S, panel: &[f64], windows: [&mut [f64]; D]) {
    let stride = panel.len() / PANEL;
    let height = windows[0].len() - PANEL;
    let sources: [&[S::f64s]; PANEL] =
        std::array::from_fn(|k| registers::<S>(&panel[k * stride + PANEL - k..][..height]));
    let mut sums = [[simd.splat_f64s(0.0); PANEL]; D];
    let known = windows.each_ref().map(|window| registers::<S>(&window[PANEL..]));
    for i in 0..height / LANES {
        for k in 0..PANEL {
            (0..D).for_each(|d| sums[d][k] = simd.mul_add_f64s(sources[k][i], known[d][i], sums[d][k]));
        }
    }
    for (x, sums) in windows.into_iter().zip(sums) {
        for k in (0..PANEL).rev() {
            let inside: f64 = (k + 1..PANEL).map(|m| panel[k * stride + m - k] * x[m]).sum();
            x[k] = (x[k] - total::<S>(sums[k]) - inside) * panel[k * stride];
        }
    }
}

/// Sum of the four numbers of a register.
#[inline(always)]
fn total<S: Simd>(register: S::f64s) -> f64 {
    let [a, b, c, d] = store::<S>(register);
    (a + b) + (c + d)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entry (i, j) of the lower half of a diagonally dominant matrix.
    fn entry(i: usize, j: usize) -> f64 {
        if i == j { 9.0 + (i as f64).sin() } else { ((3 * i + j) as f64).cos() / (1 + i - j) as f64 }
    }

    #[test]
    fn solutions_solve_whatever_size_and_band() {
        for (size, band) in [(1, 0), (2, 1), (7, 2), (8, 7), (9, 4), (30, 5), (33, 32), (50, 13)] {
            solve_one(size, band, |i, j| i - j <= band);
            // A sparse band: most columns are short.
            solve_one(size, band, |i, j| i - j <= band && (i - j <= band / 4 || j % 11 == 3));
        }
    }

    /// Factors and solves for a known solution. `holds` says which entries of the lower half are not zero.
    fn solve_one(size: usize, band: usize, holds: impl Fn(usize, usize) -> bool) {
        let entry = |i: usize, j: usize| if holds(i, j) { entry(i, j) } else { 0.0 };
        let mut columns = vec![0.0; size * stride(band)];
        for (j, column) in columns.chunks_exact_mut(stride(band)).enumerate() {
            (j..size.min(j + band + 1)).for_each(|i| column[i - j] = entry(i, j));
        }
        let factor = Cholesky::new(band, columns, &Cancel::never()).expect("a positive definite matrix");
        let wanted: Vec<[f64; 2]> = (0..size).map(|k| [(k as f64).cos(), k as f64]).collect();
        let mut x = vec![[0.0; 2]; size];
        for (i, x) in x.iter_mut().enumerate() {
            for j in (0..size).filter(|&j| i.abs_diff(j) <= band) {
                (0..2).for_each(|d| x[d] += entry(i.max(j), i.min(j)) * wanted[j][d]);
            }
        }
        factor.solve(&mut x);
        for (x, wanted) in x.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((x - wanted).abs() < 1e-12 * (1.0 + wanted.abs()), "{size} {band}: {x} {wanted}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        let columns = |diagonal: f64| {
            let mut columns = vec![0.0; 2 * stride(1)];
            columns[..2].copy_from_slice(&[1.0, 2.0]);
            columns[stride(1)] = diagonal;
            columns
        };
        let never = &Cancel::never();
        assert!(Cholesky::new(1, columns(5.0), never).is_some());
        assert!(Cholesky::new(1, columns(4.0), never).is_none());
        assert!(Cholesky::new(1, columns(f64::NAN), never).is_none());
    }
}
