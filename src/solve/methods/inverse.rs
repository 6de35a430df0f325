//! Inverse free-form deformation: fits a lattice to a mesh that another method has moved.
//!
//! Noh et al. 2021 (`noh2021inverse` of <https://arxiv.org/abs/2405.07450v1>), as the authors of lp-FFD describe and compare it:
//! least squares to the moved vertices and a smoothing term over neighbouring handles.
//!
//! In: grid, rest and moved vertices. Out: handles.

use super::arap::Arap;
use super::least_squares;
use super::{Deformed, Deformer};
use crate::lattice::{Grid, Lattice};
use crate::solve::error::SolveError;
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::merge_duplicates::merge_duplicates;
use crate::solve::problem::Problem;
use crate::solve::regularizer;
use crate::solve::settings::Scaling;
use crate::solve::validate;

/// As-rigid-as-possible deformation of the mesh, followed by the lattice that fits the result best.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArapAndInverse {
    /// Settings of the deformation of the mesh.
    pub arap: Arap,
    /// Weight of the smoothing term: λgr of lp-FFD, since the paper does not give one.
    pub smoothing: f64,
}

impl Default for ArapAndInverse {
    fn default() -> Self {
        Self { arap: Arap::default(), smoothing: 1e-2 }
    }
}

impl<const D: usize> Deformer<D> for ArapAndInverse {
    fn key(&self) -> &'static str {
        "arap"
    }

    fn name(&self) -> &'static str {
        "ARAP + inverse FFD"
    }

    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
        validate::problem(problem)?;
        // Without this the mesh would come apart at texture seams.
        let shape = merge_duplicates(problem.shape);
        let (moved, iterations) = self.arap.deform(&shape, problem.pins)?;
        let lattice = inverse_ffd(problem.grid, &shape.points, &moved, self.smoothing)?;
        Ok(Deformed { lattice, iterations })
    }
}

/// Returns the lattice that minimises Σ ‖W_i P − v'_i‖² + λ Σ ‖(P_a − P_b) − (P⁰_a − P⁰_b)‖², the second sum over the edges of
/// the grid.
///
/// `rest` and `moved` are the vertices before and after the deformation, #vertices each.
///
/// # Errors
/// [`SolveError::Singular`] if vertices and smoothing do not determine all handles.
pub fn inverse_ffd<const D: usize>(
    grid: &Grid<D>,
    rest: &[[f64; D]],
    moved: &[[f64; D]],
    smoothing: f64,
) -> Result<Lattice<D>, SolveError> {
    assert_eq!(rest.len(), moved.len(), "as many moved vertices as at rest");
    let mut vertices = LeastSquaresRows::new();
    for (rest, moved) in rest.iter().zip(moved) {
        let held = grid.clamp_to_box(*rest);
        vertices.push(1.0, grid.weights(held), std::array::from_fn(|d| moved[d] + held[d] - rest[d]));
    }
    let neighbours = regularizer::noh(grid, Scaling::Plain);
    least_squares(grid, &[(1.0, &vertices), (smoothing, &neighbours)], "inverse FFD")
}
