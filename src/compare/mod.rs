//! Compares all methods on one problem: the same pins, box and dims, one table and one picture. Each method runs on the basis with
//! which it was published and on that of the problem, so that the effects of basis and energy can be told apart.
//!
//! In: a problem and methods. Out: [`Entry`]s, a table, a `comparison_sheet`.

#[cfg(feature = "cli")]
mod comparison_sheet;
#[cfg(feature = "cli")]
mod table;

#[cfg(feature = "cli")]
pub(crate) use comparison_sheet::{ColorRun, SheetModel, comparison_sheet};
#[cfg(feature = "cli")]
pub(crate) use table::table;

use crate::lattice::{Basis, Grid, Lattice};
use crate::solve::methods::{Deformed, Deformer};
use crate::solve::problem_file::Measures;
use crate::solve::{PointPin, Problem, SolveError, distance};
use serde::Serialize;
use std::time::Instant;

/// Runs per method; the fastest counts, because other load only adds time.
const RUNS: usize = 3;

/// The result of one method.
#[derive(Clone, Debug)]
pub struct Entry<const D: usize> {
    /// The method's name.
    pub method: &'static str,
    /// The basis that it ran on.
    pub basis: Basis,
    /// Its metrics.
    pub metrics: Metrics,
    /// Its lattice.
    pub lattice: Lattice<D>,
    /// Moved vertices, #vertices.
    pub points: Vec<[f64; D]>,
}

/// Quality measures of a result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Mean change of a triangle's corner angle, in radians.
    pub angle: f64,
    /// Mean of |σ1σ2 − 1|, weighted by rest area.
    pub area: f64,
    /// Largest distance of a pin from its target, in diagonals of the rest box.
    pub pin_error: f64,
    /// Number of inverted triangles.
    pub flips: usize,
    /// Number of inverted lattice cells.
    pub folded_cells: usize,
    /// Largest distance of a handle from the rest box, in diagonals of that box.
    pub stray: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Time in milliseconds of the fastest of three cold runs.
    pub ms: f64,
}

/// Runs a method on a problem, on the basis with which the method was published.
///
/// # Errors
/// [`SolveError`] if the method cannot solve it.
pub fn run<const D: usize>(method: &dyn Deformer<D>, problem: &Problem<D>) -> Result<Entry<D>, SolveError> {
    run_on(method, problem, method.basis().unwrap_or(problem.grid.basis))
}

/// Runs a method on a problem, on this basis in place of the problem's.
///
/// # Errors
/// [`SolveError`] if the method cannot solve it, or the basis does not fit the dims.
pub(crate) fn run_on<const D: usize>(
    method: &dyn Deformer<D>,
    problem: &Problem<D>,
    basis: Basis,
) -> Result<Entry<D>, SolveError> {
    let grid = Grid { basis, ..problem.grid.clone() };
    let problem = Problem { grid: &grid, ..*problem };
    let mut ms = f64::INFINITY;
    let mut deformed = timed(method, &problem, &mut ms)?;
    for _ in 1..RUNS {
        deformed = timed(method, &problem, &mut ms)?;
    }
    let Deformed { lattice, iterations } = deformed;
    let points: Vec<[f64; D]> = problem.shape.points.iter().map(|&point| lattice.deform(point)).collect();
    let measures = Measures::of(problem.shape, &points);
    let metrics = Metrics {
        angle: measures.ang_rad,
        area: measures.area_abs,
        pin_error: largest_residual(&lattice, problem.pins) / grid.diagonal(),
        flips: measures.flips,
        folded_cells: lattice.folded_cells().len(),
        stray: stray(&lattice),
        iterations,
        ms,
    };
    Ok(Entry { method: method.name(), basis, metrics, lattice, points })
}

fn timed<const D: usize>(
    method: &dyn Deformer<D>,
    problem: &Problem<D>,
    ms: &mut f64,
) -> Result<Deformed<D>, SolveError> {
    let start = Instant::now();
    let deformed = method.deform(problem)?;
    *ms = ms.min(start.elapsed().as_secs_f64() * 1e3);
    Ok(deformed)
}

fn largest_residual<const D: usize>(lattice: &Lattice<D>, pins: &[PointPin<D>]) -> f64 {
    let residuals = pins.iter().map(|pin| distance(&lattice.deform(pin.at), &pin.target));
    residuals.fold(0.0, f64::max)
}

/// Returns the largest distance of a handle from the rest box, in its diagonals.
fn stray<const D: usize>(lattice: &Lattice<D>) -> f64 {
    let grid = &lattice.grid;
    let away = lattice.handles.iter().map(|&handle| distance(&grid.clamp_to_box(handle), &handle));
    away.fold(0.0, f64::max) / grid.diagonal()
}
