//! Tall matrices over handles (rows of W, or of ∇W), stored four rows together so that loops run in vector registers.
//!
//! In: rest points and a grid. Out: products with the handles, and products of the transpose with values at the rows.
//! Rows that the same handles act on form a block; C coefficients a row and handle (1: weight, D: gradient).
//! Multiplications and additions are fused in registers and without, so every processor gives the same bits.

use crate::lattice::Grid;
use pulp::{Simd, WithSimd};

/// Rows that are computed together.
pub(crate) const LANES: usize = 4;

/// Blocks on more handles than this make most of their matrix: room for it is taken at once.
const FEW: usize = 64;

/// One number for each of four rows.
pub(crate) type Lanes = [f64; LANES];

/// Rows on the same handles.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Handles, as many as columns.
    pub(crate) handles: Vec<usize>,
    /// Its packs.
    pub(crate) packs: std::ops::Range<usize>,
    /// Where its coefficients start: [pack][handle].
    start: usize,
}

/// The matrix.
#[derive(Clone, Debug)]
pub(crate) struct Packs<const C: usize> {
    pub(crate) blocks: Vec<Block>,
    /// Original row of each lane; lanes without a row hold `usize::MAX` and zero coefficients.
    pub(crate) order: Vec<[usize; LANES]>,
    coefficients: Vec<[Lanes; C]>,
}

impl<const C: usize> Packs<C> {
    /// Builds the matrix; `coefficients` picks what a row holds from weight and gradient.
    pub(crate) fn new<const D: usize>(
        grid: &Grid<D>,
        points: &[[f64; D]],
        coefficients: impl Fn(f64, &[f64; D]) -> [f64; C],
    ) -> Self {
        let mut keyed: Vec<([usize; 2], usize)> =
            points.iter().enumerate().map(|(row, &point)| (grid.support(point), row)).collect();
        keyed.sort_unstable();
        let mut packs = Self { blocks: Vec::new(), order: Vec::new(), coefficients: Vec::new() };
        for rows in keyed.chunk_by(|a, b| a.0 == b.0) {
            packs.add_block(grid, points, rows, &coefficients);
        }
        packs
    }

    fn add_block<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        points: &[[f64; D]],
        rows: &[([usize; 2], usize)],
        coefficients: &impl Fn(f64, &[f64; D]) -> [f64; C],
    ) {
        let mut handles = Vec::new();
        grid.visit(points[rows[0].1], |term| handles.push(term.handle));
        let (first, start) = (self.order.len(), self.coefficients.len());
        if handles.len() > FEW {
            self.coefficients.reserve_exact(rows.len().div_ceil(LANES) * handles.len());
        }
        for chunk in rows.chunks(LANES) {
            let base = self.coefficients.len();
            self.coefficients.resize(base + handles.len(), [[0.0; LANES]; C]);
            let mut order = [usize::MAX; LANES];
            for (lane, &(_, row)) in chunk.iter().enumerate() {
                order[lane] = row;
                let mut slots = self.coefficients[base..].iter_mut();
                grid.visit(points[row], |term| {
                    let Some(slot) = slots.next() else { return };
                    let values = coefficients(term.weight, &term.gradient);
                    (0..C).for_each(|c| slot[c][lane] = values[c]);
                });
            }
            self.order.push(order);
        }
        self.blocks.push(Block { handles, packs: first..self.order.len(), start });
    }

    /// How far apart handles of a block are, by index.
    pub(crate) fn reach(&self) -> usize {
        self.blocks.iter().filter_map(|block| span(block.handles.iter().copied())).max().unwrap_or(0)
    }

    /// Adds coefficient_k · values of all packs of a block to the sums of its handles (of all handles), lane by lane.
    #[inline(always)]
    pub(crate) fn scatter_block<S: Simd, const D: usize>(
        &self,
        simd: S,
        block: &Block,
        values: &[[[S::f64s; C]; D]],
        sums: &mut [[Lanes; D]],
    ) {
        let count = block.handles.len();
        let coefficients = &self.coefficients[block.start..][..count * values.len()];
        for (k, &handle) in block.handles.iter().enumerate() {
            let mut totals = [[simd.splat_f64s(0.0); C]; D];
            for (pack, values) in coefficients[k..].iter().step_by(count).zip(values) {
                for d in 0..D {
                    for c in 0..C {
                        totals[d][c] = multiply_add(simd, load::<S>(&pack[c]), values[d][c], totals[d][c]);
                    }
                }
            }
            for d in 0..D {
                let slot = &mut S::as_mut_simd_f64s(&mut sums[handle][d]).0[0];
                *slot = totals[d].into_iter().fold(*slot, |sum, part| simd.add_f64s(sum, part));
            }
        }
    }

    /// Coefficients of all packs of a block: #handles each.
    #[inline(always)]
    pub(crate) fn packs(&self, block: &Block) -> std::slice::ChunksExact<'_, [Lanes; C]> {
        let count = block.handles.len();
        self.coefficients[block.start..][..count * block.packs.len()].chunks_exact(count)
    }

    /// Coefficients of one pack: #handles of its block.
    pub(crate) fn pack(&self, block: &Block, pack: usize) -> &[[Lanes; C]] {
        let start = block.start + (pack - block.packs.start) * block.handles.len();
        &self.coefficients[start..start + block.handles.len()]
    }
}

/// Greatest minus least.
pub(crate) fn span(numbers: impl Iterator<Item = usize> + Clone) -> Option<usize> {
    Some(numbers.clone().max()? - numbers.min()?)
}

/// Runs a kernel with the widest registers of four numbers that the processor has.
pub(crate) fn dispatch<Op: WithSimd>(kernel: Op) -> Op::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return Simd::vectorize(simd, kernel);
    }
    Simd::vectorize(pulp::Scalar256b, kernel)
}

/// Handles of a block, side by side.
pub(crate) fn local_handles<const D: usize>(block: &Block, handles: &[[f64; D]], local: &mut Vec<[f64; D]>) {
    local.clear();
    local.extend(block.handles.iter().map(|&handle| handles[handle]));
}

/// Four numbers as a register. Both instruction sets of [`dispatch`] have exactly four lanes.
#[inline(always)]
pub(crate) fn load<S: Simd>(lanes: &Lanes) -> S::f64s {
    S::as_simd_f64s(lanes).0[0]
}

/// A register as four numbers.
#[inline(always)]
pub(crate) fn store<S: Simd>(register: S::f64s) -> Lanes {
    let mut lanes = [0.0; LANES];
    S::as_mut_simd_f64s(&mut lanes).0[0] = register;
    lanes
}

/// a·b + c, rounded once.
#[inline(always)]
pub(crate) fn multiply_add<S: Simd>(simd: S, a: S::f64s, b: S::f64s, c: S::f64s) -> S::f64s {
    simd.mul_add_f64s(a, b, c)
}

/// Adds value · factor to every sum.
#[inline(always)]
pub(crate) fn add_multiple<S: Simd, const D: usize>(
    simd: S,
    value: S::f64s,
    factors: &[S::f64s; D],
    sums: &mut [S::f64s; D],
) {
    for (sum, factor) in sums.iter_mut().zip(factors) {
        *sum = multiply_add(simd, value, *factor, *sum);
    }
}

/// Σ_k coefficient_k P_k for four rows: `[coordinate][coefficient]`.
#[inline(always)]
pub(crate) fn gather<S: Simd, const C: usize, const D: usize>(
    simd: S,
    pack: &[[Lanes; C]],
    local: &[[f64; D]],
) -> [[S::f64s; C]; D] {
    let mut sums = [[simd.splat_f64s(0.0); C]; D];
    for (coefficients, handle) in pack.iter().zip(local) {
        for d in 0..D {
            let coordinate = simd.splat_f64s(handle[d]);
            for c in 0..C {
                sums[d][c] = multiply_add(simd, load::<S>(&coefficients[c]), coordinate, sums[d][c]);
            }
        }
    }
    sums
}

/// [`gather`] for several packs: as many times the sums hide the time that each addition takes.
#[inline(always)]
pub(crate) fn gather_group<S: Simd, const C: usize, const D: usize, const N: usize>(
    simd: S,
    packs: [&[[Lanes; C]]; N],
    local: &[[f64; D]],
) -> [[[S::f64s; C]; D]; N] {
    let mut sums = [[[simd.splat_f64s(0.0); C]; D]; N];
    let count = packs.iter().fold(local.len(), |count, pack| count.min(pack.len()));
    for k in 0..count {
        for d in 0..D {
            let coordinate = simd.splat_f64s(local[k][d]);
            for n in 0..N {
                for c in 0..C {
                    sums[n][d][c] = multiply_add(simd, load::<S>(&packs[n][k][c]), coordinate, sums[n][d][c]);
                }
            }
        }
    }
    sums
}

/// Adds coefficient_k · values of several packs to every handle's sum, lane by lane, one pack after the other.
#[inline(always)]
pub(crate) fn scatter_group<S: Simd, const C: usize, const D: usize, const N: usize>(
    simd: S,
    packs: [&[[Lanes; C]]; N],
    values: &[[[S::f64s; C]; D]; N],
    sums: &mut [[Lanes; D]],
) {
    let count = packs.iter().fold(sums.len(), |count, pack| count.min(pack.len()));
    for (k, sum) in sums[..count].iter_mut().enumerate() {
        for d in 0..D {
            let slot = &mut S::as_mut_simd_f64s(&mut sum[d]).0[0];
            let mut total = *slot;
            for n in 0..N {
                for c in 0..C {
                    total = multiply_add(simd, load::<S>(&packs[n][k][c]), values[n][d][c], total);
                }
            }
            *slot = total;
        }
    }
}

/// Adds the lanes of a block's sums to the right side.
pub(crate) fn add_sums<const D: usize>(block: &Block, sums: &[[Lanes; D]], scale: f64, right_side: &mut [[f64; D]]) {
    for (&handle, sum) in block.handles.iter().zip(sums) {
        (0..D).for_each(|d| right_side[handle][d] += scale * sum[d].iter().sum::<f64>());
    }
}
