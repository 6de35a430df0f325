//! Targets of all pins and moved handles, and interpolation between two sets of targets.
//!
//! In: two sets of targets of the same pins and handles. Out: targets between them.

use super::linalg::small_matrix::{SquareMatrix, best_rotation, rotation_part, times, transpose};
use super::problem::{HandlePin, PointPin};
use crate::lattice::Grid;

/// Targets of all pins and moved handles, at one point of a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Targets<const D: usize> {
    /// Pins with their targets.
    pub pins: Vec<PointPin<D>>,
    /// Moved handles with their targets.
    pub handles: Vec<HandlePin<D>>,
}

impl<const D: usize> Targets<D> {
    /// Interpolates towards other targets: positions linearly, gradients by rotation and stretch.
    pub(crate) fn interpolated(&self, to: &Self, t: f64) -> Self {
        let mix = |a: [f64; D], b: [f64; D]| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t);
        let pins = self.pins.iter().zip(&to.pins).map(|(a, b)| PointPin {
            target: mix(a.target, b.target),
            gradient: a.gradient.zip(b.gradient).map(|(a, b)| interpolate_gradients(&a, &b, t)),
            ..*b
        });
        let handles = self.handles.iter().zip(&to.handles);
        let handles = handles.map(|(a, b)| HandlePin { target: mix(a.target, b.target), ..*b });
        Self { pins: pins.collect(), handles: handles.collect() }
    }

    /// Whether all pins and moved handles have exactly their rest positions as targets.
    pub(crate) fn are_at_rest(&self, grid: &Grid<D>) -> bool {
        let is_identity = |columns: &[[f64; D]; D]| {
            (0..D).all(|row| (0..D).all(|column| columns[column][row] == f64::from(u8::from(row == column))))
        };
        self.pins.iter().all(|pin| pin.target == pin.at && pin.gradient.as_ref().is_none_or(is_identity))
            && self.handles.iter().all(|handle| handle.target == grid.rest_handle(handle.index))
    }

    /// Rest positions and targets of the pins with a positive weight and of all moved handles.
    pub(crate) fn ends(&self, grid: &Grid<D>) -> Vec<[[f64; D]; 2]> {
        let pins = self.pins.iter().filter(|pin| pin.weight > 0.0).map(|pin| [pin.at, pin.target]);
        let handles = self.handles.iter().map(|handle| [grid.rest_handle(handle.index), handle.target]);
        pins.chain(handles).collect()
    }
}

/// Interpolates gradients (columns: images of the axes), split into rotation and stretch.
fn interpolate_gradients<const D: usize>(a: &SquareMatrix<D>, b: &SquareMatrix<D>, t: f64) -> SquareMatrix<D> {
    let [(turn_a, stretch_a), (turn_b, stretch_b)] = [a, b].map(|columns| {
        // The matrix S of `best_rotation` is Σ (axis)(image)ᵀ, whose rows are the columns of the gradient.
        let rotation = best_rotation(columns);
        (rotation, times(&transpose(&rotation), &transpose(columns)))
    });
    let turn = times(&rotation_part(&times(&turn_b, &transpose(&turn_a)), t), &turn_a);
    let stretch: SquareMatrix<D> = std::array::from_fn(|row| {
        std::array::from_fn(|column| stretch_a[row][column] * (1.0 - t) + stretch_b[row][column] * t)
    });
    transpose(&times(&turn, &stretch))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pin(at: [f64; 2], target: [f64; 2], degrees: f64) -> PointPin<2> {
        let (sin, cos) = degrees.to_radians().sin_cos();
        PointPin { gradient: Some([[2.0 * cos, 2.0 * sin], [-sin, cos]]), ..PointPin::new(at, target) }
    }

    #[test]
    fn gradients_turn_without_shrinking() {
        let [from, to] = [30.0, 190.0].map(|degrees| pin([0.0; 2], [degrees, 0.0], degrees));
        let [from, to] = [from, to].map(|pin| Targets { pins: vec![pin], handles: Vec::new() });
        let found = from.interpolated(&to, 0.25).pins[0];
        let expected = pin([0.0; 2], [70.0, 0.0], 70.0);
        assert_eq!(found.target, expected.target);
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12;
        let (found, expected) = (found.gradient.unwrap_or_default(), expected.gradient.unwrap_or_default());
        assert!(found.as_flattened().iter().zip(expected.as_flattened()).all(near), "{found:?}");
        // In 3D: half of a rotation by 180 degrees about x is one by 90 degrees.
        let half = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let quarter = interpolate_gradients(&crate::solve::linalg::small_matrix::identity::<3>(), &half, 0.5);
        assert!(
            (quarter[0][0] - 1.0).abs() < 1e-12 && quarter[1][1].abs() < 1e-12 && quarter[1][2].abs() > 1.0 - 1e-12
        );
    }
}
