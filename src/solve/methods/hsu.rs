//! Direct manipulation: the smallest change of the handles that moves the pins to their targets.
//!
//! In: grid and pins; the shape is not used. Out: handles. W. M. Hsu, J. F. Hughes, H. Kaufman, "Direct manipulation of free-form
//! deformations", SIGGRAPH 1992, <https://doi.org/10.1145/133994.134036>, in the form in which the authors of lp-FFD compare it: as
//! least squares, with their E_gr (equation 8).

use super::constraint_rows;
use super::least_squares;
use super::{Deformed, Deformer};
use crate::solve::error::SolveError;
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::problem::Problem;
use crate::solve::settings::{Lambdas, Settings};
use crate::solve::validate;

/// Minimises λmp Σ ‖W_p P − c‖² + λgp Σ ‖P − d‖² + λgr Σ ‖P − P⁰‖², the last sum over the handles that the problem does not move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hsu {
    /// Weights λ, by default those of the paper. The weight of the shape is not used.
    pub(crate) lambdas: Lambdas,
}

impl Default for Hsu {
    fn default() -> Self {
        Self { lambdas: Settings::paper().lambdas }
    }
}

impl<const D: usize> Deformer<D> for Hsu {
    fn key(&self) -> &'static str {
        "hsu"
    }

    fn name(&self) -> &'static str {
        "Hsu 1992 + E_gr"
    }

    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
        validate::problem(problem)?;
        let [pins, moved] = constraint_rows(problem);
        let mut rest = LeastSquaresRows::new();
        for index in 0..problem.grid.handle_count() {
            if problem.handles.iter().all(|handle| handle.index != index) {
                rest.push(1.0, [(index, 1.0)], problem.grid.rest_handle(index));
            }
        }
        let Lambdas { pins: pin, handles: hand, regularizer, .. } = self.lambdas;
        let terms = [(pin, &pins), (hand, &moved), (regularizer, &rest)];
        let lattice = least_squares(problem.grid, &terms, "direct manipulation")?;
        Ok(Deformed { lattice, iterations: 1 })
    }
}
