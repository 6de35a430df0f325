//! Basis functions of one axis: values and derivatives at a coordinate t of the unit interval.
//!
//! In: basis, number of handles n, t (0 and 1 are the ends of the box; other values extend the polynomials at the
//! ends). Out: the functions that are non-zero there. Derivatives are per unit of t.

use super::basis::Basis;

/// Maximum number of handles per axis.
pub(crate) const MAX_HANDLES: usize = 64;

/// Maximum number of handles of a lattice: 64 x 64 in 2D, 16 x 16 x 16 in 3D. A solve factors a matrix of that size.
pub(crate) const MAX_HANDLES_IN_ALL: usize = 4096;

/// C(n, i) for n < 64: exact up to 2^53, within an ulp or two beyond.
static BINOMIALS: [[f64; MAX_HANDLES]; MAX_HANDLES] = binomials();

const fn binomials() -> [[f64; MAX_HANDLES]; MAX_HANDLES] {
    let mut table = [[0.0; MAX_HANDLES]; MAX_HANDLES];
    let mut n = 0;
    while n < MAX_HANDLES {
        table[n][0] = 1.0;
        let mut i = 1;
        while i <= n {
            table[n][i] = table[n - 1][i - 1] + if i < n { table[n - 1][i] } else { 0.0 };
            i += 1;
        }
        n += 1;
    }
    table
}

/// C(n, k) for k ≤ n < 64.
pub(super) fn binomial(n: usize, k: usize) -> f64 {
    BINOMIALS[n][k]
}

/// Maximum number of functions of a local basis that are non-zero at a coordinate.
pub(super) const MAX_LOCAL: usize = 4;

/// The functions of one axis that are non-zero at a coordinate: handles `first..first + len`.
///
/// N is the capacity; local bases need four, which keeps evaluation cheap.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisTerms<const N: usize = MAX_HANDLES> {
    /// First handle on this axis.
    pub first: usize,
    /// Number of handles.
    len: usize,
    values: [f64; N],
    slopes: [f64; N],
}

impl<const N: usize> AxisTerms<N> {
    /// Evaluates the functions of an axis with `count` handles at `t`.
    ///
    /// Barycentric cells are not a tensor product; they are treated as bilinear here.
    #[must_use]
    pub(crate) fn at(basis: Basis, count: usize, t: f64) -> Self {
        match basis {
            Basis::Bernstein => bernstein(count, t),
            Basis::Bspline => bspline(count, t),
            Basis::Bilinear | Basis::Barytri => linear(count, t),
        }
    }

    /// Returns the values, one per handle, from `first` on.
    #[must_use]
    pub(crate) fn values(&self) -> &[f64] {
        &self.values[..self.len]
    }

    /// Multiplies the derivatives, to change their unit.
    pub(super) fn scale_slopes(&mut self, factor: f64) {
        self.slopes[..self.len].iter_mut().for_each(|slope| *slope *= factor);
    }

    /// Returns the derivatives per unit of t, one per handle, from `first` on.
    #[must_use]
    pub(crate) fn slopes(&self) -> &[f64] {
        &self.slopes[..self.len]
    }
}

/// Returns the cell of a piecewise basis: its index and the local coordinate (0..=1 inside the box).
pub(super) fn cell(spans: usize, t: f64) -> (usize, f64) {
    let x = t * spans as f64;
    // The cast clamps negative values to 0.
    let cell = (x as usize).min(spans - 1);
    (cell, x - cell as f64)
}

/// Bernstein polynomials of degree count − 1 (paper, equation 2, with the degree corrected).
///
/// Powers times binomials: every term is a product, so there is no cancellation at any degree.
fn bernstein<const N: usize>(count: usize, t: f64) -> AxisTerms<N> {
    let degree = count - 1;
    let (mut up, mut down) = ([1.0; N], [1.0; N]);
    for i in 1..count {
        up[i] = up[i - 1] * t;
        down[i] = down[i - 1] * (1.0 - t);
    }
    let mut terms = AxisTerms { first: 0, len: count, values: [0.0; N], slopes: [0.0; N] };
    for i in 0..count {
        terms.values[i] = BINOMIALS[degree][i] * up[i] * down[degree - i];
    }
    // B_i' = m (b_{i−1} − b_i), b the polynomials of degree m − 1.
    for i in 0..degree {
        let lower = degree as f64 * BINOMIALS[degree - 1][i] * up[i] * down[degree - 1 - i];
        terms.slopes[i] -= lower;
        terms.slopes[i + 1] += lower;
    }
    terms
}

/// Evaluates Bernstein polynomials at several coordinates, one per lane: the values of [`AxisTerms::at`] for `values.len()` handles.
#[inline(always)]
pub(crate) fn bernstein_values<const N: usize>(units: &[f64; N], values: &mut [[f64; N]]) {
    let binomials = &BINOMIALS[values.len() - 1];
    let mut power = [1.0; N];
    for (value, binomial) in values.iter_mut().zip(binomials) {
        for lane in 0..N {
            value[lane] = binomial * power[lane];
            power[lane] *= units[lane];
        }
    }
    let mut power = [1.0; N];
    for value in values.iter_mut().rev() {
        for lane in 0..N {
            value[lane] *= power[lane];
            power[lane] *= 1.0 - units[lane];
        }
    }
}

/// Uniform cubic B-spline with count − 3 spans.
fn bspline<const N: usize>(count: usize, t: f64) -> AxisTerms<N> {
    let spans = count - 3;
    let (first, u) = cell(spans, t);
    let v = 1.0 - u;
    let mut terms = AxisTerms { first, len: 4, values: [0.0; N], slopes: [0.0; N] };
    terms.values[..4].copy_from_slice(&[
        v * v * v / 6.0,
        (u * u * (3.0 * u - 6.0) + 4.0) / 6.0,
        (v * v * (3.0 * v - 6.0) + 4.0) / 6.0,
        u * u * u / 6.0,
    ]);
    let scale = spans as f64 / 2.0;
    terms.slopes[..4].copy_from_slice(&[
        -v * v * scale,
        u * (3.0 * u - 4.0) * scale,
        -v * (3.0 * v - 4.0) * scale,
        u * u * scale,
    ]);
    terms
}

/// Hat functions.
fn linear<const N: usize>(count: usize, t: f64) -> AxisTerms<N> {
    let spans = count - 1;
    let (first, u) = cell(spans, t);
    let mut terms = AxisTerms { first, len: 2, values: [0.0; N], slopes: [0.0; N] };
    terms.values[..2].copy_from_slice(&[1.0 - u, u]);
    terms.slopes[..2].copy_from_slice(&[-(spans as f64), spans as f64]);
    terms
}
