//! Weights of rows over copies: the rows that replace one row of a plain lattice share its weight.
//!
//! In: rows by their copies, with the area of the shape on which they act. Out: their weights. The weights of rows over pieces
//! that have just split add up to the weight of the row before; rows over separate pieces have full weight each; rows over very
//! small areas fade out. The energy is therefore continuous while pieces split, join, appear and vanish.

use super::Branching;
use std::collections::BTreeMap;

/// Smallest relative weight of a row, however small its area, so that its copies are determined.
const MIN_SHARE: f64 = 1e-3;

/// The growth of a support at which two copies count about half as one.
const HALF_APART: f64 = 0.1;

impl<const D: usize> Branching<D> {
    /// The weight of each row relative to the row of a plain lattice. `areas` maps the copies of a row to the area on which it
    /// acts.
    pub(super) fn shares(&self, areas: BTreeMap<Vec<usize>, f64>) -> Vec<(Vec<usize>, f64)> {
        let handles = |copies: &[usize]| copies.iter().map(|&copy| self.handles[copy]).collect::<Vec<_>>();
        let mut same: BTreeMap<Vec<usize>, Vec<(Vec<usize>, f64)>> = BTreeMap::new();
        for (copies, area) in areas {
            same.entry(handles(&copies)).or_default().push((copies, area));
        }
        let weighed = same.into_values().flat_map(|rows| {
            let share = |(copies, area): &(Vec<usize>, f64)| {
                let coupling_degree = |others: &[usize]| {
                    let pairs: Vec<_> = copies.iter().zip(others).map(|(&one, &other)| [one, other]).collect();
                    self.coupling_degree(&pairs)
                };
                let together: f64 = rows.iter().map(|(others, area)| area * coupling_degree(others)).sum();
                let fill = (together / self.full_area()).clamp(MIN_SHARE, 1.0);
                if together > 0.0 { (fill * area / together).max(MIN_SHARE) } else { fill }
            };
            let shares: Vec<f64> = rows.iter().map(share).collect();
            rows.into_iter().zip(shares).map(|((copies, _), share)| (copies, share))
        });
        weighed.collect()
    }

    /// The degree to which pairs of copies count as one: 1 if they are equal or have just split, 0 if the pieces of some pair are
    /// a span apart.
    pub(super) fn coupling_degree(&self, pairs: &[[usize; 2]]) -> f64 {
        let growth = |&[one, other]: &[usize; 2]| {
            let copies = [one.min(other), one.max(other)];
            let tie = || self.ties.binary_search_by_key(&copies, |tie| tie.copies);
            if one == other { 0.0 } else { tie().map_or(1.0, |place| self.ties[place].growth) }
        };
        let growth = pairs.iter().map(growth).fold(0.0, f64::max).min(1.0);
        let near = (1.0 - growth).powi(2);
        near / (near + (growth / HALF_APART).powi(2))
    }
}
