//! A solved branching lattice: one plain lattice per branch.
//!
//! In: a [`Branching`] and moved copies. Out: images of points of the shape, lattices to draw with.

use super::bending::{Bending, bending};
use super::continuation::continued;
use super::{Branching, checked_width};
use crate::lattice::{Grid, Lattice};
use crate::solve::error::SolveError;
use crate::solve::problem::{PointPin, Shape};
use crate::solve::upright::Upright;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// A solved lattice with branches, in the order of their largest pieces, from the largest one down.
#[derive(Clone, Debug)]
pub(crate) struct BranchedLattice<const D: usize> {
    pub(super) branching: Arc<Branching<D>>,
    /// Positions of the copies.
    copies: Vec<[f64; D]>,
}

impl<const D: usize> PartialEq for BranchedLattice<D> {
    /// Equal if the copies have the same positions over the same grid.
    fn eq(&self, other: &Self) -> bool {
        self.copies == other.copies
            && self.branching.grid == other.branching.grid
            && self.branching.handles == other.branching.handles
    }
}

impl<const D: usize> BranchedLattice<D> {
    pub(crate) fn new(branching: &Arc<Branching<D>>, copies: Vec<[f64; D]>) -> Self {
        Self { branching: Arc::clone(branching), copies }
    }

    /// The lattice at rest over a shape.
    ///
    /// # Errors
    /// [`SolveError::Invalid`] if the grid's basis or the shape does not support branching lattices.
    pub(crate) fn at_rest(grid: &Grid<D>, shape: &Shape<D>) -> Result<Self, SolveError> {
        let shape = Upright::of(grid).shape(shape);
        let branching = Branching::split(&grid.upright(), &shape, checked_width(grid, &shape)?);
        let branching = if grid.angle == 0.0 { branching } else { branching.rotated(grid) };
        let copies = branching.rest();
        Ok(Self::new(&Arc::new(branching), copies))
    }

    /// Moves this lattice by other lattices with as many handles, for instance those of another shape's branches: each copy of a
    /// handle takes the position of that handle in the lattice that covers most of the copy's piece. `holders` returns the
    /// indices of the lattices that cover a point of the shape at rest. Where several do, as where legs cross, the lattice is
    /// preferred that covers most of the piece and little else.
    ///
    /// # Panics
    /// If a holder is not the index of a lattice, or a lattice has too few handles.
    #[must_use]
    pub(crate) fn moved_by(&self, lattices: &[Lattice<D>], mut holders: impl FnMut([f64; D]) -> Vec<usize>) -> Self {
        let Branching { handles, cuts, pieces, .. } = self.branching.as_ref();
        // Lattices with the same position of a handle share a copy of it and are represented by the first of them.
        let first_in_place: Vec<Vec<usize>> = (0..self.branching.grid.handle_count())
            .map(|handle| {
                let mut firsts = BTreeMap::new();
                let place = |lattice: &Lattice<D>| lattice.handles[handle].map(f64::to_bits);
                lattices.iter().enumerate().map(|(k, lattice)| *firsts.entry(place(lattice)).or_insert(k)).collect()
            })
            .collect();
        // Area that a lattice covers of the piece of each copy, and of all pieces on which each handle acts.
        let mut of_copies = vec![BTreeMap::new(); handles.len()];
        let mut of_handles = vec![BTreeMap::new(); self.branching.grid.handle_count()];
        for (cut, &piece) in cuts.iter().zip(&pieces.of_cuts) {
            let holders = holders(cut.middle());
            for &copy in &pieces.list[piece].copies {
                let handle = handles[copy];
                let firsts: BTreeSet<usize> = holders.iter().map(|&holder| first_in_place[handle][holder]).collect();
                for first in firsts {
                    *of_copies[copy].entry(first).or_insert(0.0) += cut.area;
                    *of_handles[handle].entry(first).or_insert(0.0) += cut.area;
                }
            }
        }
        let place = |(areas, &handle): (&BTreeMap<usize, f64>, &usize)| {
            let likeness = |(holder, area): (&usize, &f64)| area * area / of_handles[handle][holder];
            // The first of equal ones.
            let best = areas.iter().rev().max_by(|a, b| likeness(*a).total_cmp(&likeness(*b)));
            lattices[best.map_or(0, |(holder, _)| *holder)].handles[handle]
        };
        let copies = of_copies.iter().zip(handles).map(place).collect();
        Self::new(&self.branching, copies)
    }

    /// Linear interpolation between lattices over the same pieces: 0 gives this lattice, 1 the other.
    ///
    /// # Panics
    /// If the other lattice has fewer copies.
    #[must_use]
    pub(crate) fn mixed(&self, other: &Self, share: f64) -> Self {
        let mix = |k: usize| std::array::from_fn(|d| self.copies[k][d] * (1.0 - share) + other.copies[k][d] * share);
        Self::new(&self.branching, (0..self.copies.len()).map(mix).collect())
    }

    /// Number of branches.
    #[must_use]
    pub(crate) fn branch_count(&self) -> usize {
        self.branching.branches.len()
    }

    /// The grid at rest.
    #[must_use]
    pub(crate) fn grid(&self) -> &Grid<D> {
        &self.branching.grid
    }

    /// Whether both have the same grid and the same shape at rest, and therefore the same branches.
    #[must_use]
    pub(crate) fn has_same_pieces(&self, other: &Self) -> bool {
        self.is_of(&other.branching)
    }

    /// The shape at rest as convex polygons, each inside one cell of the grid, with the branch of each.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = (usize, &[[f64; D]])> {
        let Branching { cuts, pieces, branch_of, .. } = self.branching.as_ref();
        cuts.iter().zip(&pieces.of_cuts).map(move |(cut, &piece)| (branch_of[piece], cut.polygon.corners()))
    }

    /// Same as [`Self::pieces`], with the index of the triangle that each polygon is a part of before its branch.
    pub(crate) fn pieces_of_triangles(&self) -> impl Iterator<Item = (usize, usize, &[[f64; D]])> {
        let triangles = self.branching.cuts.iter().map(|cut| cut.triangle);
        triangles.zip(self.pieces()).map(|(triangle, (branch, corners))| (triangle, branch, corners))
    }

    /// The branch of a point on a triangle of the shape.
    ///
    /// # Panics
    /// If the shape has no such triangle.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn branch_at(&self, triangle: usize, point: [f64; D]) -> usize {
        assert!(triangle < self.branching.triangles.len(), "the shape has no triangle {triangle}");
        self.branching.branch_at(triangle..triangle + 1, &point)
    }

    /// The lattice of a branch. Handles that do not act on the branch are at rest.
    #[must_use]
    pub(crate) fn lattice(&self, branch: usize) -> Lattice<D> {
        let Branching { grid, branches, .. } = self.branching.as_ref();
        let handles = branches[branch].iter().enumerate();
        let handles =
            handles.map(|(handle, copy)| copy.map_or_else(|| grid.rest_handle(handle), |copy| self.copies[copy]));
        Lattice { grid: grid.clone(), handles: handles.collect() }
    }

    /// The lattice of a branch. Handles that do not act on the branch are extrapolated with least second differences.
    #[must_use]
    pub(crate) fn extended_lattice(&self, branch: usize) -> Lattice<D> {
        continued(&self.branching.grid, &self.handles_of(branch))
    }

    /// Positions of the handles that act on a branch, #handles; `None` for the others.
    #[must_use]
    pub(crate) fn handles_of(&self, branch: usize) -> Vec<Option<[f64; D]>> {
        self.branching.branches[branch].iter().map(|copy| copy.map(|copy| self.copies[copy])).collect()
    }

    /// Positions of all copies, in the order of their handles.
    pub(crate) fn copies(&self) -> &[[f64; D]] {
        &self.copies
    }

    /// Whether this lattice has the same copies as a branching.
    pub(crate) fn is_of(&self, branching: &Arc<Branching<D>>) -> bool {
        let own = &self.branching;
        Arc::ptr_eq(own, branching) || own.grid == branching.grid && own.triangles == branching.triangles
    }

    /// Positions of the copies of a handle; empty if the handle acts on no part of the shape.
    #[must_use]
    pub(crate) fn copies_of(&self, handle: usize) -> &[[f64; D]] {
        let handles = &self.branching.handles;
        let first = handles.partition_point(|&own| own < handle);
        &self.copies[first..handles.partition_point(|&own| own <= handle)]
    }

    /// The cells that contain a part of a branch, as column and row.
    #[must_use]
    pub(crate) fn cells(&self, branch: usize) -> Vec<[usize; D]> {
        let Branching { grid, pieces, branch_of, .. } = self.branching.as_ref();
        let own = pieces.list.iter().zip(branch_of).filter(|(_, of)| **of == branch);
        own.map(|(piece, _)| grid.cell_coords(piece.cell)).collect()
    }

    /// The part of the shape at rest that belongs to each branch, as convex polygons: whole triangles, and parts of those that
    /// belong to several branches.
    #[must_use]
    pub(crate) fn regions(&self) -> Vec<Vec<Vec<[f64; D]>>> {
        let mut regions = vec![Vec::new(); self.branch_count()];
        let pieces: Vec<_> = self.pieces_of_triangles().collect();
        for own in pieces.chunk_by(|one, other| one.0 == other.0) {
            let (triangle, branch, _) = own[0];
            if own.iter().all(|piece| piece.1 == branch) {
                regions[branch].push(self.branching.triangles[triangle].to_vec());
            } else {
                own.iter().for_each(|&(_, branch, corners)| regions[branch].push(corners.to_vec()));
            }
        }
        regions
    }

    /// The image of a point on a triangle of the shape.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn evaluate(&self, triangle: usize, point: [f64; D]) -> [f64; D] {
        self.evaluate_in(self.branch_at(triangle, point), point)
    }

    /// The branch of a point on one of a range of triangles of the shape.
    ///
    /// # Panics
    /// If the range is empty, or extends beyond the triangles of the shape.
    #[must_use]
    pub(crate) fn branch_within(&self, triangles: Range<usize>, point: [f64; D]) -> usize {
        assert!(triangles.start < triangles.end && triangles.end <= self.branching.triangles.len(), "{triangles:?}");
        self.branching.branch_at(triangles, &point)
    }

    /// The image of a point on one of a range of triangles of the shape. A point outside the box has the displacement of the
    /// nearest box point.
    ///
    /// # Panics
    /// If the range is empty, or extends beyond the triangles of the shape.
    #[must_use]
    pub(crate) fn warp(&self, triangles: Range<usize>, point: [f64; D]) -> [f64; D] {
        self.evaluate_in(self.branch_within(triangles, point), point)
    }

    /// Scales the displacement of every copy; a share of 0 gives the lattice at rest.
    #[must_use]
    pub(crate) fn faded(&self, share: f64) -> Self {
        let rest = self.branching.rest();
        let faded = self
            .copies
            .iter()
            .zip(&rest)
            .map(|(copy, rest)| std::array::from_fn(|d| rest[d] + (copy[d] - rest[d]) * share));
        Self::new(&self.branching, faded.collect())
    }

    /// The image of a pin's point.
    #[must_use]
    pub(crate) fn pin_image(&self, pin: &PointPin<D>) -> [f64; D] {
        let (snapped, piece) = self.branching.snapped_pin(pin);
        let image = self.evaluate_in(self.branching.branch_of(piece), snapped.at);
        std::array::from_fn(|d| image[d] + pin.at[d] - snapped.at[d])
    }

    /// The image of a point of a branch. Rounding may assign a point at the border of a piece to a branch that lacks copies of
    /// some handles there: the other handles then displace it.
    pub(crate) fn evaluate_in(&self, branch: usize, point: [f64; D]) -> [f64; D] {
        let grid = &self.branching.grid;
        let copies = &self.branching.branches[branch];
        let inside = grid.clamp_to_box(point);
        let mut image: [f64; D] = std::array::from_fn(|d| point[d] - inside[d]);
        let mut is_whole = true;
        grid.for_each_weight(inside, |term| match copies[term.handle] {
            Some(copy) => (0..D).for_each(|d| image[d] += term.weight * self.copies[copy][d]),
            None => is_whole = false,
        });
        if is_whole {
            return image;
        }
        let (mut total, mut moved) = (0.0, [0.0; D]);
        grid.for_each_weight(inside, |term| {
            let Some(copy) = copies[term.handle] else { return };
            let rest = grid.rest_handle(term.handle);
            total += term.weight;
            (0..D).for_each(|d| moved[d] += term.weight * (self.copies[copy][d] - rest[d]));
        });
        if total > 0.0 { std::array::from_fn(|d| point[d] + moved[d] / total) } else { point }
    }
}

impl BranchedLattice<2> {
    /// How strongly each branch bends.
    #[must_use]
    pub(crate) fn bending(&self) -> Vec<Bending> {
        bending(&self.branching, |branch| self.lattice(branch))
    }
}
