//! Selects one of two mirrored minima.
//!
//! In: displacements. Out: a number whose sign is the side: the work of a fixed force field in the frame of the rigid fit, so
//! that a rotated figure buckles to the same side. The field has none of the symmetries that a buckled shape could have.

use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{SquareMatrix, apply};

/// Force in the middle of the box, along x, y, z.
const MIDDLE: [f64; 3] = [0.37, 1.0, 0.61];

/// Change of the force from one side of the box to the other, per axis.
const SLOPES: [f64; 3] = [0.53, 0.29, 0.41];

/// The force field.
#[derive(Debug)]
pub(super) struct Side<const D: usize> {
    forces: Vec<[f64; D]>,
}

impl<const D: usize> Side<D> {
    /// Evaluates the field at the rest positions of the unknowns, each multiplied by the stiffness of the shape there.
    pub(super) fn new(grid: &Grid<D>, (rest, stiffness): (&[[f64; D]], &[f64]), rotation: &SquareMatrix<D>) -> Self {
        let force = |(point, stiffness): (&[f64; D], &f64)| {
            let slope: f64 = (0..D).map(|d| SLOPES[d] * ((point[d] - grid.lo[d]) / grid.size(d) - 0.5)).sum();
            let force: [f64; D] = std::array::from_fn(|d| MIDDLE[d] + if d % 2 == 0 { -slope } else { slope });
            apply(rotation, &force).map(|x| x * stiffness)
        };
        Self { forces: rest.iter().zip(stiffness).map(force).collect() }
    }

    /// Work of the field along a displacement.
    pub(super) fn of(&self, by: &[[f64; D]]) -> f64 {
        self.forces.as_flattened().iter().zip(by.as_flattened()).map(|(x, y)| x * y).sum()
    }
}
