//! Sparse matrices over handles (rows of W or ∇W), stored for SIMD: four rows form a packet, one row per lane.
//!
//! In: rest points and a grid. Out: products with the handles, and products of the transpose with values at the rows. Rows with
//! the same support form a block, which stores C coefficients per row and handle (1 for the weight, D for the gradient). All code
//! paths use fused multiply-add, so results have the same bits on every processor.

use super::cancel::{Cancel, WorkMeter};
use super::linalg::normal_matrix::index_extent;
use super::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use crate::lattice::Grid;
use crate::simd::dispatch;
use pulp::{Simd, WithSimd};

/// Memory is reserved exactly for blocks with more handles than this, because they make up most of their matrix.
const FEW: usize = 64;

/// The support key of a row, see [`Grid::support`], and the index of the row.
type KeyedRow = ([usize; 2], usize);

/// A range of rows in one cell, and the unknowns that act on it in place of the cell's handles.
pub(crate) type RowGroup<'a> = (std::ops::Range<usize>, &'a [usize]);

/// Rows with the same support.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// The support, in the order of the coefficients.
    pub(crate) handles: Vec<usize>,
    /// Range of packets.
    pub(crate) packets: std::ops::Range<usize>,
    /// Index of the first coefficient; the order is [packet][handle].
    start: usize,
}

impl Block {
    /// Returns the block restricted to a range of its packets.
    pub(crate) fn part(&self, packets: std::ops::Range<usize>) -> Self {
        let start = self.start + (packets.start - self.packets.start) * self.handles.len();
        Self { handles: self.handles.clone(), packets, start }
    }
}

/// Matrix of rows in blocks and packets.
#[derive(Clone, Debug)]
pub(crate) struct BlockedWeights<const C: usize> {
    pub(crate) blocks: Vec<Block>,
    /// Original row of each lane; unused lanes hold `usize::MAX` and coefficients of zero.
    pub(crate) order: Vec<[usize; LANES]>,
    coefficients: Vec<[Lanes; C]>,
}

/// A block, and a value per packet of it.
pub(crate) struct BlockValues<'a, V> {
    pub(crate) block: &'a Block,
    pub(crate) values: &'a [V],
}

/// The rows of a block, which have one support.
struct BlockRows<'a, const D: usize> {
    /// The points of all rows.
    points: &'a [[f64; D]],
    rows: &'a [KeyedRow],
}

impl<const C: usize> BlockedWeights<C> {
    /// Builds the matrix at `points`. `coefficients` selects what a row stores from a handle's weight and gradient.
    pub(crate) fn new<const D: usize>(
        grid: &Grid<D>,
        points: &[[f64; D]],
        coefficients: impl Fn(f64, &[f64; D]) -> [f64; C],
        cancel: &Cancel,
    ) -> Self {
        let mut keyed: Vec<KeyedRow> =
            points.iter().enumerate().map(|(row, &point)| (grid.support(point), row)).collect();
        keyed.sort_unstable();
        let mut packets = Self { blocks: Vec::new(), order: Vec::new(), coefficients: Vec::new() };
        for rows in keyed.chunk_by(|a, b| a.0 == b.0) {
            packets.add_block(grid, BlockRows { points, rows }, &coefficients, cancel);
        }
        packets
    }

    /// Same as [`Self::new`] for points in groups, each of which has one support and its own unknowns in place of the handles.
    pub(crate) fn grouped<const D: usize>(
        grid: &Grid<D>,
        (points, groups): (&[[f64; D]], &[RowGroup]),
        coefficients: impl Fn(f64, &[f64; D]) -> [f64; C],
        cancel: &Cancel,
    ) -> Self {
        let mut packets = Self { blocks: Vec::new(), order: Vec::new(), coefficients: Vec::new() };
        for (rows, unknowns) in groups {
            let keyed: Vec<KeyedRow> = rows.clone().map(|row| ([0; 2], row)).collect();
            packets.add_block(grid, BlockRows { points, rows: &keyed }, &coefficients, cancel);
            packets.blocks.last_mut().expect("one block was added").handles = unknowns.to_vec();
        }
        packets
    }

    fn add_block<const D: usize>(
        &mut self,
        grid: &Grid<D>,
        BlockRows { points, rows }: BlockRows<D>,
        coefficients: &impl Fn(f64, &[f64; D]) -> [f64; C],
        cancel: &Cancel,
    ) {
        let mut handles = Vec::new();
        grid.for_each_weight(points[rows[0].1], |term| handles.push(term.handle));
        let (first, start) = (self.order.len(), self.coefficients.len());
        if handles.len() > FEW {
            self.coefficients.reserve_exact(rows.len().div_ceil(LANES) * handles.len());
        }
        let mut meter = cancel.meter();
        for chunk in rows.chunks(LANES) {
            // A weight takes about ten multiplications.
            if meter.count_and_poll(10 * LANES * handles.len()) {
                break;
            }
            let base = self.coefficients.len();
            self.coefficients.resize(base + handles.len(), [[0.0; LANES]; C]);
            let mut order = [usize::MAX; LANES];
            for (lane, &(_, row)) in chunk.iter().enumerate() {
                order[lane] = row;
                let mut slots = self.coefficients[base..].iter_mut();
                grid.for_each_weight(points[row], |term| {
                    let Some(slot) = slots.next() else { return };
                    let values = coefficients(term.weight, &term.gradient);
                    (0..C).for_each(|c| slot[c][lane] = values[c]);
                });
            }
            self.order.push(order);
        }
        self.blocks.push(Block { handles, packets: first..self.order.len(), start });
    }

    /// Builds the matrix at the same `places` (0 to 1 within a cell) of several cells, for a grid whose basis functions are the
    /// same in all cells. Each cell has its own block; all blocks share their coefficients.
    pub(crate) fn in_cells<const D: usize>(
        grid: &Grid<D>,
        cells: &[usize],
        places: &[[f64; D]],
        coefficients: impl Fn(f64, &[f64; D]) -> [f64; C],
        cancel: &Cancel,
    ) -> Self {
        let points_of = |cell: usize| {
            let corner = grid.cell_coords(cell);
            let point = move |place: &[f64; D]| {
                std::array::from_fn(|axis| grid.lo[axis] + (corner[axis] as f64 + place[axis]) * grid.spacing(axis))
            };
            places.iter().map(point).collect::<Vec<[f64; D]>>()
        };
        let Some((&first, rest)) = cells.split_first() else {
            return Self { blocks: Vec::new(), order: Vec::new(), coefficients: Vec::new() };
        };
        let mut matrix = Self::new(grid, &points_of(first), coefficients, cancel);
        let Some(block) = matrix.blocks.first().cloned() else { return matrix };
        let order = matrix.order.clone();
        let origin = block.handles[0];
        for &cell in rest {
            let mut start = usize::MAX;
            grid.for_each_weight(points_of(cell)[0], |term| start = start.min(term.handle));
            let handles = block.handles.iter().map(|handle| handle - origin + start).collect();
            let packets = matrix.order.len()..matrix.order.len() + order.len();
            matrix.order.extend_from_slice(&order);
            matrix.blocks.push(Block { handles, packets, start: block.start });
        }
        matrix
    }

    /// Replaces the handle indices of all blocks by those of other unknowns, in the same order.
    pub(crate) fn relabel(&mut self, unknown_of: impl Fn(usize) -> usize) {
        let handles = self.blocks.iter_mut().flat_map(|block| &mut block.handles);
        handles.for_each(|handle| *handle = unknown_of(*handle));
    }

    /// Appends the rows of another matrix. Their entries in `order` keep counting from the first row of that matrix.
    pub(crate) fn append(&mut self, other: Self) {
        let (packets, coefficients) = (self.order.len(), self.coefficients.len());
        self.order.extend(other.order);
        self.coefficients.extend(other.coefficients);
        self.blocks.extend(other.blocks.into_iter().map(|block| Block {
            packets: block.packets.start + packets..block.packets.end + packets,
            start: block.start + coefficients,
            ..block
        }));
    }

    /// Largest difference of handle indices within a block.
    pub(crate) fn bandwidth(&self) -> usize {
        self.blocks.iter().filter_map(|block| index_extent(block.handles.iter().copied())).max().unwrap_or(0)
    }

    /// Adds Wᵀ · values of all packets of a block to `sums`, which holds a sum per handle of the grid and lane. Returns true if
    /// the solve was cancelled.
    #[inline(always)]
    pub(crate) fn scatter_block<S: Simd, const D: usize>(
        &self,
        simd: S,
        BlockValues { block, values }: BlockValues<[[S::f64s; C]; D]>,
        sums: &mut [[Lanes; D]],
        meter: &mut WorkMeter,
    ) -> bool {
        let count = block.handles.len();
        let coefficients = &self.coefficients[block.start..][..count * values.len()];
        for (k, &handle) in block.handles.iter().enumerate() {
            if meter.count_and_poll(LANES * C * D * values.len()) {
                return true;
            }
            let mut totals = [[simd.splat_f64s(0.0); C]; D];
            for (packet, values) in coefficients[k..].iter().step_by(count).zip(values) {
                for d in 0..D {
                    for c in 0..C {
                        totals[d][c] = multiply_add(simd, load::<S>(&packet[c]), values[d][c], totals[d][c]);
                    }
                }
            }
            for d in 0..D {
                let slot = &mut S::as_mut_simd_f64s(&mut sums[handle][d]).0[0];
                *slot = totals[d].into_iter().fold(*slot, |sum, part| simd.add_f64s(sum, part));
            }
        }
        false
    }

    /// Coefficients of a block, packet by packet, one per handle of the block.
    #[inline(always)]
    pub(crate) fn packets(&self, block: &Block) -> std::slice::ChunksExact<'_, [Lanes; C]> {
        let count = block.handles.len();
        self.coefficients[block.start..][..count * block.packets.len()].chunks_exact(count)
    }

    /// Coefficients of one packet, one per handle of its block.
    pub(crate) fn packet(&self, block: &Block, packet: usize) -> &[[Lanes; C]] {
        let start = block.start + (packet - block.packets.start) * block.handles.len();
        &self.coefficients[start..start + block.handles.len()]
    }
}

impl<const D: usize> BlockedWeights<D> {
    /// Gradient of the lattice at all rows of a matrix of ∇W, packet by packet, as [row][column][lane].
    pub(crate) fn gradients_at(&self, handles: &[[f64; D]]) -> Vec<[[Lanes; D]; D]> {
        let count = self.order.len();
        dispatch(Gradients { weights: self, blocks: self.blocks.iter(), count, handles })
    }

    /// Same as [`Self::gradients_at`], at the rows of some blocks.
    pub(crate) fn gradients_in(&self, blocks: &[usize], handles: &[[f64; D]]) -> Vec<[[Lanes; D]; D]> {
        let blocks = blocks.iter().map(|&block| &self.blocks[block]);
        let count = blocks.clone().map(|block| block.packets.len()).sum();
        dispatch(Gradients { weights: self, blocks, count, handles })
    }
}

/// Kernel of [`BlockedWeights::gradients_at`].
struct Gradients<'a, const D: usize, I> {
    weights: &'a BlockedWeights<D>,
    blocks: I,
    /// Number of packets in all blocks.
    count: usize,
    handles: &'a [[f64; D]],
}

impl<'a, const D: usize, I: Iterator<Item = &'a Block>> WithSimd for Gradients<'a, D, I> {
    type Output = Vec<[[Lanes; D]; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut gradients = Vec::with_capacity(self.count);
        let mut local = Vec::new();
        for block in self.blocks {
            local_handles(block, self.handles, &mut local);
            for coefficients in self.weights.packets(block) {
                gradients.push(gather(simd, coefficients, &local).map(|row| row.map(|x| store::<S>(x))));
            }
        }
        gradients
    }
}

/// Copies the handles that a block refers to into `local`.
pub(crate) fn local_handles<const D: usize>(block: &Block, handles: &[[f64; D]], local: &mut Vec<[f64; D]>) {
    local.clear();
    local.extend(block.handles.iter().map(|&handle| handles[handle]));
}

/// Returns Σ_k coefficient_k P_k for the four rows of a packet, as `[coordinate][coefficient]`.
#[inline(always)]
pub(crate) fn gather<S: Simd, const C: usize, const D: usize>(
    simd: S,
    packet: &[[Lanes; C]],
    local: &[[f64; D]],
) -> [[S::f64s; C]; D] {
    let mut sums = [[simd.splat_f64s(0.0); C]; D];
    for (coefficients, handle) in packet.iter().zip(local) {
        for d in 0..D {
            let coordinate = simd.splat_f64s(handle[d]);
            for c in 0..C {
                sums[d][c] = multiply_add(simd, load::<S>(&coefficients[c]), coordinate, sums[d][c]);
            }
        }
    }
    sums
}

/// [`gather`] for several packets at once, to hide the latency of the additions.
#[inline(always)]
pub(crate) fn gather_group<S: Simd, const C: usize, const D: usize, const N: usize>(
    simd: S,
    packets: [&[[Lanes; C]]; N],
    local: &[[f64; D]],
) -> [[[S::f64s; C]; D]; N] {
    let mut sums = [[[simd.splat_f64s(0.0); C]; D]; N];
    let count = packets.iter().fold(local.len(), |count, packet| count.min(packet.len()));
    for k in 0..count {
        for d in 0..D {
            let coordinate = simd.splat_f64s(local[k][d]);
            for n in 0..N {
                for c in 0..C {
                    sums[n][d][c] = multiply_add(simd, load::<S>(&packets[n][k][c]), coordinate, sums[n][d][c]);
                }
            }
        }
    }
    sums
}

/// Adds coefficient_k · values of several packets to the sum of each handle, lane by lane and packet after packet.
#[inline(always)]
pub(crate) fn scatter_group<S: Simd, const C: usize, const D: usize, const N: usize>(
    simd: S,
    packets: [&[[Lanes; C]]; N],
    values: &[[[S::f64s; C]; D]; N],
    sums: &mut [[Lanes; D]],
) {
    let count = packets.iter().fold(sums.len(), |count, packet| count.min(packet.len()));
    for (k, sum) in sums[..count].iter_mut().enumerate() {
        for d in 0..D {
            let slot = &mut S::as_mut_simd_f64s(&mut sum[d]).0[0];
            let mut total = *slot;
            for n in 0..N {
                for c in 0..C {
                    total = multiply_add(simd, load::<S>(&packets[n][k][c]), values[n][d][c], total);
                }
            }
            *slot = total;
        }
    }
}

/// Adds the lane totals of a block's sums, multiplied by `scale`, to the right-hand side.
pub(crate) fn add_sums<const D: usize>(block: &Block, sums: &[[Lanes; D]], scale: f64, right_side: &mut [[f64; D]]) {
    for (&handle, sum) in block.handles.iter().zip(sums) {
        (0..D).for_each(|d| right_side[handle][d] += scale * sum[d].iter().sum::<f64>());
    }
}
