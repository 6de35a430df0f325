//! Rows of the weights of a basis of global support, and of linear combinations of a few points.
//!
//! In: the factors of separable weights. Out: rows over all handles. The weights are multiplied out once if all of them fit into
//! the cache.

use super::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use super::linalg::syrk::ROW_PADDING;
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

/// Maximum number of weights that are multiplied out: half a second-level cache.
const MAX_WEIGHTS: usize = 1 << 16;

/// Number of registers per row that are computed together.
const UNROLL: usize = 4;

/// Weights of some points, as factors or multiplied out.
pub(crate) struct SeparableRows {
    /// Number of handles in a row of handles along x, and number of these rows.
    counts: [usize; 2],
    points: usize,
    /// For each point the basis functions of x, then those of the rows; both are padded to whole registers.
    factors: Vec<f64>,
    /// Sums of a linear combination; each row of handles is padded to whole registers.
    sums: Vec<Lanes>,
    /// All weights of each point in whole registers, with padding for a read beyond the last; empty if they are too many.
    whole: Vec<Lanes>,
}

impl SeparableRows {
    /// Creates the weights from factors in the order of the field `factors`.
    pub(super) fn new(counts: [usize; 2], points: usize, factors: Vec<f64>) -> Self {
        let sums = vec![[0.0; LANES]; counts[1] * counts[0].div_ceil(LANES)];
        let mut weights = Self { counts, points, factors, sums, whole: Vec::new() };
        let registers = weights.registers();
        if points * registers * LANES <= MAX_WEIGHTS {
            let mut whole = vec![[0.0; LANES]; points * registers + UNROLL];
            dispatch(MultiplyOut { weights: &mut weights, whole: &mut whole });
            weights.whole = whole;
        }
        weights
    }

    /// Number of registers for the weights of a point.
    fn registers(&self) -> usize {
        (self.counts[0] * self.counts[1]).div_ceil(LANES)
    }

    /// Writes Σ coefficient · weights, #handles, for the (point, coefficient) pairs of `mixed`. Up to [`ROW_PADDING`] numbers
    /// after the row may be overwritten.
    #[inline(always)]
    pub(crate) fn write<S: Simd>(&mut self, simd: S, mixed: &[(usize, f64)], row: &mut [f64]) {
        if self.whole.is_empty() {
            return self.write_products(simd, mixed, row);
        }
        let registers = self.registers();
        for (number, slots) in row.as_chunks_mut::<LANES>().0.chunks_mut(UNROLL).enumerate() {
            let mut sums = [simd.splat_f64s(0.0); UNROLL];
            for &(point, coefficient) in mixed {
                let coefficient = simd.splat_f64s(coefficient);
                let weights = &self.whole[point * registers + number * UNROLL..];
                if let Some(weights) = weights.first_chunk::<UNROLL>() {
                    for n in 0..UNROLL {
                        sums[n] = multiply_add(simd, coefficient, load::<S>(&weights[n]), sums[n]);
                    }
                }
            }
            for (slot, sum) in slots.iter_mut().zip(sums) {
                *slot = store::<S>(sum);
            }
        }
    }

    #[inline(always)]
    fn write_products<S: Simd>(&mut self, simd: S, mixed: &[(usize, f64)], row: &mut [f64]) {
        let (inner, registers) = (self.counts[0], self.counts[0].div_ceil(LANES));
        // Loops of constant length stay in registers.
        match registers {
            3 => self.mix::<S, 3>(simd, mixed),
            4 => self.mix::<S, 4>(simd, mixed),
            _ => self.mix_any(simd, mixed),
        }
        // Numbers written beyond the last handle of a row are overwritten by the next row.
        for (number, sums) in self.sums.chunks_exact(registers).enumerate() {
            for (slots, sums) in row[number * inner..].as_chunks_mut::<LANES>().0.iter_mut().zip(sums) {
                *slots = *sums;
            }
        }
    }

    /// Number of factors per point, with padding.
    fn stride(&self) -> usize {
        self.counts.iter().map(|count| count.next_multiple_of(LANES)).sum()
    }

    /// Sums rows of N registers.
    #[inline(always)]
    fn mix<S: Simd, const N: usize>(&mut self, simd: S, mixed: &[(usize, f64)]) {
        let stride = self.stride();
        self.sums.fill([0.0; LANES]);
        for &(point, coefficient) in mixed {
            let (xs, rows) = self.factors[point * stride..][..stride].split_at(N * LANES);
            let xs = xs.as_chunks::<LANES>().0;
            let mut values = [simd.splat_f64s(0.0); N];
            for n in 0..N {
                values[n] = load::<S>(&xs[n]);
            }
            for (sums, value) in self.sums.as_chunks_mut::<N>().0.iter_mut().zip(rows) {
                let factor = simd.splat_f64s(coefficient * value);
                for n in 0..N {
                    sums[n] = store::<S>(multiply_add(simd, factor, values[n], load::<S>(&sums[n])));
                }
            }
        }
    }

    /// Sums rows of any length.
    #[inline(always)]
    fn mix_any<S: Simd>(&mut self, simd: S, mixed: &[(usize, f64)]) {
        let (stride, registers) = (self.stride(), self.counts[0].div_ceil(LANES));
        self.sums.fill([0.0; LANES]);
        for &(point, coefficient) in mixed {
            let (xs, rows) = self.factors[point * stride..][..stride].split_at(registers * LANES);
            for (sums, value) in self.sums.chunks_exact_mut(registers).zip(rows) {
                let factor = simd.splat_f64s(coefficient * value);
                for (sum, x) in sums.iter_mut().zip(xs.as_chunks::<LANES>().0) {
                    *sum = store::<S>(multiply_add(simd, factor, load::<S>(x), load::<S>(sum)));
                }
            }
        }
    }
}

/// Kernel that multiplies out all weights.
struct MultiplyOut<'a> {
    weights: &'a mut SeparableRows,
    whole: &'a mut [Lanes],
}

impl WithSimd for MultiplyOut<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { weights, whole } = self;
        let size = weights.counts[0] * weights.counts[1];
        let mut row = vec![0.0; size + ROW_PADDING];
        for (point, lanes) in whole.chunks_exact_mut(weights.registers()).take(weights.points).enumerate() {
            weights.write_products(simd, &[(point, 1.0)], &mut row);
            lanes.as_flattened_mut()[..size].copy_from_slice(&row[..size]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::separable_weights::SeparableWeights;

    struct Write<'a>(&'a mut SeparableRows, &'a [(usize, f64)], &'a mut [f64]);

    impl WithSimd for Write<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.write(simd, self.1, self.2);
        }
    }

    #[test]
    fn rows_are_sums_of_weights_whether_multiplied_out_or_not() {
        for (dims, count) in [([5, 5], 30), ([3, 9], 7), ([10, 10], 700), ([15, 15], 400), ([20, 18], 300)] {
            let grid = Grid { dims, basis: Basis::Bernstein, lo: [-1.0; 2], hi: [1.0; 2], angle: 0.0 };
            let points: Vec<[f64; 2]> = (0..count).map(|k| [(k as f64).sin(), (1.7 * k as f64).cos()]).collect();
            let mut weights = SeparableWeights::new(&grid, &points).expect("every handle acts everywhere").by_point();
            let mixed = [(count - 1, 2.0), (0, -0.5), (count / 2, 1.0)];
            let mut row = vec![0.0; grid.handle_count() + ROW_PADDING];
            dispatch(Write(&mut weights, &mixed, &mut row));
            let mut wanted = vec![0.0; grid.handle_count()];
            for (point, coefficient) in mixed {
                grid.for_each_weight(points[point], |term| wanted[term.handle] += coefficient * term.weight);
            }
            for (found, wanted) in row.iter().zip(&wanted) {
                assert!((found - wanted).abs() < 1e-14, "{dims:?}: {found} {wanted}");
            }
        }
    }
}
