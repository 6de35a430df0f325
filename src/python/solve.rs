//! The bare solver: a shape, pins, and the lattice that deforms it with the least distortion.
//!
//! In: points, triangles, pins as arrays. Out: a [`Solution`].

use super::arrays;
use super::failure::Failure;
use super::lattice::{Handles, Lattice, grid};
use super::named::named;
use super::options::Options;
use super::report;
use super::work::{Watch, away};
use crate::lattice::Grid;
use crate::solve::{Cancel, PointPin, Problem, Settings, Shape, SolveReport, Solver, Topology};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Margin of the lattice around the shape, relative to its extent.
const PADDING: f64 = 0.1;

/// A solved lattice and its quality.
#[pyclass(frozen, module = "pinwarp")]
pub(super) struct Solution {
    lattice: Lattice,
    report: SolveReport,
}

#[pymethods]
impl Solution {
    /// The lattice; for a branching lattice, the largest branch.
    #[getter]
    fn lattice(&self) -> Lattice {
        self.lattice.clone()
    }

    /// The quality of the solution as a dict: pin_errors (a list, in units of the points), folded_model_cells, min_cell_det, angular and
    /// area (distortion), iterations, is_converged, stationarity, warnings and more; docs/METHOD.md explains them.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report::plain(py, &self.report)
    }

    fn __repr__(&self) -> String {
        let worst = self.report.pin_errors.iter().copied().fold(0.0, f64::max);
        let SolveReport { iterations, folded_model_cells, .. } = self.report;
        format!(
            "<Solution: {iterations} iterations, pins off by at most {worst:.1e}, {folded_model_cells} folded cells>"
        )
    }
}

/// Solves for the lattice that moves pins to their targets and preserves the shape.
///
/// points: the shape at rest, (N, 2) or (N, 3), in any unit, y up.
/// triangles: (M, 3), indices into points, in any orientation.
/// pins: (K, 4) with x, y and the target, or (K, 6) in 3D.
/// dims: number of handles along each axis; default: 10, in 3D 5.
/// box: two corners of the box; default: the bounds of the shape with a margin of a tenth.
/// energy: "area", "edge", "vertex", "element", "spokes-and-rims" or "stroke".
/// smoothness: 0.1 to 10.
/// guard: "report" reports folds, "limit" prevents them.
/// branching: gives parts that are apart handles of their own.
/// progress: called with (0, 1) about twenty times per second; False cancels.
///
/// All arrays are copied once on input.
#[pyfunction]
#[pyo3(
    signature = (points, triangles, pins, progress=None, **options),
    text_signature = "(points, triangles, pins, progress=None, *, dims=None, box=None, basis='bspline', energy='area', smoothness=1.0, guard='report', branching=False)"
)]
pub(super) fn solve(
    points: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
    pins: &Bound<'_, PyAny>,
    progress: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Solution> {
    let triangles = arrays::triangles(triangles, "triangles")?;
    let mut options = Options::new(options);
    let py = points.py();
    match arrays::columns(points, "points")? {
        2 => {
            let pins = arrays::points::<4>(pins, "pins")?.into_iter().map(|[x, y, u, v]| PointPin::new([x, y], [u, v]));
            let task = Task::<2>::of((arrays::points(points, "points")?, triangles, pins.collect()), &mut options)?;
            options.end()?;
            let (lattice, report) = away(py, progress, |watch| task.run(watch))?;
            Ok(Solution { lattice: Lattice(Handles::Screen(lattice)), report })
        }
        3 => {
            let pins = arrays::points::<6>(pins, "pins")?.into_iter();
            let pins = pins.map(|[x, y, z, u, v, w]| PointPin::new([x, y, z], [u, v, w]));
            let task = Task::<3>::of((arrays::points(points, "points")?, triangles, pins.collect()), &mut options)?;
            options.end()?;
            let (lattice, report) = away(py, progress, |watch| task.run(watch))?;
            Ok(Solution { lattice: Lattice(Handles::World(lattice)), report })
        }
        found => {
            let what = format!("has {found} coordinates a point");
            Err(Failure::argument("points", what, "give the shape (N, 2) or (N, 3)").into())
        }
    }
}

/// A problem in D dimensions.
struct Task<const D: usize> {
    grid: Grid<D>,
    shape: Shape<D>,
    pins: Vec<PointPin<D>>,
    settings: Settings,
}

type Given<const D: usize> = (Vec<[f64; D]>, Vec<[u32; 3]>, Vec<PointPin<D>>);

impl<const D: usize> Task<D> {
    fn of((points, triangles, pins): Given<D>, options: &mut Options<'_, '_>) -> PyResult<Self> {
        let dims = match options.take::<Vec<usize>>("dims")? {
            None => [if D == 2 { 10 } else { 5 }; D],
            Some(dims) => dims.as_slice().try_into().map_err(|_| {
                Failure::argument("dims", format!("is {dims:?}"), format!("give {D} numbers of handles"))
            })?,
        };
        let corners = match options.take::<[Vec<f64>; 2]>("box")? {
            Some(corners) => corners,
            None => bounds(&points)?,
        };
        let basis = options.take::<String>("basis")?;
        let basis = basis.map_or_else(|| Ok(Default::default()), |name| named("basis", &name))?;
        let settings = settings(options)?;
        let shape = Shape::of_triangles(points, triangles);
        Ok(Self { grid: grid((&corners, 0.0), dims, basis)?, shape, pins, settings })
    }

    fn run(&self, watch: &Watch) -> Result<(crate::lattice::Lattice<D>, SolveReport), Failure> {
        let Self { grid, shape, pins, settings } = self;
        watch.tell(0, 1);
        let is_stopped = || watch.is_stopped();
        let cancel = Cancel::when(&is_stopped);
        let problem = Problem { grid, shape, pins, handles: &[], settings };
        let solution = Solver::build(&problem, &cancel)?.with_cancel(&cancel).solve()?;
        watch.tell(1, 1);
        Ok((solution.lattice, solution.report))
    }
}

fn settings(options: &mut Options<'_, '_>) -> PyResult<Settings> {
    let mut settings = Settings::default();
    if let Some(name) = options.take::<String>("energy")? {
        settings.energy = named("energy", &name)?;
    }
    if let Some(name) = options.take::<String>("guard")? {
        settings.guard = named("guard", &name)?;
    }
    if options.take::<bool>("branching")? == Some(true) {
        settings.topology = Topology::Branching;
    }
    let smoothness = options.take::<f64>("smoothness")?.unwrap_or(1.0);
    if !(0.1..=10.0).contains(&smoothness) {
        return Err(Failure::argument("smoothness", format!("is {smoothness}"), "keep it within 0.1 to 10").into());
    }
    Ok(settings.with_smoothness(smoothness))
}

/// Returns the corners of a shape's bounding box with the margin.
fn bounds<const D: usize>(points: &[[f64; D]]) -> Result<[Vec<f64>; 2], Failure> {
    if points.is_empty() {
        return Err(Failure::argument("points", "is empty", "give the points of a shape"));
    }
    let extreme = |pick: fn(f64, f64) -> f64, axis: usize| points.iter().map(|point| point[axis]).reduce(pick);
    let side = |axis: usize| {
        let [lo, hi] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| extreme(pick, axis).unwrap_or_default());
        let room = PADDING * (hi - lo);
        [lo - room, hi + room]
    };
    Ok([0, 1].map(|end| (0..D).map(|axis| side(axis)[end]).collect()))
}
