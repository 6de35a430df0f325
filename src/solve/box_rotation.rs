//! Solutions over a rotated box.
//!
//! In: solutions over the upright box (see [`super::upright`]). Out: the same, rotated with the box.

use super::branching::{BranchedLattice, Branching};
use super::report::Solution;
use super::upright::Upright;
use crate::lattice::{Grid, Lattice};
use std::sync::Arc;

/// Rotates upright solutions with the box of a grid.
#[derive(Debug)]
pub(crate) struct BoxRotation<const D: usize> {
    grid: Grid<D>,
    /// The branching over the rotated grid; `None` if the lattice does not branch, or the box is upright.
    branching: Option<Arc<Branching<D>>>,
}

impl<const D: usize> BoxRotation<D> {
    /// `branching`: that of the upright grid.
    pub(crate) fn new(grid: &Grid<D>, branching: Option<&Branching<D>>) -> Self {
        let branching = branching.filter(|_| grid.angle != 0.0).map(|branching| Arc::new(branching.rotated(grid)));
        Self { grid: grid.clone(), branching }
    }

    /// The rotation back.
    pub(crate) const fn upright(&self) -> Upright<'_, D> {
        Upright::of(&self.grid)
    }

    /// Whether branches have the same copies of handles over the same shape.
    pub(crate) fn has_pieces_of(&self, branches: &BranchedLattice<D>) -> bool {
        self.branching.as_ref().is_some_and(|own| branches.is_of(own))
    }

    /// Positions of upright handles or copies of handles.
    fn points(&self, points: &[[f64; D]]) -> Vec<[f64; D]> {
        points.iter().map(|&point| self.grid.point_from_upright(point)).collect()
    }

    /// A lattice.
    pub(crate) fn lattice(&self, upright: Lattice<D>) -> Lattice<D> {
        if self.grid.angle == 0.0 {
            return upright;
        }
        Lattice { grid: self.grid.clone(), handles: self.points(&upright.handles) }
    }

    /// Branches.
    pub(crate) fn branches(&self, upright: BranchedLattice<D>) -> BranchedLattice<D> {
        match &self.branching {
            Some(branching) => BranchedLattice::new(branching, self.points(upright.copies())),
            None => upright,
        }
    }

    /// A solution. Its report holds no directions.
    pub(crate) fn solution(&self, upright: Solution<D>) -> Solution<D> {
        let Solution { lattice, branches, report } = upright;
        Solution { lattice: self.lattice(lattice), branches: branches.map(|one| self.branches(one)), report }
    }
}
