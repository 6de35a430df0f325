//! The rigid motion that fits pins and moved handles best.
//!
//! In: pins, handles. Out: x ↦ R (x − from) + to.

use super::linalg::small_matrix::{
    SquareMatrix, apply, best_rotation, dot, identity, mean_of_best_rotations, minus, symmetric_eigen, times,
};
use super::targets::Targets;
use crate::lattice::Grid;
use crate::smoothstep::smoothstep;

/// Measure of how well targets determine a rotation from which on the best one is used unchanged: 0 where another fits equally well,
/// 1 for a rigid motion.
const DEFINITE: f64 = 0.25;

/// Root mean square distance of pins from their line, in box diagonals, from which on they determine the rotation about it.
const NEAR_LINE: f64 = 0.07;

/// Lever, in box diagonals, of the preference for the smallest rotation about a line near which pins lie. Moving one of them across
/// the line would turn the whole shape over.
const ROLL_LEVER: f64 = 0.05;

/// Ratio of the variance of the residual of a rigid fit to that of pins across their line from which on targets are no rigid motion.
const RIGID: f64 = 1e-6;

/// Cosine of the rotation of a line at which its smallest rotation is no longer determined.
const REVERSED: f64 = -1.0 + 1e-6;

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
    pub(crate) fn fit(grid: &Grid<D>, targets: &Targets<D>) -> Self {
        Self::with_rotation(grid, targets, |correlation| best_rotation(&correlation.moved))
    }

    /// Same as [`Self::fit`], but continuous in the targets. Where other rotations fit nearly as well as the best, as where half of
    /// the pins are turned by 180 degrees, R is a mean of them, so that images contract to what these have in common.
    pub(crate) fn fit_continuous(grid: &Grid<D>, targets: &Targets<D>) -> Self {
        Self::with_rotation(grid, targets, Correlation::continuous_rotation)
    }

    fn with_rotation(
        grid: &Grid<D>,
        targets: &Targets<D>,
        rotation: impl Fn(&Correlation<D>) -> SquareMatrix<D>,
    ) -> Self {
        let Some(mut correlation) = Correlation::of(grid, targets) else {
            return Self { rotation: identity(), from: [0.0; D], to: [0.0; D] };
        };
        correlation.prefer_small_rotations();
        Self { rotation: rotation(&correlation), from: correlation.from, to: correlation.to }
    }
}

/// How far three or more pins and moved handles in space leave open by how much the shape is rolled about the line on which they lie:
/// 1 on the line, 0 from [`NEAR_LINE`] on. Two pins do not resist a roll, nor does moving them cause one.
pub(crate) fn open_roll<const D: usize>(grid: &Grid<D>, targets: &Targets<D>) -> f64 {
    if D != 3 || targets.pins.len() + targets.handles.len() < 3 {
        return 0.0;
    }
    Correlation::of(grid, targets).map_or(0.0, |correlation| correlation.open_roll(&correlation.line()))
}

/// Correlation of rest positions and targets, relative to their means.
struct Correlation<const D: usize> {
    /// Σ w (rest)(target)ᵀ.
    moved: SquareMatrix<D>,
    /// Σ w (rest)(rest)ᵀ.
    at_rest: SquareMatrix<D>,
    /// Σ w |rest|² of positions, without gradients.
    extent: f64,
    /// Σ w |target|² of positions.
    target_extent: f64,
    /// Squared length that is rounding.
    noise: f64,
    /// In 2D, |z| / extent with z = Σ w rest̄·target in complex numbers: how well the targets determine the rotation.
    definiteness: f64,
    /// Squares of [`NEAR_LINE`] and [`ROLL_LEVER`], in units of the space.
    near_line: f64,
    roll_lever: f64,
    /// Means of the rest positions and of the targets.
    from: [f64; D],
    to: [f64; D],
}

impl<const D: usize> Correlation<D> {
    /// The correlation of pins and moved handles; `None` without any of weight.
    fn of(grid: &Grid<D>, targets: &Targets<D>) -> Option<Self> {
        let Targets { pins, handles } = targets;
        let moved = handles.iter().map(|handle| (grid.rest_handle(handle.index), handle.target, 1.0));
        let pairs: Vec<_> = pins.iter().map(|pin| (pin.at, pin.target, pin.weight)).chain(moved).collect();
        let total: f64 = pairs.iter().map(|pair| pair.2).sum();
        if total <= 0.0 {
            return None;
        }
        let (mut from, mut to) = ([0.0; D], [0.0; D]);
        for (rest, now, weight) in &pairs {
            (0..D).for_each(|d| from[d] += weight / total * rest[d]);
            (0..D).for_each(|d| to[d] += weight / total * now[d]);
        }
        let square = grid.diagonal().powi(2);
        let mut correlation = Self {
            moved: [[0.0; D]; D],
            at_rest: [[0.0; D]; D],
            extent: 0.0,
            target_extent: 0.0,
            noise: 1e-13 * square,
            definiteness: 1.0,
            near_line: NEAR_LINE.powi(2) * square,
            roll_lever: ROLL_LEVER.powi(2) * square,
            from,
            to,
        };
        for (rest, now, weight) in &pairs {
            let now = minus(now, &to);
            correlation.add(weight / total, &minus(rest, &from), &now);
            correlation.target_extent += weight / total * dot(&now, &now);
        }
        correlation.extent = (0..D).map(|d| correlation.at_rest[d][d]).sum();
        // A prescribed gradient contributes the images of the axes, with a lever of a tenth of the box diagonal.
        let lever = 0.01 * square;
        for (pin, gradient) in pins.iter().filter_map(|pin| pin.gradient.map(|gradient| (pin, gradient))) {
            for (axis, image) in gradient.into_iter().enumerate() {
                correlation.add(pin.weight / total * lever, &identity()[axis], &image);
            }
        }
        Some(correlation)
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
        if D == 3 {
            self.prefer_small_roll();
        }
        let s = &mut self.moved;
        if D == 2 && self.extent > self.noise {
            self.definiteness = (s[0][0] + s[1][1]).hypot(s[0][1] - s[1][0]) / self.extent;
        }
        let size: f64 = s.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).sum();
        (0..D).for_each(|d| s[d][d] += 1e-12 * size + self.noise);
    }

    /// If the rest positions lie near a line, adds the axes with a lever, moved by the smallest rotation that maps the line to its
    /// image. The lever fades out with the distance from the line, where the targets are a rigid motion, and where the line is
    /// turned around, because there all rotations by 180 degrees are equally small.
    fn prefer_small_roll(&mut self) {
        let line = self.line();
        let open = self.open_roll(&line);
        if open == 0.0 {
            return;
        }
        let direction = line.direction;
        let image: [f64; D] = std::array::from_fn(|b| (0..D).map(|a| direction[a] * self.moved[a][b]).sum());
        let length = dot(&image, &image).sqrt();
        if length <= self.noise {
            return;
        }
        let image = image.map(|x| x / length);
        let c = dot(&direction, &image);
        if c <= REVERSED {
            return;
        }
        // R = I + K + K² / (1 + c), with c the cosine and K x = (direction × image) × x.
        let k: SquareMatrix<D> = std::array::from_fn(|row| {
            std::array::from_fn(|column| image[row] * direction[column] - direction[row] * image[column])
        });
        let squared = times(&k, &k);
        let rotation: SquareMatrix<D> = std::array::from_fn(|row| {
            std::array::from_fn(|column| {
                identity::<D>()[row][column] + k[row][column] + squared[row][column] / (1.0 + c)
            })
        });
        let share = 0.5 * (1.0 + c) * open * (1.0 - self.told_roll(&line));
        let lever = share * self.roll_lever;
        for (b, row) in rotation.iter().enumerate() {
            self.at_rest[b][b] += lever;
            row.iter().enumerate().for_each(|(a, entry)| self.moved[a][b] += lever * entry);
        }
    }

    /// 1 where the targets are a rigid motion, which tells the roll of positions about their line, 0 where they bend the line.
    fn told_roll(&self, line: &Line<D>) -> f64 {
        let best = best_rotation(&self.moved);
        let trace: f64 = (0..D).map(|i| (0..D).map(|k| best[i][k] * self.moved[k][i]).sum::<f64>()).sum();
        let residual = self.extent + self.target_extent - 2.0 * trace;
        1.0 - smoothstep(residual / (RIGID * line.across))
    }

    /// 1 where the rest positions lie on a line, 0 where they are far from one.
    fn open_roll(&self, line: &Line<D>) -> f64 {
        if line.along <= self.noise {
            return 0.0;
        }
        let nearness = |ratio: f64| 1.0 - smoothstep(ratio);
        nearness(line.across / self.near_line) * nearness(4.0 * line.across / line.along)
    }

    /// The line on which the rest positions lie.
    fn line(&self) -> Line<D> {
        let (variances, axes) = symmetric_eigen(&self.at_rest);
        let first = (1..D).fold(0, |first, k| if variances[k] > variances[first] { k } else { first });
        Line {
            along: variances[first],
            across: variances.iter().sum::<f64>() - variances[first],
            direction: std::array::from_fn(|row| axes[row][first]),
        }
    }

    /// The best rotation, or a mean of the rotations that fit nearly as well.
    fn continuous_rotation(&self) -> SquareMatrix<D> {
        if D != 3 {
            let share = smoothstep(self.definiteness / DEFINITE);
            return best_rotation(&self.moved).map(|row| row.map(|x| x * share));
        }
        let Line { across, .. } = self.line();
        if across <= self.noise {
            return best_rotation(&self.moved);
        }
        // For a rigid motion the second best rotation fits worse by 2·across.
        mean_of_best_rotations(&self.moved, |loss| 1.0 - smoothstep(loss / (2.0 * across * DEFINITE)))
    }
}

/// The line on which positions lie, through their mean.
struct Line<const D: usize> {
    /// Variance along the line.
    along: f64,
    /// Variance across it.
    across: f64,
    direction: [f64; D],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use crate::solve::linalg::small_matrix::distance;
    use crate::solve::problem::PointPin;

    /// The fit of pins to targets in a box of size 1.
    fn fit(pins: [([f64; 3], [f64; 3]); 3], is_continuous: bool) -> RigidMotion<3> {
        let grid = Grid { dims: [5; 3], basis: Basis::Bspline, lo: [-0.5; 3], hi: [0.5; 3], angle: 0.0 };
        let pins = pins.map(|(at, target)| PointPin::new(at, target));
        let targets = Targets { pins: pins.to_vec(), handles: Vec::new() };
        if is_continuous { RigidMotion::fit_continuous(&grid, &targets) } else { RigidMotion::fit(&grid, &targets) }
    }

    /// Pins along x, the middle one this far from their line.
    fn near_a_line(height: f64) -> [[f64; 3]; 3] {
        [[-0.3, 0.0, 0.0], [0.0, height, 0.0], [0.3, 0.0, 0.0]]
    }

    #[test]
    fn a_pin_moved_across_the_line_of_the_others_does_not_turn_the_shape_over() {
        for (height, down) in [(0.02, 0.1), (0.02, 0.041), (0.001, 0.3), (0.0, 0.1)] {
            let moved = |at: [f64; 3]| (at, if at[0] == 0.0 { [0.0, height - down, 0.0] } else { at });
            for is_continuous in [false, true] {
                let rotation = fit(near_a_line(height).map(moved), is_continuous).rotation();
                assert!((0..3).all(|d| rotation[d][d] > 0.9), "{height} {down}: {rotation:?}");
            }
        }
    }

    #[test]
    fn pins_that_turn_rigidly_are_followed() {
        // The smallest rotation of a line near which pins lie, and turns about it.
        let spin = |[x, y, z]: [f64; 3]| [-0.5 * x - 0.75_f64.sqrt() * y, 0.75_f64.sqrt() * x - 0.5 * y, z];
        let roll = |[x, y, z]: [f64; 3]| [x, -y, -z];
        let quarter = |[x, y, z]: [f64; 3]| [x, -z, y];
        type Rotation<'a> = &'a dyn Fn([f64; 3]) -> [f64; 3];
        let cases: [(f64, Rotation); 4] = [(0.0, &spin), (0.02, &spin), (0.02, &quarter), (0.02, &roll)];
        for (height, rotated) in cases {
            let motion = fit(near_a_line(height).map(|at| (at, rotated(at))), true);
            for at in [[0.4, 0.1, -0.2], [-0.1, 0.3, 0.3]] {
                assert!(distance(&motion.image(&at), &rotated(at)) < 1e-7, "{height}: {motion:?}");
            }
        }
    }
}
