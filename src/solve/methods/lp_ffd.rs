//! lp-FFD as two methods of the comparison: with the paper's preset, and with the defaults of this program.
//!
//! T. Fukusato, A. Maejima, T. Igarashi, "Locality-Preserving Free-Form Deformation", 2024, <https://arxiv.org/abs/2405.07450v1>.
//!
//! In: a problem. Out: handles.

use super::{Deformed, Deformer};
use crate::lattice::Basis;
use crate::solve::error::SolveError;
use crate::solve::problem::Problem;
use crate::solve::settings::Settings;
use crate::solve::solver::solve;

/// lp-FFD with the paper's preset.
#[derive(Clone, Debug)]
pub struct PaperLpFfd {
    /// Settings, by default [`Settings::paper`] with up to 2000 iterations.
    pub settings: Settings,
}

impl Default for PaperLpFfd {
    fn default() -> Self {
        Self { settings: Settings { iteration_limit: 2000, ..Settings::paper() } }
    }
}

impl<const D: usize> Deformer<D> for PaperLpFfd {
    fn key(&self) -> &'static str {
        "paper"
    }

    fn name(&self) -> &'static str {
        "lp-FFD, as published"
    }

    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
        deform(&Problem { settings: &self.settings, ..*problem })
    }
}

/// lp-FFD with the settings and the basis of the problem, which default to those of this program.
#[derive(Clone, Copy, Debug)]
pub struct DefaultLpFfd;

impl<const D: usize> Deformer<D> for DefaultLpFfd {
    fn key(&self) -> &'static str {
        "default"
    }

    fn name(&self) -> &'static str {
        "pinwarp"
    }

    fn basis(&self) -> Option<Basis> {
        None
    }

    fn deform(&self, problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
        deform(problem)
    }
}

fn deform<const D: usize>(problem: &Problem<D>) -> Result<Deformed<D>, SolveError> {
    let solution = solve(problem)?;
    Ok(Deformed { lattice: solution.lattice, iterations: solution.report.iterations })
}
