//! Nearest points along the shape.
//!
//! In: a [`BranchedLattice`], points of its shape. Out: for every piece the nearest of these points, or its distance from each
//! (E. W. Dijkstra, 1959, over connected pieces).

use super::{BranchedLattice, Branching};
use crate::solve::linalg::small_matrix::distance;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Adjacent pieces are connected if the copies that they share count as one to at least this degree.
pub(super) const MIN_CONNECTEDNESS: f64 = 0.5;

impl<const D: usize> BranchedLattice<D> {
    /// The index of the point that is nearest to each piece along the shape at rest, in the order of [`Self::pieces`]. A piece
    /// that is not connected with any of the points gets the nearest in space. A point may name the triangle of the shape on
    /// which it lies; a point beside the shape is replaced by the nearest point of the shape.
    ///
    /// # Panics
    /// If there are no points.
    #[must_use]
    pub(crate) fn nearest_along_shape(&self, points: &[([f64; D], Option<u32>)]) -> Vec<usize> {
        assert!(!points.is_empty(), "one of the points is the nearest");
        let branching = &self.branching;
        let middles = branching.middles();
        let snapped = branching.snapped(points);
        let nearest = branching.nearest_pieces(&middles, &snapped);
        let in_space = |middle: &[f64; D]| {
            let gaps = snapped.iter().enumerate().map(|(point, (at, _))| (distance(at, middle), point));
            gaps.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, point)| point)
        };
        let of_piece = |&piece: &usize| match nearest[piece] {
            (_, usize::MAX) => in_space(&middles[piece]),
            (_, point) => point,
        };
        branching.pieces.of_cuts.iter().map(of_piece).collect()
    }

    /// The distance of every piece from each of some points, along the shape at rest: one list per point, indexed by piece. Infinite
    /// where a piece is not connected with the point. Points are given as for [`Self::nearest_along_shape`].
    #[must_use]
    pub(crate) fn lengths_along_shape(&self, points: &[([f64; D], Option<u32>)]) -> Vec<Vec<f64>> {
        let middles = self.branching.middles();
        let lengths = |source| {
            let found = self.branching.nearest_pieces(&middles, std::slice::from_ref(source));
            found.into_iter().map(|(length, _)| length).collect()
        };
        self.branching.snapped(points).iter().map(lengths).collect()
    }
}

impl<const D: usize> Branching<D> {
    /// The centre of every piece.
    fn middles(&self) -> Vec<[f64; D]> {
        let mut sums = vec![([0.0; D], 0.0); self.pieces.list.len()];
        for (cut, &piece) in self.cuts.iter().zip(&self.pieces.of_cuts) {
            let (sum, area) = &mut sums[piece];
            let middle = cut.middle();
            (0..D).for_each(|d| sum[d] += cut.area * middle[d]);
            *area += cut.area;
        }
        sums.into_iter().map(|(sum, area)| sum.map(|x| x / area)).collect()
    }

    /// Places points on the shape, each with its piece.
    fn snapped(&self, points: &[([f64; D], Option<u32>)]) -> Vec<([f64; D], usize)> {
        points.iter().map(|&(at, triangle)| self.snapped_point(at, triangle)).collect()
    }

    /// The distance of every piece from the nearest of some points, and the index of that point; infinite and `usize::MAX` where a piece
    /// is not connected with any. `sources`: points of the shape, each with its piece.
    fn nearest_pieces(&self, middles: &[[f64; D]], sources: &[([f64; D], usize)]) -> Vec<(f64, usize)> {
        let mut nearest = vec![(f64::INFINITY, usize::MAX); middles.len()];
        let mut waiting = BinaryHeap::new();
        // The bit patterns of non-negative numbers have the order of the numbers.
        let entry = |length: f64, point: usize, piece: usize| Reverse((length.to_bits(), point, piece));
        for (point, (at, piece)) in sources.iter().enumerate() {
            waiting.push(entry(distance(at, &middles[*piece]), point, *piece));
        }
        while let Some(Reverse((length, point, piece))) = waiting.pop() {
            let length = f64::from_bits(length);
            if nearest[piece].1 != usize::MAX {
                continue;
            }
            nearest[piece] = (length, point);
            for &(next, degree) in &self.pieces.adjacent_pieces[piece] {
                if nearest[next].1 == usize::MAX && degree >= MIN_CONNECTEDNESS {
                    waiting.push(entry(length + distance(&middles[piece], &middles[next]), point, next));
                }
            }
        }
        nearest
    }
}
