//! Nearest points along the shape.
//!
//! In: a [`BranchedLattice`], points of its shape. Out: for every piece the nearest of these points (E. W. Dijkstra, 1959, with
//! all points as sources, over connected pieces).

use super::BranchedLattice;
use crate::solve::linalg::small_matrix::distance;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Adjacent pieces are connected if the copies that they share count as one to at least this degree.
const MIN_CONNECTEDNESS: f64 = 0.5;

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
        let mut sums = vec![([0.0; D], 0.0); branching.pieces.list.len()];
        for (cut, &piece) in branching.cuts.iter().zip(&branching.pieces.of_cuts) {
            let (sum, area) = &mut sums[piece];
            let middle = cut.middle();
            (0..D).for_each(|d| sum[d] += cut.area * middle[d]);
            *area += cut.area;
        }
        let middles: Vec<[f64; D]> = sums.into_iter().map(|(sum, area)| sum.map(|x| x / area)).collect();
        let mut nearest = vec![(f64::INFINITY, usize::MAX); middles.len()];
        let mut waiting = BinaryHeap::new();
        // The bit patterns of non-negative numbers have the order of the numbers.
        let entry = |length: f64, point: usize, piece: usize| Reverse((length.to_bits(), point, piece));
        let snapped: Vec<([f64; D], usize)> =
            points.iter().map(|&(at, triangle)| branching.snapped_point(at, triangle)).collect();
        for (point, (at, piece)) in snapped.iter().enumerate() {
            waiting.push(entry(distance(at, &middles[*piece]), point, *piece));
        }
        while let Some(Reverse((length, point, piece))) = waiting.pop() {
            let length = f64::from_bits(length);
            if nearest[piece].1 != usize::MAX {
                continue;
            }
            nearest[piece] = (length, point);
            for &(next, degree) in &branching.pieces.adjacent_pieces[piece] {
                if nearest[next].1 == usize::MAX && degree >= MIN_CONNECTEDNESS {
                    waiting.push(entry(length + distance(&middles[piece], &middles[next]), point, next));
                }
            }
        }
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
}
