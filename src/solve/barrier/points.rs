//! Sample points of the barrier: energy and derivatives.
//!
//! In: a grid, cells, and the number of points per axis in each. Out: the mean over all cells of the mean potential over their
//! points. Cells with more than the usual number of points weigh more.

use super::curvature::{cofactors, eigen_pairs};
use super::potential::{ACTIVATION_DET, potential};
use crate::lattice::{Grid, Support};
use crate::solve::blocked_weights::BlockedWeights;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::simd::{LANES, Lanes, lane_of};
use crate::solve::linalg::small_matrix::{SquareMatrix, determinant};
use std::collections::BTreeMap;

/// Points per axis in a cell, in 2D and 3D.
pub(super) const FINE: [usize; 2] = [10, 6];

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
                    None => points = Some(Self { weights, shares }),
                    Some(points) => {
                        points.weights.append(weights);
                        points.shares.extend(shares);
                    }
                }
            }
        }
        points.unwrap_or_else(|| Self { weights: in_cells(grid, &[], 1, cancel), shares: Vec::new() })
    }

    /// Largest difference between handle indices that share a matrix entry.
    pub(super) fn bandwidth(&self) -> usize {
        self.weights.bandwidth()
    }

    /// Smallest det J at all points; −∞ where one is NaN.
    pub(super) fn min_det(&self, handles: &[[f64; D]]) -> f64 {
        let gradients = self.gradients_at(handles);
        let mut least = f64::INFINITY;
        self.for_each_point(|[_, packet, lane]| {
            let det = determinant(&lane_of(&gradients[packet], lane));
            least = if det >= least { least } else { det };
        });
        if least.is_nan() { f64::NEG_INFINITY } else { least }
    }

    /// Returns the points where det J is below [`ACTIVATION_DET`].
    pub(super) fn penalised_points(&self, handles: &[[f64; D]]) -> Vec<PenalisedPoint<D>> {
        let gradients = self.gradients_at(handles);
        let mut penalised = Vec::new();
        self.for_each_point(|place| {
            let gradient = lane_of(&gradients[place[1]], place[2]);
            let det = determinant(&gradient);
            // A NaN is also penalised.
            let is_clear = det >= ACTIVATION_DET;
            if !is_clear {
                penalised.push(PenalisedPoint { place, gradient, det });
            }
        });
        penalised
    }

    /// Returns the mean potential and the penalised points.
    pub(super) fn energy(&self, handles: &[[f64; D]]) -> (f64, Vec<PenalisedPoint<D>>) {
        let penalised = self.penalised_points(handles);
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
        let mut row: Vec<(usize, f64)> = Vec::new();
        for point in penalised {
            let [_, slope, bend] = potential(point.det);
            for (value, along) in eigen_pairs(&point.gradient, [slope, bend], is_convex) {
                row.clear();
                for (handle, gradient) in self.row(point) {
                    row.extend(
                        (0..D)
                            .map(|d| (D * handle + d, (0..D).map(|axis| along[d][axis] * gradient[axis]).sum::<f64>())),
                    );
                }
                normal.add_row(0.5 * scale * self.shares[point.place[0]] * value, &row);
            }
        }
    }

    /// Handles that act on a point, with their ∇W.
    fn row(&self, point: &PenalisedPoint<D>) -> impl Iterator<Item = (usize, [f64; D])> {
        let [block, packet, lane] = point.place;
        let block = &self.weights.blocks[block];
        let coefficients = self.weights.packet(block, packet);
        block.handles.iter().zip(coefficients).map(move |(&handle, lanes)| (handle, lanes.map(|x| x[lane])))
    }

    /// Calls `visit` with the block, packet and lane of every point.
    pub(super) fn for_each_point(&self, mut visit: impl FnMut([usize; 3])) {
        for (number, block) in self.weights.blocks.iter().enumerate() {
            for packet in block.packets.clone() {
                let lanes = (0..LANES).filter(|&lane| self.weights.order[packet][lane] != usize::MAX);
                lanes.for_each(|lane| visit([number, packet, lane]));
            }
        }
    }

    /// J at all points, packet by packet, as [row][column][lane].
    pub(super) fn gradients_at(&self, handles: &[[f64; D]]) -> Vec<[[Lanes; D]; D]> {
        self.weights.gradients_at(handles)
    }
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
