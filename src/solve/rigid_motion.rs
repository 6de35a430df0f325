//! The rigid motion that fits pins and moved handles best.
//!
//! In: pins, handles. Out: x ↦ R (x − from) + to.

use super::linalg::small_matrix::{
    SquareMatrix, apply, best_rotation, identity, mean_of_best_rotations, minus, symmetric_eigen,
};
use super::problem::{HandlePin, PointPin};
use crate::lattice::Grid;

/// Measure of how well targets determine a rotation from which on the best one is used unchanged: 0 where another fits equally well,
/// 1 for a rigid motion.
const DEFINITE: f64 = 0.25;

/// Ratio of the variance of pins across their line to that along it below which targets leave the rotation about this line open.
const LINE: f64 = 1e-9;

/// The motion x ↦ R (x − from) + to. R is a rotation, or the mean of several if [`RigidMotion::fit_continuous`] finds none definite.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMotion<const D: usize> {
    rotation: SquareMatrix<D>,
    from: [f64; D],
    to: [f64; D],
}

impl<const D: usize> RigidMotion<D> {
    /// Image of a point.
    pub(crate) fn image(&self, point: &[f64; D]) -> [f64; D] {
        let turned = apply(&self.rotation, &minus(point, &self.from));
        std::array::from_fn(|d| turned[d] + self.to[d])
    }

    /// The matrix R.
    pub(crate) fn rotation(&self) -> SquareMatrix<D> {
        self.rotation
    }

    /// Returns the motion that best fits pins and moved handles to their targets.
    pub(crate) fn fit(grid: &Grid<D>, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Self {
        Self::with_rotation(grid, (pins, handles), |correlation| best_rotation(&correlation.moved))
    }

    /// Same as [`Self::fit`], but continuous in the targets. Where other rotations fit nearly as well as the best, as where half of
    /// the pins are turned by 180 degrees, R is a mean of them, so that images contract to what these have in common.
    pub(crate) fn fit_continuous(grid: &Grid<D>, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Self {
        Self::with_rotation(grid, (pins, handles), Correlation::continuous_rotation)
    }

    fn with_rotation(
        grid: &Grid<D>,
        (pins, handles): (&[PointPin<D>], &[HandlePin<D>]),
        rotation: impl Fn(&Correlation<D>) -> SquareMatrix<D>,
    ) -> Self {
        let moved = handles.iter().map(|handle| (grid.rest_handle(handle.index), handle.target, 1.0));
        let pairs: Vec<_> = pins.iter().map(|pin| (pin.at, pin.target, pin.weight)).chain(moved).collect();
        let total: f64 = pairs.iter().map(|pair| pair.2).sum();
        if total <= 0.0 {
            return Self { rotation: identity(), from: [0.0; D], to: [0.0; D] };
        }
        let (mut from, mut to) = ([0.0; D], [0.0; D]);
        for (rest, now, weight) in &pairs {
            (0..D).for_each(|d| from[d] += weight / total * rest[d]);
            (0..D).for_each(|d| to[d] += weight / total * now[d]);
        }
        let mut correlation = Correlation::new(1e-13 * grid.diagonal().powi(2));
        for (rest, now, weight) in &pairs {
            correlation.add(weight / total, &minus(rest, &from), &minus(now, &to));
        }
        correlation.extent = (0..D).map(|d| correlation.at_rest[d][d]).sum();
        // A prescribed gradient contributes the images of the axes, with a lever of a tenth of the box diagonal.
        let lever = 0.01 * grid.diagonal().powi(2);
        for (pin, gradient) in pins.iter().filter_map(|pin| pin.gradient.map(|gradient| (pin, gradient))) {
            for (axis, image) in gradient.into_iter().enumerate() {
                correlation.add(pin.weight / total * lever, &identity()[axis], &image);
            }
        }
        correlation.prefer_small_rotations();
        Self { rotation: rotation(&correlation), from, to }
    }
}

/// Correlation of rest positions and targets, relative to their means.
struct Correlation<const D: usize> {
    /// Σ w (rest)(target)ᵀ.
    moved: SquareMatrix<D>,
    /// Σ w (rest)(rest)ᵀ.
    at_rest: SquareMatrix<D>,
    /// Σ w |rest|² of positions, without gradients.
    extent: f64,
    /// Squared length that is rounding.
    noise: f64,
    /// In 2D, |z| / extent with z = Σ w rest̄·target in complex numbers: how well the targets determine the rotation.
    definiteness: f64,
}

impl<const D: usize> Correlation<D> {
    fn new(noise: f64) -> Self {
        Self { moved: [[0.0; D]; D], at_rest: [[0.0; D]; D], extent: 0.0, noise, definiteness: 1.0 }
    }

    fn add(&mut self, weight: f64, rest: &[f64; D], now: &[f64; D]) {
        for a in 0..D {
            (0..D).for_each(|b| self.moved[a][b] += weight * rest[a] * now[b]);
            (0..D).for_each(|b| self.at_rest[a][b] += weight * rest[a] * rest[b]);
        }
    }

    /// Adds a small multiple of the identity, so that rounding does not choose a rotation; where several are best, the smallest is
    /// taken.
    fn prefer_small_rotations(&mut self) {
        let s = &mut self.moved;
        if D == 2 && self.extent > self.noise {
            self.definiteness = (s[0][0] + s[1][1]).hypot(s[0][1] - s[1][0]) / self.extent;
        }
        let size: f64 = s.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).sum();
        (0..D).for_each(|d| s[d][d] += 1e-12 * size + self.noise);
    }

    /// The best rotation, or a mean of the rotations that fit nearly as well.
    fn continuous_rotation(&self) -> SquareMatrix<D> {
        if D != 3 {
            let share = smoothstep(self.definiteness / DEFINITE);
            return best_rotation(&self.moved).map(|row| row.map(|x| x * share));
        }
        let (variances, _) = symmetric_eigen(&self.at_rest);
        let along: f64 = variances.into_iter().fold(0.0, f64::max);
        let across = variances.iter().sum::<f64>() - along;
        if across <= LINE * along {
            return best_rotation(&self.moved);
        }
        // For a rigid motion the second best rotation fits worse by 2·across.
        mean_of_best_rotations(&self.moved, |loss| 1.0 - smoothstep(loss / (2.0 * across * DEFINITE)))
    }
}

/// 0 up to 0, 1 from 1 on, with continuous derivative.
fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
