//! Cholesky factors of banded matrices, four columns at a time so that loops run over whole registers.
//!
//! In: the lower half of a matrix by columns. Out: L in the same layout, and solutions for several right sides.

use super::packs::{LANES, dispatch, store};
use super::product::Panels;
use pulp::{Simd, WithSimd};

/// Columns that are worked on together: a panel.
const PANEL: usize = 4;

/// Numbers that a column takes. What lies beyond the band is zero: so the four columns of a panel can be read over the
/// same rows, in whole registers.
pub(crate) fn stride(band: usize) -> usize {
    (band + 2 * PANEL - 1).next_multiple_of(LANES)
}

/// Numbers that a factor takes: whole panels.
pub(crate) fn padded_length(size: usize, band: usize) -> usize {
    size.next_multiple_of(PANEL) * stride(band)
}

/// L; entry (j + k, j) at j·stride + k, the diagonal inverted. Columns beyond the matrix are the identity's.
#[derive(Debug)]
pub(crate) struct Cholesky {
    band: usize,
    columns: Vec<f64>,
    /// Rows below each panel that it touches, in whole registers: where few handles meet, the band is not full.
    reaches: Vec<usize>,
}

impl Cholesky {
    /// Factors a matrix given by its columns; `None` where it is not positive definite or holds a NaN.
    pub(crate) fn new(band: usize, columns: Vec<f64>) -> Option<Self> {
        let mut factor = Self::padded(band, columns);
        dispatch(Factorisation(&mut factor)).then_some(factor)
    }

    /// L by its columns, which others computed.
    pub(crate) fn known(band: usize, columns: Vec<f64>) -> Self {
        Self::padded(band, columns)
    }

    fn padded(band: usize, mut columns: Vec<f64>) -> Self {
        let stride = stride(band);
        while !columns.len().is_multiple_of(PANEL * stride) {
            columns.push(1.0);
            columns.resize(columns.len() + stride - 1, 0.0);
        }
        let reaches = reaches(&columns, stride);
        Self { band, columns, reaches }
    }

    /// The memory of a factor nobody needs any more.
    pub(crate) fn into_memory(self) -> Vec<f64> {
        self.columns
    }

    /// Solves in place for D right sides.
    pub(crate) fn solve<const D: usize>(&self, x: &mut [[f64; D]]) {
        dispatch(Substitution { factor: self, x });
    }

    /// The solution for one right side.
    pub(crate) fn solved(&self, right_side: &[f64]) -> Vec<[f64; 1]> {
        let mut x: Vec<[f64; 1]> = right_side.iter().map(|&value| [value]).collect();
        self.solve(&mut x);
        x
    }
}

/// How far panels reach: columns fill to where any column before them ends.
fn reaches(columns: &[f64], stride: usize) -> Vec<usize> {
    let count = columns.len() / stride;
    let mut last = 0;
    let mut reaches = Vec::with_capacity(count / PANEL);
    for (j, column) in columns.chunks_exact(stride).enumerate() {
        // Beyond the matrix there is nothing to look for.
        let column = &column[..stride.min(count - j)];
        last = last.max(j + column.iter().rposition(|&x| x != 0.0).unwrap_or(0));
        if j % PANEL == PANEL - 1 {
            reaches.push((last - j).next_multiple_of(LANES));
        }
    }
    reaches
}

/// Columns whose part is taken off the rest of a wide band at once, in tiles that stay in registers.
const BLOCK: usize = 48;

/// Narrower bands stay in the first-level cache: there each panel is taken off at once.
const NARROW: usize = 64;

/// Right-looking factorisation.
struct Factorisation<'a>(&'a mut Cholesky);

impl WithSimd for Factorisation<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Cholesky { band, columns, reaches } = self.0;
        let stride = stride(*band);
        let count = columns.len() / stride;
        let block = if *band < NARROW { count } else { BLOCK };
        let mut panels = None;
        for first in (0..count).step_by(block) {
            let next = (first + block).min(count);
            let mut end = next;
            for start in (first..next).step_by(PANEL) {
                let reach = reaches[start / PANEL];
                end = end.max((start + PANEL + reach).min(count));
                let (panel, below) = columns[start * stride..next * stride].split_at_mut(PANEL * stride);
                if !factor_panel(panel, stride) {
                    return false;
                }
                let touched = (reach * stride).min(below.len());
                for (pair, targets) in below[..touched].chunks_exact_mut(2 * stride).enumerate() {
                    update_pair(simd, panel, [PANEL + 2 * pair, reach], targets);
                }
            }
            if end > next {
                let panels = panels.get_or_insert_with(|| Panels::new(block, *band + block));
                subtract_block(simd, panels, [first, next, end], columns, stride);
            }
        }
        true
    }
}

/// Takes the part of the columns first..next off the columns next..end.
#[inline(always)]
fn subtract_block<S: Simd>(
    simd: S,
    panels: &mut Panels,
    [first, next, end]: [usize; 3],
    columns: &mut [f64],
    stride: usize,
) {
    let (block, rest) = columns.split_at_mut(next * stride);
    panels.resize([next - first, end - next]);
    for (k, column) in block[first * stride..].chunks_exact(stride).enumerate() {
        let below = &column[next - first - k..];
        let below = &below[..below.len().min(end - next)];
        panels.put(k, [below, below]);
    }
    panels.add_product(simd, -1.0, rest, stride);
}

/// Factors four columns among themselves.
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

/// Takes the part of a panel that reaches so far off two columns, `ahead` columns after its first.
#[inline(always)]
fn update_pair<S: Simd>(simd: S, panel: &[f64], [ahead, reach]: [usize; 2], targets: &mut [f64]) {
    let stride = targets.len() / 2;
    let column = |k: usize| &panel[k * stride + ahead - k..(k + 1) * stride];
    let factors: [[f64; 2]; PANEL] = std::array::from_fn(|k| [-column(k)[0], -column(k)[1]]);
    let (one, two) = targets.split_at_mut(stride);
    factors.iter().for_each(|factor| one[0] -= factor[0] * factor[0]);
    let wanted = (reach + PANEL - 1 - ahead).next_multiple_of(LANES);
    let length = wanted.min((stride - ahead - 1) / LANES * LANES);
    let sources: [&[S::f64s]; PANEL] = std::array::from_fn(|k| registers::<S>(&column(k)[1..=length]));
    let one = S::as_mut_simd_f64s(&mut one[1..=length]).0;
    let two = S::as_mut_simd_f64s(&mut two[..length]).0;
    // Closures of `map` would be calls of their own here, without registers.
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

/// L y = b, then Lᵀ x = y.
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
        // One plane a coordinate.
        let mut planes: [Vec<f64>; D] = std::array::from_fn(|d| {
            let mut plane = Vec::with_capacity(length);
            plane.extend(x.iter().map(|values| values[d]));
            plane.resize(length, 0.0);
            plane
        });
        let panels = || factor.columns.chunks_exact(PANEL * stride).zip(&factor.reaches).enumerate();
        for (number, (panel, reach)) in panels() {
            let windows = planes.each_mut().map(|plane| &mut plane[number * PANEL..][..PANEL + reach]);
            forward(simd, panel, windows);
        }
        for (number, (panel, reach)) in panels().rev() {
            let windows = planes.each_mut().map(|plane| &mut plane[number * PANEL..][..PANEL + reach]);
            backward(simd, panel, windows);
        }
        for (k, values) in x.iter_mut().enumerate() {
            *values = std::array::from_fn(|d| planes[d][k]);
        }
    }
}

/// Solves for the first four numbers of each window and takes their part off the others.
#[inline(always)]
fn forward<S: Simd, const D: usize>(simd: S, panel: &[f64], windows: [&mut [f64]; D]) {
    let stride = panel.len() / PANEL;
    let reach = windows[0].len() - PANEL;
    let sources: [&[S::f64s]; PANEL] =
        std::array::from_fn(|k| registers::<S>(&panel[k * stride + PANEL - k..][..reach]));
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
    for i in 0..reach / LANES {
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
    let reach = windows[0].len() - PANEL;
    let sources: [&[S::f64s]; PANEL] =
        std::array::from_fn(|k| registers::<S>(&panel[k * stride + PANEL - k..][..reach]));
    let mut sums = [[simd.splat_f64s(0.0); PANEL]; D];
    let known = windows.each_ref().map(|window| registers::<S>(&window[PANEL..]));
    for i in 0..reach / LANES {
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

    /// A diagonally dominant matrix: entry (i, j) of its lower half.
    fn entry(i: usize, j: usize) -> f64 {
        if i == j { 9.0 + (i as f64).sin() } else { ((3 * i + j) as f64).cos() / (1 + i - j) as f64 }
    }

    #[test]
    fn solutions_solve_whatever_size_and_band() {
        for (size, band) in [(1, 0), (2, 1), (7, 2), (8, 7), (9, 4), (30, 5), (33, 32), (50, 13)] {
            solve_one(size, band, |i, j| i - j <= band);
            // Few entries fill the band: most columns are short.
            solve_one(size, band, |i, j| i - j <= band && (i - j <= band / 4 || j % 11 == 3));
        }
    }

    /// Factors and solves for a known solution; `holds` says which entries of the lower half there are.
    fn solve_one(size: usize, band: usize, holds: impl Fn(usize, usize) -> bool) {
        let entry = |i: usize, j: usize| if holds(i, j) { entry(i, j) } else { 0.0 };
        let mut columns = vec![0.0; size * stride(band)];
        for (j, column) in columns.chunks_exact_mut(stride(band)).enumerate() {
            (j..size.min(j + band + 1)).for_each(|i| column[i - j] = entry(i, j));
        }
        let factor = Cholesky::new(band, columns).expect("a positive definite matrix");
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
        assert!(Cholesky::new(1, columns(5.0)).is_some());
        assert!(Cholesky::new(1, columns(4.0)).is_none());
        assert!(Cholesky::new(1, columns(f64::NAN)).is_none());
    }
}
