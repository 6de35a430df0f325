//! Which of two mirrored minima is taken.
//!
//! In: displacements. Out: a number whose sign is the side: the work of a fixed field of forces in the frame of the rigid fit, so that
//! a turned figure buckles to the same side. The field has no symmetry that a buckled shape could have.

use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{SquareMatrix, apply};

/// The force in the middle of the box, along x, y, z.
const MIDDLE: [f64; 3] = [0.37, 1.0, 0.61];

/// What is added from one side of the box to the other.
const SLOPES: [f64; 3] = [0.53, 0.29, 0.41];

/// The field.
#[derive(Debug)]
pub(super) struct Side<const D: usize> {
    forces: Vec<[f64; D]>,
}

impl<const D: usize> Side<D> {
    /// Over unknowns at rest, by how firmly the shape holds each.
    pub(super) fn new(grid: &Grid<D>, (rest, stiffness): (&[[f64; D]], &[f64]), rotation: &SquareMatrix<D>) -> Self {
        let force = |(point, stiffness): (&[f64; D], &f64)| {
            let slope: f64 = (0..D).map(|d| SLOPES[d] * ((point[d] - grid.lo[d]) / grid.size(d) - 0.5)).sum();
            let force: [f64; D] = std::array::from_fn(|d| MIDDLE[d] + if d % 2 == 0 { -slope } else { slope });
            apply(rotation, &force).map(|x| x * stiffness)
        };
        Self { forces: rest.iter().zip(stiffness).map(force).collect() }
    }

    /// The work of the field along a displacement.
    pub(super) fn of(&self, by: &[[f64; D]]) -> f64 {
        self.forces.as_flattened().iter().zip(by.as_flattened()).map(|(x, y)| x * y).sum()
    }
}
