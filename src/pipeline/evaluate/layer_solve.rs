//! Solves one layer, on the screen or in the scene: shape and pins give a factored matrix, targets give a lattice.
//!
//! In: grid, shape, targets and settings of a layer. Out: a [`Solver`], and a [`Solution`] that fades with its pins.

use super::layer_pins::fade;
use crate::lattice::Grid;
use crate::solve::{Cancel, Problem, Settings, Shape, Solution, SolveError, Solver, Targets};

/// Samples the shape and factors the matrix for pins and handles; `None` if there are neither. The shape is computed
/// only if it is needed.
///
/// # Errors
/// [`SolveError`] if the problem is malformed or the solve is cancelled.
pub(in crate::pipeline) fn factor<const D: usize>(
    grid: &Grid<D>,
    shape: impl FnOnce() -> Shape<D>,
    targets: &Targets<D>,
    settings: &Settings,
    cancel: &Cancel,
) -> Result<Option<Solver<D>>, SolveError> {
    let Targets { pins, handles } = targets;
    if pins.is_empty() && handles.is_empty() {
        return Ok(None);
    }
    let problem = Problem { grid, shape: &shape(), pins, handles, settings };
    Solver::build(&problem, cancel).map(Some)
}

/// Solves for `targets`, which end the path `path` (if empty, those for which the matrix was factored). If no handle is
/// moved, the solution fades with the largest presence of its pins.
///
/// # Errors
/// [`SolveError`] if the targets do not match the solver's pins and handles, or the solve is cancelled.
pub(in crate::pipeline) fn solve_layer<const D: usize>(
    solver: &Solver<D>,
    path: &[Targets<D>],
    targets: &Targets<D>,
    presence: impl Iterator<Item = f64>,
    cancel: &Cancel,
) -> Result<Solution<D>, SolveError> {
    let mut solution = solver.with_cancel(cancel).follow(path)?;
    let presence = presence.fold(0.0, f64::max);
    if targets.handles.is_empty() && presence < 1.0 {
        fade(&mut solution, (solver, &targets.pins), presence);
    }
    Ok(solution)
}
