//! Tall matrices over handles (rows of W, or of ∇W), stored eight rows together so that loops run in vector registers.
//!
//! In: rest points and a grid. Out: products with the handles, and products of the transpose with values at the rows.
//! Rows that the same handles act on form a block; C coefficients a row and handle (1: weight, D: gradient).

use crate::lattice::Grid;

/// Rows that are computed together.
pub(crate) const LANES: usize = 8;

/// One number for each of eight rows.
pub(crate) type Lanes = [f64; LANES];

/// What is known about eight rows: `[coordinate][coefficient]`.
pub(crate) type PackValues<const C: usize, const D: usize> = [[Lanes; C]; D];

/// Rows on the same handles.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// Handles, as many as columns.
    pub(crate) handles: Vec<usize>,
    /// First pack; the block ends where the next begins.
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
        let mut keyed: Vec<([usize; 3], usize)> =
            points.iter().enumerate().map(|(row, &point)| (block_key(grid, point), row)).collect();
        if grid.basis.is_local() {
            keyed.sort_unstable();
        }
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
        rows: &[([usize; 3], usize)],
        coefficients: &impl Fn(f64, &[f64; D]) -> [f64; C],
    ) {
        let mut handles = Vec::new();
        grid.visit(points[rows[0].1], |term| handles.push(term.handle));
        let (first, start) = (self.order.len(), self.coefficients.len());
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

/// Rows with equal keys are acted on by the same handles.
fn block_key<const D: usize>(grid: &Grid<D>, point: [f64; D]) -> [usize; 3] {
    let mut key = [0; 3];
    if grid.basis.is_local() {
        let mut seen = 0;
        grid.visit(point, |term| {
            if seen < 3 {
                key[seen] = term.handle;
            }
            seen += 1;
        });
    }
    key
}

/// Handles of a block, side by side.
pub(crate) fn local_handles<const D: usize>(block: &Block, handles: &[[f64; D]], local: &mut Vec<[f64; D]>) {
    local.clear();
    local.extend(block.handles.iter().map(|&handle| handles[handle]));
}

/// Σ_k coefficient_k P_k for eight rows.
#[inline(always)]
pub(crate) fn gather<const C: usize, const D: usize>(pack: &[[Lanes; C]], local: &[[f64; D]]) -> PackValues<C, D> {
    let mut sums = [[[0.0; LANES]; C]; D];
    for (coefficients, handle) in pack.iter().zip(local) {
        for d in 0..D {
            for c in 0..C {
                for lane in 0..LANES {
                    sums[d][c][lane] += coefficients[c][lane] * handle[d];
                }
            }
        }
    }
    sums
}

/// Adds coefficient_k · values to every handle's sum, lane by lane.
#[inline(always)]
pub(crate) fn scatter<const C: usize, const D: usize>(
    pack: &[[Lanes; C]],
    values: &PackValues<C, D>,
    sums: &mut [[Lanes; D]],
) {
    for (coefficients, sum) in pack.iter().zip(sums) {
        for d in 0..D {
            for c in 0..C {
                for lane in 0..LANES {
                    sum[d][lane] += coefficients[c][lane] * values[d][c][lane];
                }
            }
        }
    }
}

/// Adds the lanes of a block's sums to the right side.
pub(crate) fn add_sums<const D: usize>(block: &Block, sums: &[[Lanes; D]], scale: f64, right_side: &mut [[f64; D]]) {
    for (&handle, sum) in block.handles.iter().zip(sums) {
        (0..D).for_each(|d| right_side[handle][d] += scale * sum[d].iter().sum::<f64>());
    }
}
