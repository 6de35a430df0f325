//! Weights of rows over copies: the rows that replace one row of a plain lattice share its weight.
//!
//! In: rows by their copies, with the area of the shape on which they act. Out: their weights. The weights of rows over pieces
//! that have just split add up to the weight of the row before; rows over separate pieces have full weight each; rows over very
//! small areas fade out. The energy is therefore continuous while pieces split, join, appear and vanish.

use super::Branching;
use super::copies::coupling_degree;
use crate::solve::counting_sort::counting_sort_then_by;

/// Smallest relative weight of a row, however small its area, so that its copies are determined.
const MIN_SHARE: f64 = 1e-3;

/// Largest number of handles in a second difference.
const MAX_HANDLES: usize = 4;

/// A row over copies that act on a common piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct CopiedRow {
    /// The row over handles that this one replaces.
    pub(super) row: usize,
    copies: [usize; MAX_HANDLES],
    count: usize,
    /// Area of the shape on which the row acts.
    area: f64,
    /// Connectedness of the pieces with a pin, 0 to 1.
    pub(super) near: f64,
}

impl CopiedRow {
    /// Creates a row.
    ///
    /// # Panics
    /// If there are more than four copies.
    pub(super) fn new(row: usize, copies: impl Iterator<Item = usize>, [area, near]: [f64; 2]) -> Self {
        let mut copied = Self { row, copies: [0; MAX_HANDLES], count: 0, area, near };
        for copy in copies {
            copied.copies[copied.count] = copy;
            copied.count += 1;
        }
        copied
    }

    pub(super) fn copies(&self) -> &[usize] {
        &self.copies[..self.count]
    }
}

impl<const D: usize> Branching<D> {
    /// Joins rows over the same copies, and returns each with its weight relative to the row of a plain lattice. `count`: number of
    /// rows over handles.
    pub(super) fn shares(&self, mut rows: Vec<CopiedRow>, count: usize) -> Vec<(CopiedRow, f64)> {
        counting_sort_then_by(&mut rows, count, |row| row.row, |a, b| a.copies.cmp(&b.copies));
        rows.dedup_by(|next, kept| {
            let is_same = next.row == kept.row && next.copies == kept.copies;
            if is_same {
                (kept.area, kept.near) = (kept.area + next.area, kept.near.max(next.near));
            }
            is_same
        });
        let mut weighed = Vec::with_capacity(rows.len());
        for same in rows.chunk_by(|a, b| a.row == b.row) {
            weighed.extend(same.iter().map(|row| {
                let coupling = |other: &CopiedRow| {
                    self.coupling_degree(row.copies().iter().zip(other.copies()).map(|(&one, &other)| [one, other]))
                };
                let together: f64 = same.iter().map(|other| other.area * coupling(other)).sum();
                let fill = (together / self.full_area()).clamp(MIN_SHARE, 1.0);
                (*row, if together > 0.0 { (fill * row.area / together).max(MIN_SHARE) } else { fill })
            }));
        }
        weighed
    }

    /// The degree to which pairs of copies count as one.
    pub(super) fn coupling_degree(&self, pairs: impl Iterator<Item = [usize; 2]>) -> f64 {
        coupling_degree(&self.ties, pairs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::branching::BranchedLattice;
    use crate::solve::problem::Shape;

    #[test]
    fn rows_over_the_same_copies_are_one_and_rows_that_are_apart_weigh_a_whole_each() {
        let grid = Grid { dims: [5, 5], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
        let square = |left: f64| [[left, 0.1], [left + 0.4, 0.1], [left + 0.4, 0.9], [left, 0.9]];
        let points = [0.05, 0.55].into_iter().flat_map(square).collect();
        let triangles = [0, 4].into_iter().flat_map(|k| [[k, k + 1, k + 2], [k, k + 2, k + 3]]).collect();
        let shape = Shape::of_triangles(points, triangles).linked(0.0);
        let lattice = BranchedLattice::at_rest(&grid, &shape).expect("a right shape");
        let handles = &lattice.branching.handles;
        let copy =
            handles.windows(2).position(|pair| pair[0] == pair[1]).expect("the squares have copies of their own");
        let row = |copy: usize, area: f64| CopiedRow::new(0, [copy].into_iter(), [area, area]);
        let shares = lattice.branching.shares(vec![row(copy + 1, 0.3), row(copy, 0.2), row(copy + 1, 0.1)], 1);
        let found: Vec<_> = shares.iter().map(|(row, share)| (row.copies().to_vec(), row.near, *share)).collect();
        assert_eq!(found, [(vec![copy], 0.2, 1.0), (vec![copy + 1], 0.3, 1.0)]);
    }
}
