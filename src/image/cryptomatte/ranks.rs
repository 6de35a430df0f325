//! Accumulates the coverage per id in one pixel.
//!
//! In: samples, or ranks of other pixels, with weights. Out: ranks in order of decreasing coverage.

use super::MatteId;

/// Coverage per id of a pixel. Reused from pixel to pixel to avoid allocations.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct IdCoverage {
    shares: Vec<(MatteId, f32)>,
}

impl IdCoverage {
    /// Removes all ids.
    pub(crate) fn clear(&mut self) {
        self.shares.clear();
    }

    /// Adds to an id's coverage; ignores [`MatteId::NOTHING`], 0 and NaN. Negative shares (from negative filter lobes) are added as well.
    pub(crate) fn add(&mut self, id: MatteId, share: f32) {
        if id == MatteId::NOTHING || share == 0.0 || share.is_nan() {
            return;
        }
        match self.shares.iter_mut().find(|(other, _)| *other == id) {
            Some((_, sum)) => *sum += share,
            None => self.shares.push((id, share)),
        }
    }

    /// Returns all ids with positive coverage, largest first. Ties are broken by the smaller id, so that the order does
    /// not depend on that of insertion. Other ids are removed.
    pub(crate) fn ranked(&mut self) -> &[(MatteId, f32)] {
        self.shares.retain(|(_, share)| *share > 0.0);
        self.shares.sort_unstable_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        &self.shares
    }

    /// Writes the ranks of the pixel: id, coverage, id, coverage …; padded with zeros. Ids beyond the last rank are
    /// dropped, as the specification expects.
    ///
    /// # Panics
    /// If the length of `ranks` is odd.
    pub(crate) fn write(&mut self, ranks: &mut [f32]) {
        assert!(ranks.len().is_multiple_of(2), "two numbers a rank");
        ranks.fill(0.0);
        for (rank, (id, share)) in ranks.chunks_exact_mut(2).zip(self.ranked()) {
            rank.copy_from_slice(&[id.sample(), *share]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_one_id_add_up_and_the_largest_stands_first() {
        let [a, b, c] = ["a", "b", "c"].map(MatteId::of_name);
        let mut coverage = IdCoverage::default();
        for (id, share) in [(a, 0.25), (b, 0.375), (a, 0.25), (c, 0.125), (MatteId::NOTHING, 1.0), (c, f32::NAN)] {
            coverage.add(id, share);
        }
        assert_eq!(coverage.ranked(), [(a, 0.5), (b, 0.375), (c, 0.125)]);
        let mut ranks = [9.0; 4];
        coverage.write(&mut ranks);
        assert_eq!(ranks, [a.sample(), 0.5, b.sample(), 0.375]);
    }

    #[test]
    fn equal_shares_have_one_order() {
        let ids = ["a", "b", "c", "d"].map(MatteId::of_name);
        let ranked = |order: [usize; 4]| {
            let mut coverage = IdCoverage::default();
            order.iter().for_each(|&index| coverage.add(ids[index], 0.25));
            coverage.ranked().to_vec()
        };
        assert_eq!(ranked([0, 1, 2, 3]), ranked([3, 1, 0, 2]));
    }
}
