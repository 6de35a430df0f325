//! lp-FFD as a method of the comparison: the paper's preset and the program's own default.
//!
//! T. Fukusato, A. Maejima, T. Igarashi, "Locality-Preserving Free-Form Deformation", 2024,
//! <https://arxiv.org/abs/2405.07450v1>.
//!
//! In: a problem. Out: handles.

use super::{Deformed, Deformer};
use crate::lattice::Basis;
use crate::solve::{Problem, Settings, SolveError, solve};

/// The paper's preset.
#[derive(Clone, Debug)]
pub struct Paper {
    /// [`Settings::paper`], unless changed.
    pub settings: Settings,
}

impl Default for Paper {
    fn default() -> Self {
        Self { settings: Settings { iteration_limit: 2000, ..Settings::paper() } }
    }
}

impl<const D: usize> Deformer<D> for Paper {
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

/// The problem's own settings and basis: the default, unless the problem says otherwise.
#[derive(Clone, Copy, Debug)]
pub struct House;

impl<const D: usize> Deformer<D> for House {
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
