//! Symmetric products aᵀb of tall matrices, added to a dense [`NormalMatrix`] or to part of a matrix that is being factored.
//!
//! In: rows of a and b, one batch at a time. Out: the lower half of the product. a and b are never complete in memory: a batch
//! stays in the second-level cache.

use super::simd::{LANES, load, multiply_add};
use crate::simd::dispatch;
use crate::solve::cancel::{Cancel, WorkMeter};
use pulp::{Simd, WithSimd};

/// Rows per batch.
const ROWS: usize = 120;

/// Columns of b (`TALL`) and of a (`WIDE`) per tile of the product. Its twelve registers, two of b and one of a are 15 of the 16
/// registers.
const TALL: usize = 2 * LANES;
const WIDE: usize = 6;

/// Generates the rows of a and b.
pub(crate) trait SyrkRows {
    /// Number of rows.
    fn count(&self) -> usize;

    /// Writes a row of a and the same row of b, #handles each. The [`ROW_PADDING`] numbers behind each may be overwritten; they
    /// are never read.
    fn write<S: Simd>(&mut self, simd: S, row: usize, pair: [&mut [f64]; 2]);
}

/// Numbers behind a row that may be overwritten.
pub(crate) const ROW_PADDING: usize = LANES;

/// The lower half of a dense matrix.
pub(super) struct LowerColumns<'a> {
    /// The columns, `stride` apart, each from the diagonal on.
    pub(super) numbers: &'a mut [f64],
    /// Number of columns.
    pub(super) size: usize,
    pub(super) stride: usize,
}

/// Adds scale · aᵀb, which must be symmetric, to the lower half of a dense matrix.
pub(super) fn add_syrk(lower: LowerColumns, scale: f64, rows: &mut impl SyrkRows, cancel: &Cancel) {
    dispatch(AddSyrk { lower, scale, rows, meter: cancel.meter() });
}

/// Kernel of [`add_syrk`].
struct AddSyrk<'a, R> {
    lower: LowerColumns<'a>,
    scale: f64,
    rows: &'a mut R,
    meter: WorkMeter<'a>,
}

impl<R: SyrkRows> WithSimd for AddSyrk<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { mut lower, scale, rows, mut meter } = self;
        let (total, size) = (rows.count(), lower.size);
        let (mut a, mut b) = (vec![0.0; size + ROW_PADDING], vec![0.0; size + ROW_PADDING]);
        let mut panels = PackedPanels::new(total.min(ROWS), size);
        for first in (0..total).step_by(ROWS) {
            let depth = ROWS.min(total - first);
            panels.resize([depth, size]);
            for k in 0..depth {
                rows.write(simd, first + k, [&mut a, &mut b]);
                panels.put(k, [&a[..size], &b[..size]]);
            }
            panels.add_to(simd, scale, &mut lower, &mut meter);
            if meter.is_stopped() {
                return;
            }
        }
    }
}

/// Rows of a and b, packed in panels as wide as a tile, so that tiles read them sequentially.
pub(super) struct PackedPanels {
    depth: usize,
    width: usize,
    wide: Vec<f64>,
    tall: Vec<f64>,
}

impl PackedPanels {
    /// Allocates for `depth` rows of `width` columns.
    pub(super) fn new(depth: usize, width: usize) -> Self {
        let [wide, tall] = [WIDE, TALL].map(|side| vec![0.0; depth * width.next_multiple_of(side)]);
        Self { depth, width, wide, tall }
    }

    /// Changes the size within the capacity; all rows have to be packed again.
    pub(super) fn resize(&mut self, [depth, width]: [usize; 2]) {
        (self.depth, self.width) = (depth, width);
    }

    /// Packs a row of a and of b, padded with zeros.
    #[inline(always)]
    pub(super) fn put(&mut self, k: usize, [a, b]: [&[f64]; 2]) {
        put::<WIDE>(a, k, self.wide.chunks_exact_mut(self.depth * WIDE).take(self.width.div_ceil(WIDE)));
        put::<TALL>(b, k, self.tall.chunks_exact_mut(self.depth * TALL).take(self.width.div_ceil(TALL)));
    }

    /// Adds scale · aᵀb to a matrix as large as the product.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(&self, simd: S, scale: f64, lower: &mut LowerColumns, meter: &mut WorkMeter) {
        let scale = simd.splat_f64s(scale);
        let wide = self.wide.chunks_exact(self.depth * WIDE).take(self.width.div_ceil(WIDE));
        for (number, a) in wide.enumerate() {
            let column = number * WIDE;
            if meter.count_and_poll(self.depth * WIDE * (self.width - column)) {
                return;
            }
            let tall = self.tall.chunks_exact(self.depth * TALL).take(self.width.div_ceil(TALL));
            for (panel, b) in tall.enumerate().skip(column / TALL) {
                let tile = product(simd, a, b);
                lower.add_tile(simd, [panel * TALL, column], scale, &tile);
            }
        }
    }
}

/// Packs a row into panels of N columns.
#[inline(always)]
fn put<'a, const N: usize>(row: &[f64], k: usize, mut panels: impl Iterator<Item = &'a mut [f64]>) {
    let (whole, rest) = row.as_chunks::<N>();
    for (numbers, panel) in whole.iter().zip(panels.by_ref()) {
        panel.as_chunks_mut::<N>().0[k] = *numbers;
    }
    let mut last = [0.0; N];
    last.iter_mut().zip(rest).for_each(|(slot, x)| *slot = *x);
    for panel in panels {
        panel.as_chunks_mut::<N>().0[k] = last;
        last = [0.0; N];
    }
}

/// A tile of the product: eight rows of each of six columns.
#[inline(always)]
fn product<S: Simd>(simd: S, a: &[f64], b: &[f64]) -> [[S::f64s; 2]; WIDE] {
    let mut tile = [[simd.splat_f64s(0.0); 2]; WIDE];
    for (a, b) in a.as_chunks::<WIDE>().0.iter().zip(b.as_chunks::<TALL>().0) {
        let b = b.as_chunks::<LANES>().0;
        let (upper, lower) = (load::<S>(&b[0]), load::<S>(&b[1]));
        for (column, a) in tile.iter_mut().zip(a) {
            let a = simd.splat_f64s(*a);
            column[0] = multiply_add(simd, a, upper, column[0]);
            column[1] = multiply_add(simd, a, lower, column[1]);
        }
    }
    tile
}

impl LowerColumns<'_> {
    /// Adds the entries of a tile at and below the diagonal, times a scale.
    #[inline(always)]
    fn add_tile<S: Simd>(&mut self, simd: S, [row, column]: [usize; 2], scale: S::f64s, tile: &[[S::f64s; 2]; WIDE]) {
        let Self { ref mut numbers, size, stride } = *self;
        for (number, sums) in tile.iter().enumerate().take(size - column) {
            let column = column + number;
            if row >= column && row + TALL <= size {
                let slots = &mut numbers[column * stride + row - column..][..TALL];
                for (slot, sum) in S::as_mut_simd_f64s(slots).0.iter_mut().zip(sums) {
                    *slot = multiply_add(simd, scale, *sum, *slot);
                }
                continue;
            }
            let mut scaled = [0.0; TALL];
            for (slot, sum) in S::as_mut_simd_f64s(&mut scaled).0.iter_mut().zip(sums) {
                *slot = simd.mul_f64s(scale, *sum);
            }
            for k in column.saturating_sub(row)..TALL.min(size - row) {
                numbers[column * stride + row + k - column] += scaled[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::band_storage::stride;
    use super::super::normal_matrix::NormalMatrix;
    use super::*;

    /// Rows of given matrices.
    struct Given<'a>(&'a [Vec<f64>], &'a [Vec<f64>]);

    impl SyrkRows for Given<'_> {
        fn count(&self) -> usize {
            self.0.len()
        }

        fn write<S: Simd>(&mut self, _: S, row: usize, [a, b]: [&mut [f64]; 2]) {
            a[..self.0[row].len()].copy_from_slice(&self.0[row]);
            b[..self.1[row].len()].copy_from_slice(&self.1[row]);
            // The padding may have any value.
            a[self.0[row].len()] = f64::NAN;
        }
    }

    #[test]
    fn products_are_sums_over_rows() {
        for (size, count) in [(1, 1), (4, 70), (13, 5), (25, 64), (40, 129)] {
            let a: Vec<Vec<f64>> = (0..count)
                .map(|row| (0..size).map(|column| ((row * 7 + column * 13) as f64).sin()).collect())
                .collect();
            let mut normal = NormalMatrix::zero(size, size);
            normal.add_syrk(0.5, &mut Given(&a, &a), &Cancel::never());
            normal.add_syrk(1.5, &mut Given(&a, &a), &Cancel::never());
            for column in 0..size {
                for row in column..size {
                    let wanted: f64 = a.iter().map(|numbers| 2.0 * numbers[row] * numbers[column]).sum();
                    let found = normal.columns[column * stride(normal.band) + row - column];
                    assert!((found - wanted).abs() < 1e-12 * count as f64, "{size} {count} {row} {column}");
                }
            }
            // Storage below the last row is unchanged.
            for column in 0..size {
                let beyond = &normal.columns[column * stride(normal.band)..][size - column..stride(normal.band)];
                assert!(beyond.iter().all(|&x| x == 0.0));
            }
        }
    }
}
