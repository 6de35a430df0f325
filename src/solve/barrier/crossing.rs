//! Bounds a step so that det J stays above a given value at all points of the barrier.
//!
//! In: two states. Out: the fraction of the way between them that may be taken. Along a line det J is a polynomial of degree D,
//! whose first root is found by bisection of its Bernstein form; J. Smith and S. Schaefer, "Bijective Parameterization with Free
//! Boundaries", 2015, bound their steps in this way.

use super::points::{BarrierPoints, determinants};
use crate::solve::linalg::simd::{LANES, Lanes, lane_of};

/// Maximum depth of the bisection: a root is located to 2⁻⁴⁰ of the interval.
const BISECTIONS: usize = 40;

impl<const D: usize> BarrierPoints<D> {
    /// Returns the largest fraction of the way from `from` to `to` up to which det J exceeds `least` at every point; 1 where the
    /// whole way is free.
    pub(super) fn max_step(&self, from: &[[f64; D]], to: &[[f64; D]], least: f64) -> f64 {
        let open = self.open_between([from, to], least);
        let (before, after) = (self.gradients_in(&open, from), self.gradients_in(&open, to));
        // Unused lanes hold the gradient 0, which crosses nothing.
        let points = before.iter().zip(&after);
        points.fold(1.0, |share, (before, after)| first_root(before, after, (least, share)))
    }
}

/// Returns where between two matrices in one of four lanes the determinant first falls to `least`, as a fraction of the way, at
/// most `share`. Lanes of zeros are left out.
fn first_root<const D: usize>(from: &[[Lanes; D]; D], to: &[[Lanes; D]; D], (least, mut share): (f64, f64)) -> f64 {
    // Bernstein coefficients of the polynomial over 0..share, from its values at four evenly spaced parameters.
    let [a, b, c, d]: [Lanes; 4] = std::array::from_fn(|k| {
        let t = share * k as f64 / 3.0;
        let blend = |a: &Lanes, b: &Lanes| -> Lanes { std::array::from_fn(|lane| a[lane] * (1.0 - t) + b[lane] * t) };
        let at: [[Lanes; D]; D] =
            std::array::from_fn(|row| std::array::from_fn(|axis| blend(&from[row][axis], &to[row][axis])));
        determinants(&at).map(|det| det - least)
    });
    let [b, c]: [Lanes; 2] = [
        std::array::from_fn(|lane| (-5.0 * a[lane] + 18.0 * b[lane] - 9.0 * c[lane] + 2.0 * d[lane]) / 6.0),
        std::array::from_fn(|lane| (2.0 * a[lane] - 9.0 * b[lane] + 18.0 * c[lane] - 5.0 * d[lane]) / 6.0),
    ];
    let end = share;
    for lane in 0..LANES {
        let coefficients = [a, b, c, d].map(|x| x[lane]);
        if coefficients.iter().all(|&x| x > 0.0) {
            continue;
        }
        if coefficients.iter().any(|x| x.is_nan()) {
            return 0.0;
        }
        let is_used = lane_of(from, lane).as_flattened().iter().any(|&x| x != 0.0);
        if is_used && let Some(root) = first_root_in(coefficients, 0, [0.0, end]) {
            share = share.min(root);
        }
    }
    share
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
    use crate::solve::linalg::small_matrix::SquareMatrix;

    #[test]
    fn the_first_of_several_roots_is_found() {
        fn root<const D: usize>(from: SquareMatrix<D>, to: SquareMatrix<D>, within: (f64, f64)) -> f64 {
            // The other lanes are unused.
            let lanes = |m: SquareMatrix<D>| m.map(|row| row.map(|x| [x, 0.0, 0.0, 0.0]));
            first_root(&lanes(from), &lanes(to), within)
        }
        // det J = (1 − 2t)(1 − 4t) has roots at ¼ and ½.
        let (from, to) = ([[1.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.0, -3.0]]);
        assert!((root(from, to, (0.0, 1.0)) - 0.25).abs() < 1e-9);
        assert_eq!(root(from, to, (0.0, 0.2)), 0.2);
        let (from, to) =
            ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]]);
        assert_eq!(root(from, to, (0.02, 1.0)), 1.0);
        assert!((root(from, to, (0.75, 1.0)) - 0.5).abs() < 1e-9);
    }
}
