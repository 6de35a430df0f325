//! Bounds a step so that det J stays above a given value at all points of the barrier.
//!
//! In: two states. Out: the fraction of the way between them that may be taken. Along a line det J is a polynomial of degree D,
//! whose first root is found by bisection of its Bernstein form; J. Smith and S. Schaefer, "Bijective Parameterization with Free
//! Boundaries", 2015, bound their steps in this way.

use super::points::BarrierPoints;
use crate::solve::linalg::simd::lane_of;
use crate::solve::linalg::small_matrix::{SquareMatrix, determinant};

/// Maximum depth of the bisection: a root is located to 2⁻⁴⁰ of the interval.
const BISECTIONS: usize = 40;

impl<const D: usize> BarrierPoints<D> {
    /// Returns the largest fraction of the way from `from` to `to` up to which det J exceeds `least` at every point; 1 where the
    /// whole way is free.
    pub(super) fn max_step(&self, from: &[[f64; D]], to: &[[f64; D]], least: f64) -> f64 {
        let (before, after) = (self.gradients_at(from), self.gradients_at(to));
        let mut share = 1.0;
        self.for_each_point(|[_, packet, lane]| {
            share = first_root(&lane_of(&before[packet], lane), &lane_of(&after[packet], lane), (least, share));
        });
        share
    }
}

/// Returns where between two matrices the determinant first falls to `least`, as a fraction of the way, at most `share`.
fn first_root<const D: usize>(from: &SquareMatrix<D>, to: &SquareMatrix<D>, (least, share): (f64, f64)) -> f64 {
    let at = |t: f64| -> SquareMatrix<D> {
        std::array::from_fn(|row| std::array::from_fn(|axis| from[row][axis] * (1.0 - t) + to[row][axis] * t))
    };
    let gap = |t: f64| determinant(&at(t)) - least;
    // Bernstein coefficients of the polynomial over 0..share, from its values at four evenly spaced parameters.
    let values: [f64; 4] = std::array::from_fn(|k| gap(share * k as f64 / 3.0));
    if values.iter().any(|x| x.is_nan()) {
        return 0.0;
    }
    let [a, b, c, d] = values;
    let inner = [(-5.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 6.0, (2.0 * a - 9.0 * b + 18.0 * c - 5.0 * d) / 6.0];
    if a > 0.0 && d > 0.0 && inner.iter().all(|&x| x > 0.0) {
        return share;
    }
    first_root_in([a, inner[0], inner[1], d], 0, [0.0, share]).unwrap_or(share)
}

/// Returns the first root of a cubic in Bernstein form over an interval, by bisection; `None` where it has no root.
fn first_root_in([a, b, c, d]: [f64; 4], depth: usize, [low, high]: [f64; 2]) -> Option<f64> {
    if a <= 0.0 {
        return Some(low);
    }
    if b > 0.0 && c > 0.0 && d > 0.0 {
        return None;
    }
    if depth >= BISECTIONS {
        return Some(low);
    }
    let (ab, bc, cd) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d));
    let (abc, bcd) = (0.5 * (ab + bc), 0.5 * (bc + cd));
    let (middle, half) = (0.5 * (abc + bcd), f64::midpoint(low, high));
    first_root_in([a, ab, abc, middle], depth + 1, [low, half])
        .or_else(|| first_root_in([middle, bcd, cd, d], depth + 1, [half, high]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_several_roots_is_found() {
        // det J = (1 − 2t)(1 − 4t) has roots at ¼ and ½.
        let (from, to) = ([[1.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, -3.0]]);
        assert!((first_root(&from, &to, (0.0, 1.0)) - 0.25).abs() < 1e-9);
        assert_eq!(first_root(&from, &to, (0.0, 0.2)), 0.2);
        let (from, to) =
            ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]]);
        assert_eq!(first_root(&from, &to, (0.02, 1.0)), 1.0);
        assert!((first_root(&from, &to, (0.75, 1.0)) - 0.5).abs() < 1e-9);
    }
}
