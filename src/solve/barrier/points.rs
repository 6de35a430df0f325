//! Sample points of the barrier: energy and derivatives.
//!
//! In: a grid, cells, and the number of points per axis in each. Out: the mean over all cells of the mean potential over their
//! points. Cells with more than the usual number of points weigh more.

use super::curvature::{cofactors, eigen_pairs};
use super::hull::DifferenceHull;
use super::potential::{ACTIVATION_DET, potential};
use crate::lattice::{Grid, Support};
use crate::simd::dispatch;
use crate::solve::blocked_weights::BlockedWeights;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::gram_matrix::{GramMatrix, Sum};
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::simd::{Lanes, lane_of};
use crate::solve::linalg::small_matrix::{SquareMatrix, determinant};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Points per axis in a cell, in 2D and 3D.
pub(super) const FINE: [usize; 2] = [10, 6];

/// Signs of eigenvalues.
const SIGNS: [f64; 2] = [1.0, -1.0];

/// Number of blocks whose curvature is computed in parallel.
const ROUND: usize = 16;

/// The cells that one part of the barrier covers, and the unknown of each handle there. `None`: handles are the unknowns
/// themselves.
#[derive(Clone, Debug)]
pub(crate) struct BarrierPart {
    pub(crate) cells: Vec<usize>,
    pub(crate) unknowns: Option<Vec<Option<usize>>>,
}

/// Index of a part, and of a cell of the grid.
pub(super) type CellOfPart = [usize; 2];

/// Sample points of a set of cells.
#[derive(Clone, Debug)]
pub(super) struct BarrierPoints<const D: usize> {
    /// Rows of ∇W at the points.
    weights: BlockedWeights<D>,
    /// Weight of a point in the energy, per block.
    shares: Vec<f64>,
    /// Bounds of det J per block; `None` where the basis has none.
    hull: Option<DifferenceHull<D>>,
}

/// A point where det J is below [`ACTIVATION_DET`].
pub(super) struct PenalisedPoint<const D: usize> {
    /// Block, packet and lane of the point.
    place: [usize; 3],
    gradient: SquareMatrix<D>,
    det: f64,
}

impl<const D: usize> BarrierPoints<D> {
    /// Places evenly spaced points in the cells, `side` of them per axis.
    pub(super) fn new(
        grid: &Grid<D>,
        parts: &[BarrierPart],
        side: impl Fn(CellOfPart) -> usize,
        cancel: &Cancel,
    ) -> Self {
        let count: usize = parts.iter().map(|part| part.cells.len()).sum();
        let mut points: Option<Self> = None;
        for (number, part) in parts.iter().enumerate() {
            let mut by_side: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
            part.cells.iter().for_each(|&cell| by_side.entry(side([number, cell])).or_default().push(cell));
            for (side, cells) in by_side {
                let mut weights = in_cells(grid, &cells, side, cancel);
                if let Some(unknowns) = &part.unknowns {
                    // Every handle that acts on a cell of a branch has a copy there, so the default is not used.
                    weights.relabel(|handle| unknowns[handle].unwrap_or(0));
                }
                // Refined cells keep the weight per point, so their barrier is stronger.
                let share = 1.0 / (count * FINE[usize::from(D > 2)].min(side).pow(D as u32)) as f64;
                let shares = weights.blocks.iter().map(|block| {
                    // Every point has the same weight, whether its block holds part of a cell, one cell or several.
                    if block.packets.is_empty() { 0.0 } else { share }
                });
                let shares: Vec<f64> = shares.collect();
                match &mut points {
                    None => points = Some(Self { weights, shares, hull: DifferenceHull::new(grid) }),
                    Some(points) => {
                        points.weights.append(weights);
                        points.shares.extend(shares);
                    }
                }
            }
        }
        points.unwrap_or_else(|| Self { weights: in_cells(grid, &[], 1, cancel), shares: Vec::new(), hull: None })
    }

    /// Largest difference between handle indices that share a matrix entry.
    pub(super) fn bandwidth(&self) -> usize {
        self.weights.bandwidth()
    }

    /// Smallest det J at the points of all cells, at most `wanted`; −∞ where one is NaN.
    pub(super) fn min_det(&self, handles: &[[f64; D]], wanted: f64) -> f64 {
        let low = self.points_below(handles, wanted);
        low.iter()
            .fold(wanted, |least, point| if point.det.is_nan() { f64::NEG_INFINITY } else { least.min(point.det) })
    }

    /// Returns the mean potential, and the points where det J is below [`ACTIVATION_DET`].
    pub(super) fn energy(&self, handles: &[[f64; D]]) -> (f64, Vec<PenalisedPoint<D>>) {
        let penalised = self.points_below(handles, ACTIVATION_DET);
        let sum: f64 = penalised.iter().map(|point| self.shares[point.place[0]] * potential(point.det)[0]).sum();
        (sum, penalised)
    }

    /// Subtracts `scale` times half the derivative of the energy from `right_side`.
    pub(super) fn subtract_derivative(&self, scale: f64, penalised: &[PenalisedPoint<D>], right_side: &mut [[f64; D]]) {
        for point in penalised {
            let factor = -0.5 * scale * self.shares[point.place[0]] * potential(point.det)[1];
            let by = cofactors(&point.gradient).map(|row| row.map(|x| factor * x));
            for (handle, slope) in self.row(point) {
                for (slot, row) in right_side[handle].iter_mut().zip(&by) {
                    *slot += (0..D).map(|axis| row[axis] * slope[axis]).sum::<f64>();
                }
            }
        }
    }

    /// Adds `scale` times half the second derivative of the energy to the matrix of all coordinates (row D·handle + coordinate).
    pub(super) fn add_curvature(
        &self,
        scale: f64,
        penalised: &[PenalisedPoint<D>],
        is_convex: bool,
        normal: &mut NormalMatrix,
    ) {
        // The points of a block share its handles.
        let of_blocks: Vec<&[PenalisedPoint<D>]> = penalised.chunk_by(|a, b| a.place[0] == b.place[0]).collect();
        for round in of_blocks.chunks(ROUND) {
            let of_block = |points: &&[PenalisedPoint<D>]| self.curvature_of_block(points, is_convex);
            let curvatures: Vec<_> = round.par_iter().map(of_block).collect();
            for (points, (rows, by_sign)) in round.iter().zip(curvatures) {
                let factor = 0.5 * scale * self.shares[points[0].place[0]];
                for (sign, gram) in SIGNS.into_iter().zip(by_sign).filter(|(_, gram)| !gram.is_empty()) {
                    normal.add_gram(sign * factor, &rows, &gram);
                }
            }
        }
    }

    /// Returns the coordinates of the handles of a block, ascending, and the sums over its points of the outer products of the
    /// eigenvectors there, weighted by the magnitude of their eigenvalues, for each of [`SIGNS`].
    fn curvature_of_block(&self, points: &[PenalisedPoint<D>], is_convex: bool) -> (Vec<usize>, [GramMatrix; 2]) {
        let handles = &self.weights.blocks[points[0].place[0]].handles;
        let mut order: Vec<usize> = (0..handles.len()).collect();
        order.sort_unstable_by_key(|&number| handles[number]);
        let rows: Vec<usize> = order.iter().flat_map(|&number| (0..D).map(move |d| D * handles[number] + d)).collect();
        let mut by_sign = [GramMatrix::default(), GramMatrix::default()];
        by_sign.iter_mut().for_each(|gram| gram.clear(rows.len()));
        for point in points {
            let [block, packet, lane] = point.place;
            let coefficients = self.weights.packet(&self.weights.blocks[block], packet);
            let [_, slope, bend] = potential(point.det);
            for (value, along) in eigen_pairs(&point.gradient, [slope, bend], is_convex) {
                let along = along.map(|row| row.map(|x| value.abs().sqrt() * x));
                let row = by_sign[usize::from(value < 0.0)].push();
                for (slots, &number) in row.as_chunks_mut::<D>().0.iter_mut().zip(&order) {
                    let gradient = coefficients[number].map(|lanes| lanes[lane]);
                    *slots = along.map(|row| row.iter().zip(&gradient).map(|(x, y)| x * y).sum());
                }
            }
        }
        by_sign.iter_mut().filter(|gram| !gram.is_empty()).for_each(|gram| dispatch(Sum(gram)));
        (rows, by_sign)
    }

    /// Handles that act on a point, with their ∇W.
    fn row(&self, point: &PenalisedPoint<D>) -> impl Iterator<Item = (usize, [f64; D])> {
        let [block, packet, lane] = point.place;
        let block = &self.weights.blocks[block];
        let coefficients = self.weights.packet(block, packet);
        block.handles.iter().zip(coefficients).map(move |(&handle, lanes)| (handle, lanes.map(|x| x[lane])))
    }

    /// Blocks in which det J may be below `least`.
    fn open(&self, handles: &[[f64; D]], least: f64) -> Vec<usize> {
        self.blocks_below(least, |hull| hull.bounds(self.cells(), handles))
    }

    /// Blocks in which det J may be at or below `least` on the straight way between two states.
    pub(super) fn open_between(&self, ends: [&[[f64; D]]; 2], least: f64) -> Vec<usize> {
        self.blocks_below(least, |hull| hull.bounds_between(self.cells(), ends))
    }

    fn blocks_below(&self, least: f64, bounds: impl Fn(&DifferenceHull<D>) -> Vec<f64>) -> Vec<usize> {
        match &self.hull {
            Some(hull) => (0..)
                .zip(bounds(hull))
                .filter_map(|(block, bound)| (bound.is_nan() || bound <= least).then_some(block))
                .collect(),
            None => (0..self.weights.blocks.len()).collect(),
        }
    }

    /// Handles of all blocks.
    fn cells(&self) -> impl Iterator<Item = &[usize]> + Clone {
        self.weights.blocks.iter().map(|block| &block.handles[..])
    }

    /// Returns the points where det J is below `least`, or NaN.
    fn points_below(&self, handles: &[[f64; D]], least: f64) -> Vec<PenalisedPoint<D>> {
        let open = self.open(handles, least);
        let mut low = Vec::new();
        for ([block, packet], gradients) in self.packets_of(&open).zip(self.gradients_in(&open, handles)) {
            for (lane, det) in determinants(&gradients).into_iter().enumerate() {
                let is_above = det >= least;
                if !is_above && self.weights.order[packet][lane] != usize::MAX {
                    low.push(PenalisedPoint { place: [block, packet, lane], gradient: lane_of(&gradients, lane), det });
                }
            }
        }
        low
    }

    /// Blocks and packets of all points of some blocks.
    fn packets_of(&self, blocks: &[usize]) -> impl Iterator<Item = [usize; 2]> {
        blocks.iter().flat_map(|&block| self.weights.blocks[block].packets.clone().map(move |packet| [block, packet]))
    }

    /// J at all points of some blocks, packet by packet, as [row][column][lane]; 0 in unused lanes.
    pub(super) fn gradients_in(&self, blocks: &[usize], handles: &[[f64; D]]) -> Vec<[[Lanes; D]; D]> {
        self.weights.gradients_in(blocks, handles)
    }
}

/// Determinants of the matrices in four lanes.
pub(super) fn determinants<const D: usize>(m: &[[Lanes; D]; D]) -> Lanes {
    if D == 2 {
        let [a, b, c, d] = [m[0][0], m[0][1], m[1][0], m[1][1]];
        return std::array::from_fn(|lane| a[lane] * d[lane] - b[lane] * c[lane]);
    }
    std::array::from_fn(|lane| determinant(&lane_of(m, lane)))
}

/// Distance in spans by which points on the border of a cell are moved inside, so that they depend on the handles of that cell.
const INSIDE: f64 = 1e-6;

/// Returns ∇W at evenly spaced points of the cells. The points include the borders, because det J falls steeply beside inactive
/// cells.
fn in_cells<const D: usize>(grid: &Grid<D>, cells: &[usize], side: usize, cancel: &Cancel) -> BlockedWeights<D> {
    let place = |number: usize| -> [f64; D] {
        let even = |axis: usize| (number / side.pow(axis as u32) % side) as f64 / side.max(2).saturating_sub(1) as f64;
        std::array::from_fn(|axis| even(axis).clamp(INSIDE, 1.0 - INSIDE))
    };
    let places: Vec<[f64; D]> = (0..side.pow(D as u32)).map(place).collect();
    if matches!(grid.basis.support(), Support::Tensor { .. }) {
        return BlockedWeights::in_cells(grid, cells, &places, |_, gradient| *gradient, cancel);
    }
    let point = |corner: [usize; D], place: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|axis| grid.lo[axis] + (corner[axis] as f64 + place[axis]) * grid.spacing(axis))
    };
    let points: Vec<[f64; D]> = cells
        .iter()
        .map(|&cell| grid.cell_coords(cell))
        .flat_map(|corner| places.iter().map(move |place| point(corner, place)))
        .collect();
    BlockedWeights::new(grid, &points, |_, gradient| *gradient, cancel)
}
