//! Weights of the points of a model in the proximal term, one for all points or one for each.
//!
//! In: weights of intervals. Out: weights of knots and times between them, and of the rows of the proximal term.

use super::least_squares::LeastSquaresRows;

/// Weights of points. One weight for all is kept as one number, so that the bits of a motion that nothing holds back do not depend
/// on the number of points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PointWeights {
    /// All points have this weight.
    Uniform(f64),
    /// The weight of each point, #points.
    Each(Vec<f64>),
}

impl PointWeights {
    pub(crate) const ZERO: Self = Self::Uniform(0.0);

    /// The weight of a point.
    pub(crate) fn of(&self, point: usize) -> f64 {
        match self {
            Self::Uniform(weight) => *weight,
            Self::Each(weights) => weights.get(point).copied().unwrap_or(0.0),
        }
    }

    /// Whether no point has a weight.
    pub(crate) fn is_zero(&self) -> bool {
        self.greatest() == 0.0
    }

    /// The greatest weight.
    pub(crate) fn greatest(&self) -> f64 {
        match self {
            Self::Uniform(weight) => *weight,
            Self::Each(weights) => weights.iter().copied().fold(0.0, f64::max),
        }
    }

    /// Sets the weights of rows, one per point, so that times the greatest weight they make a mean over the points. Returns whether
    /// any row has changed.
    pub(crate) fn share<const D: usize>(&self, rows: &mut LeastSquaresRows<D>) -> bool {
        let greatest = self.greatest();
        let one = 1.0 / rows.len().max(1) as f64;
        let mut has_changed = false;
        for row in 0..rows.len() {
            let weight = if greatest > 0.0 { one * (self.of(row) / greatest) } else { one };
            has_changed |= weight != rows.weight(row);
            rows.set_weight(row, weight);
        }
        has_changed
    }

    /// Applies a function to every weight.
    pub(crate) fn map(&self, of: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Uniform(weight) => Self::Uniform(of(*weight)),
            Self::Each(weights) => Self::Each(weights.iter().map(|&weight| of(weight)).collect()),
        }
    }

    /// Applies a function to the weights of every point here and there.
    pub(crate) fn zip(&self, other: &Self, of: impl Fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Self::Uniform(a), _) => other.map(|b| of(*a, b)),
            (_, Self::Uniform(b)) => self.map(|a| of(a, *b)),
            (Self::Each(a), Self::Each(b)) => Self::Each(a.iter().zip(b).map(|(&a, &b)| of(a, b)).collect()),
        }
    }

    /// Raises the weight of one of `count` points to at least `weight`.
    pub(crate) fn raise(&mut self, point: usize, weight: f64, count: usize) {
        if weight <= self.of(point) {
            return;
        }
        if let Self::Uniform(all) = self {
            *self = Self::Each(vec![*all; count]);
        }
        if let Self::Each(weights) = self {
            weights[point] = weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_weight_for_each_point_is_that_for_all() {
        let rows = |weights: &PointWeights| {
            let mut rows = LeastSquaresRows::<2>::new();
            (0..3).for_each(|handle| rows.push(1.0 / 3.0, [(handle, 1.0)], [0.0; 2]));
            let has_changed = weights.share(&mut rows);
            (has_changed, [0, 1, 2].map(|row| rows.weight(row).to_bits()))
        };
        let same = (false, [(1.0_f64 / 3.0).to_bits(); 3]);
        for weights in [PointWeights::ZERO, PointWeights::Uniform(0.7), PointWeights::Each(vec![0.7; 3])] {
            assert_eq!(rows(&weights), same, "{weights:?}");
        }
        assert_ne!(rows(&PointWeights::Each(vec![0.7, 0.7, 1.4])), same);
    }

    #[test]
    fn only_a_higher_weight_changes_a_point() {
        let mut weights = PointWeights::Uniform(2.0);
        weights.raise(1, 2.0, 3);
        assert_eq!(weights, PointWeights::Uniform(2.0));
        weights.raise(1, 5.0, 3);
        weights.raise(0, 1.0, 3);
        assert_eq!(weights, PointWeights::Each(vec![2.0, 5.0, 2.0]));
        assert_eq!(weights.zip(&PointWeights::Uniform(3.0), f64::max), PointWeights::Each(vec![3.0, 5.0, 3.0]));
    }
}
