//! The barrier: what keeps cells that hold some of the model from folding.
//!
//! In: a grid and its active cells. Out: an energy, the mean over the points of a fine grid in these cells of a potential that is 0
//! where det J ≥ 0.2; its derivatives; and minima of the whole energy in which every point has a positive determinant.
//! docs/METHOD.md, "Barrier", has what is guaranteed.

mod crossing;
mod curvature;
mod descent;
mod points;
mod potential;
mod reactions;

use super::cancel::Cancel;
use crate::lattice::{Grid, Lattice};
pub(crate) use points::BarrierPart;
use points::{BarrierPoints, CellOfPart, FINE};
use potential::CLEAR;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// Points of a cell along an axis, in the plane and in space: for a first look.
const ROUGH: [usize; 2] = [5, 3];

/// A rough look that is above this finds all that is clear.
const SURELY_CLEAR: f64 = 0.3;

/// The barrier of a lattice.
#[derive(Debug)]
pub(crate) struct Barrier<const D: usize> {
    grid: Grid<D>,
    parts: Vec<BarrierPart>,
    rough: BarrierPoints<D>,
    fine: OnceLock<BarrierPoints<D>>,
}

impl<const D: usize> Barrier<D> {
    /// Over some cells of a grid.
    pub(crate) fn new(grid: &Grid<D>, parts: Vec<BarrierPart>, cancel: &Cancel) -> Self {
        let rough = BarrierPoints::new(grid, &parts, |_| ROUGH[usize::from(D > 2)], cancel);
        Self { grid: grid.clone(), parts, rough, fine: OnceLock::new() }
    }

    /// Every point is clear: the barrier is 0, and so are its derivatives.
    pub(crate) fn is_clear(&self, handles: &[[f64; D]]) -> bool {
        let least = self.rough.least_det(handles);
        least >= SURELY_CLEAR || least >= CLEAR && self.points().least_det(handles) >= CLEAR
    }

    /// The least determinant of the first look.
    fn least_det(&self, handles: &[[f64; D]]) -> f64 {
        self.rough.least_det(handles)
    }

    /// The points of the barrier.
    fn points(&self) -> &BarrierPoints<D> {
        self.fine.get_or_init(|| self.refined(&BTreeMap::new()))
    }

    /// Points of which some cells have more.
    fn refined(&self, finer: &BTreeMap<CellOfPart, usize>) -> BarrierPoints<D> {
        let side = |cell: CellOfPart| finer.get(&cell).copied().unwrap_or(FINE[usize::from(D > 2)]);
        BarrierPoints::new(&self.grid, &self.parts, side, &Cancel::never())
    }

    /// The cells that fold, in proven bounds.
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
            let margin = self.grid.basis.margin();
            for place in (Lattice { grid: self.grid.clone(), handles }).folds(&is_active).cells {
                let cell = (0..D)
                    .rev()
                    .fold(0, |cell, axis| cell * self.grid.basis.spans(self.grid.dims[axis]) + place[axis] - margin);
                folded.extend(is_active[cell].then_some([number, cell]));
            }
        }
        folded
    }
}
