//! Bounds det J over a part of a cell, which need not fold where the cell does.
//!
//! In: a lattice, a cell, a part of the cell that can be halved. Out: a lower bound, by branch and bound as for whole cells,
//! without the halves that contain nothing of the part.

use super::folds::{MAX_HALVINGS, PRECISION};
use super::grid::Lattice;

/// Bisections after which a rest of the part counts as folded if its bound is not above 0.
const MAX_SIGN_HALVINGS: usize = MAX_HALVINGS + 6;

/// A part of a cell.
pub(crate) struct PartOfCell<P> {
    pub(crate) cell: usize,
    /// Number of handles that act at a coordinate.
    pub(crate) width: usize,
    pub(crate) part: P,
}

impl<const D: usize> Lattice<D> {
    /// Returns a lower bound of det J over a part of a cell; infinity if nothing is left of the part. The sign is exact to a
    /// 1024th of a cell in 2D, and the bound is as tight as that of a whole cell if the minimum may be less than `wanted`.
    /// `halve` returns the halves of a part along an axis, `None` for an empty one.
    pub(crate) fn min_in_part<P>(
        &self,
        PartOfCell { cell, width, part }: PartOfCell<P>,
        wanted: f64,
        halve: impl Fn(P, usize) -> [Option<P>; 2],
    ) -> f64 {
        let mut open = vec![(self.determinant(cell, width - 1), part, 0)];
        let mut least = f64::INFINITY;
        while let Some((patch, part, depth)) = open.pop() {
            let Some(bound) = patch.bound() else { return f64::NEG_INFINITY };
            if bound >= least {
                continue;
            }
            // Corners of the patch may lie outside the part.
            let most = patch.upper_bound();
            let is_near = most - bound <= PRECISION * most.abs().max(1.0) || bound >= wanted || depth >= MAX_HALVINGS;
            let has_sign = bound > 0.0 || most <= 0.0 || depth >= MAX_SIGN_HALVINGS;
            if is_near && has_sign {
                least = bound;
            } else {
                let halves = patch.halves(depth % D).into_iter().zip(halve(part, depth % D));
                open.extend(halves.filter_map(|(patch, part)| Some((patch, part?, depth + 1))));
            }
        }
        least
    }
}
