//! The barrier: an energy that keeps active cells from folding.
//!
//! In: a grid and its active cells. Out: the barrier energy, which is the mean, over a fine grid of points in these cells, of a
//! potential that is 0 where det J ≥ 0.2; its derivatives; and minima of the total energy in which det J is positive at every
//! point. docs/METHOD.md, "Barrier", states what is guaranteed.

mod crossing;
mod curvature;
mod descent;
mod hull;
mod minimum;
mod points;
mod potential;
mod reactions;

use super::cancel::Cancel;
use super::linalg::normal_matrix::NormalMatrix;
use crate::lattice::{Grid, Lattice};
pub(crate) use points::BarrierPart;
use points::{BarrierPoints, CellOfPart, FINE};
use potential::{ACTIVATION_DET, STRENGTH};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Points per axis in a cell, in 2D and 3D, for the coarse test.
const ROUGH: [usize; 2] = [5, 3];

/// A state whose coarse points all have at least this det J counts as clear without a test of the fine points.
const SURELY_CLEAR: f64 = 0.3;

/// Barrier of a lattice, with the coarse points and, once needed, the fine ones.
#[derive(Debug)]
pub(crate) struct Barrier<const D: usize> {
    grid: Grid<D>,
    parts: Vec<BarrierPart>,
    rough: BarrierPoints<D>,
    fine: OnceLock<BarrierPoints<D>>,
}

impl<const D: usize> Barrier<D> {
    /// Creates the barrier over the cells of `parts`.
    pub(crate) fn new(grid: &Grid<D>, parts: Vec<BarrierPart>, cancel: &Cancel) -> Self {
        let rough = BarrierPoints::new(grid, &parts, |_| ROUGH[usize::from(D > 2)], cancel);
        Self { grid: grid.clone(), parts, rough, fine: OnceLock::new() }
    }

    /// Whether det J ≥ 0.2 at every point, so that the barrier and its derivatives vanish.
    pub(crate) fn is_clear(&self, handles: &[[f64; D]]) -> bool {
        let least = self.rough.min_det(handles, SURELY_CLEAR);
        let is_clear = || self.points().min_det(handles, ACTIVATION_DET) >= ACTIVATION_DET;
        least >= SURELY_CLEAR || least >= ACTIVATION_DET && is_clear()
    }

    /// Largest difference between handle indices that share an entry of [`Self::add_curvature`].
    pub(crate) fn bandwidth(&self) -> usize {
        self.points().bandwidth()
    }

    /// Adds half the second derivative of the barrier's energy to the matrix of all coordinates (row D·handle + coordinate).
    /// `stiffness` is that of the shape, the unit of the energy.
    pub(crate) fn add_curvature(&self, handles: &[[f64; D]], stiffness: f64, normal: &mut NormalMatrix) {
        let (_, penalised) = self.points().energy(handles);
        self.points().add_curvature(STRENGTH * stiffness, &penalised, false, normal);
    }

    /// Smallest det J at the coarse points, at most 0.2.
    fn min_det(&self, handles: &[[f64; D]]) -> f64 {
        self.rough.min_det(handles, ACTIVATION_DET)
    }

    /// Fine points; built at the first call.
    fn points(&self) -> &BarrierPoints<D> {
        self.fine.get_or_init(|| self.refined(&BTreeMap::new()))
    }

    /// Returns fine points, with the number per axis given by `finer` in the cells listed there.
    fn refined(&self, finer: &BTreeMap<CellOfPart, usize>) -> BarrierPoints<D> {
        let side = |cell: CellOfPart| finer.get(&cell).copied().unwrap_or(FINE[usize::from(D > 2)]);
        BarrierPoints::new(&self.grid, &self.parts, side, &Cancel::never())
    }

    /// Returns the cells in which det J ≤ 0 somewhere, by proven bounds instead of samples.
    fn folded(&self, unknowns: &[[f64; D]]) -> Vec<CellOfPart> {
        let mut folded = Vec::new();
        for (number, part) in self.parts.iter().enumerate() {
            let handles = match &part.unknowns {
                None => unknowns.to_vec(),
                Some(of) => {
                    let of = of.iter().enumerate();
                    of.map(|(handle, of)| of.map_or_else(|| self.grid.rest_handle(handle), |of| unknowns[of])).collect()
                }
            };
            let mut is_active = vec![false; self.grid.cell_count()];
            part.cells.iter().for_each(|&cell| is_active[cell] = true);
            for place in (Lattice { grid: self.grid.clone(), handles }).active_folds(&is_active, 0.0).cells {
                let cell = self.grid.cell_between_handles(&place);
                folded.extend(is_active[cell].then_some([number, cell]));
            }
        }
        folded
    }
}
