//! Gram matrices of small blocks: dot products of all pairs of columns of a tall matrix, in register tiles.
//!
//! In: rows over the same handles. Out: sums to add to the normal matrix.

use super::simd::{LANES, load};
use pulp::{Simd, WithSimd};

/// Columns of a tile, and rows of its result.
const TILE: [usize; 2] = [LANES, 2 * LANES];

/// Rows of equal width and their Gram matrix.
#[derive(Clone, Debug, Default)]
pub(crate) struct GramMatrix {
    count: usize,
    /// `count`, rounded up to whole tiles; the rest of a row is zero.
    width: usize,
    rows: Vec<f64>,
    /// Column b holds Σ row_a row_b at b·width + a, for a from b on.
    sums: Vec<f64>,
}

impl GramMatrix {
    /// Removes all rows and sets the number of entries of new ones.
    pub(crate) fn clear(&mut self, count: usize) {
        self.count = count;
        self.width = count.next_multiple_of(TILE[1]);
        self.rows.clear();
    }

    /// Appends a row of zeros and returns it.
    #[inline(always)]
    pub(crate) fn push(&mut self) -> &mut [f64] {
        let start = self.rows.len();
        self.rows.resize(start + self.width, 0.0);
        &mut self.rows[start..start + self.count]
    }

    /// Appends four rows and returns them; the caller sets all their entries.
    #[inline(always)]
    pub(crate) fn push_packet(&mut self) -> [&mut [f64]; LANES] {
        let (start, width, count) = (self.rows.len(), self.width, self.count);
        self.rows.resize(start + LANES * width, 0.0);
        let mut rest = &mut self.rows[start..];
        std::array::from_fn(|_| {
            let (row, others) = std::mem::take(&mut rest).split_at_mut(width);
            rest = others;
            &mut row[..count]
        })
    }

    /// Whether there are no rows.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Column b of the Gram matrix, from its diagonal on.
    pub(crate) fn column(&self, b: usize) -> &[f64] {
        &self.sums[b * self.width + b..b * self.width + self.count]
    }
}

/// Kernel that computes the sums.
pub(crate) struct Sum<'a>(pub(crate) &'a mut GramMatrix);

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.sum(simd);
    }
}

impl GramMatrix {
    /// Computes the sums in the tiles at and below the diagonal; the others keep their values.
    #[inline(always)]
    pub(crate) fn sum<S: Simd>(&mut self, simd: S) {
        let Self { width, rows, sums, .. } = self;
        let width = *width;
        sums.resize(width * width, 0.0);
        for b in (0..width).step_by(TILE[0]) {
            for a in (b / TILE[1] * TILE[1]..width).step_by(TILE[1]) {
                tile(simd, rows, [a, b], Target { sums, width });
            }
        }
    }
}

/// Destination of a tile.
struct Target<'a> {
    sums: &'a mut [f64],
    width: usize,
}

/// Dot products of eight columns from `a` on with four from `b` on.
#[inline(always)]
fn tile<S: Simd>(simd: S, rows: &[f64], [a, b]: [usize; 2], target: Target) {
    let mut sums = [[simd.splat_f64s(0.0); 2]; LANES];
    for row in rows.chunks_exact(target.width) {
        let (heads, factors) = (row[a..a + TILE[1]].as_chunks::<LANES>().0, &row[b..b + TILE[0]]);
        let [low, high] = [load::<S>(&heads[0]), load::<S>(&heads[1])];
        for (sum, &factor) in sums.iter_mut().zip(factors) {
            let factor = simd.splat_f64s(factor);
            sum[0] = simd.mul_add_f64s(low, factor, sum[0]);
            sum[1] = simd.mul_add_f64s(high, factor, sum[1]);
        }
    }
    for (k, sum) in sums.iter().enumerate() {
        let slots = &mut target.sums[(b + k) * target.width + a..][..TILE[1]];
        let slots = S::as_mut_simd_f64s(slots).0;
        slots[0] = sum[0];
        slots[1] = sum[1];
    }
}
