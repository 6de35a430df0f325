//! Runs the solver on a problem file.
//!
//! In: raw keys. Out: [`ResultFile`].

use super::ResultFile;
use super::error::ProblemError;
use super::file::{ProblemFile, RawPin, point};
use super::measures::Measures;
use crate::lattice::{Grid, Lattice};
use crate::solve::cancel::Cancel;
use crate::solve::energy::{self, Area, Distortion, WithPinNeighbourhoods};
use crate::solve::error::SolveError;
use crate::solve::least_squares::LeastSquaresRows;
use crate::solve::pins;
use crate::solve::problem::{HandlePin, PointPin, Problem, Shape};
use crate::solve::samples::Sample;
use crate::solve::settings::{Energy, OutsidePins, Settings};
use crate::solve::solver::Solver;
use crate::solve::system::Parts;
use crate::solve::validate;

/// Solves a problem in D dimensions.
pub(super) fn run<const D: usize>(file: &ProblemFile) -> Result<ResultFile, ProblemError> {
    let settings = file.settings()?;
    let shape = shape::<D>(file)?;
    let grid = grid(file, &shape)?;
    let (pins, handles) = (point_pins(&file.pins, &shape)?, moved_handles(file)?);
    let problem = Problem { grid: &grid, shape: &shape, pins: &pins, handles: &handles, settings: &settings };
    validate::problem(&problem)?;
    let distortion = WithPinNeighbourhoods::around(distortion(file, &problem)?, &grid, &pins, &settings);
    let parts = Parts {
        distortion,
        pin_rows: pin_rows(file, &problem),
        branching: None,
        warnings: Vec::new(),
        proximal: LeastSquaresRows::new(),
    };
    let solver = Solver::assemble(&problem, parts)?;
    let mut energies = Vec::new();
    let solution = solver.solve_observed(|energy| energies.push(energy));
    let vertices: Vec<[f64; D]> =
        shape.points.iter().map(|&vertex| moved(&solution.lattice, &settings, vertex)).collect();
    let measures = Measures::of(&shape, &vertices);
    let lists = |points: &[[f64; D]]| points.iter().map(|point| point.to_vec()).collect();
    Ok(ResultFile {
        handles: lists(&solution.lattice.handles),
        vertices: lists(&vertices),
        energies,
        measures,
        iterations: solution.report.iterations,
        warnings: solution.report.conflicts.iter().map(conflict).chain(solution.report.warnings).collect(),
    })
}

fn conflict([first, second]: &[usize; 2]) -> String {
    format!(
        "pins {first} and {second} hold the same point but have different targets; the point is placed between them (least \
         squares); remove one of them"
    )
}

fn moved<const D: usize>(lattice: &Lattice<D>, settings: &Settings, vertex: [f64; D]) -> [f64; D] {
    match settings.outside_pins {
        OutsidePins::Nearest => lattice.deform(vertex),
        OutsidePins::Extended => lattice.evaluate(vertex),
    }
}

pub(super) fn shape<const D: usize>(file: &ProblemFile) -> Result<Shape<D>, ProblemError> {
    let points = file.vertices.iter().enumerate();
    let points = points.map(|(k, vertex)| point(vertex, || format!("vertices[{k}]"))).collect::<Result<Vec<_>, _>>()?;
    for (k, triangle) in file.triangles.iter().enumerate() {
        if let Some(corner) = triangle.iter().find(|&&corner| corner as usize >= points.len()) {
            let what = format!("names vertex {corner}, there are {}", points.len());
            return Err(ProblemError::key(format!("triangles[{k}]"), what, "count vertices from 0"));
        }
    }
    for (k, stroke) in file.strokes.iter().enumerate() {
        if let Some(vertex) = stroke.iter().find(|&&vertex| vertex as usize >= points.len()) {
            let what = format!("names vertex {vertex}, there are {}", points.len());
            return Err(ProblemError::key(format!("strokes[{k}]"), what, "count vertices from 0"));
        }
    }
    Ok(Shape { strokes: file.strokes.clone(), ..Shape::of_triangles(points, file.triangles.clone()) })
}

/// Returns the grid. Without `bbox` its box is that of the vertices, padded by a tenth of its size on each side.
pub(super) fn grid<const D: usize>(file: &ProblemFile, shape: &Shape<D>) -> Result<Grid<D>, ProblemError> {
    let [lo, hi] = match &file.bbox {
        Some([lo, hi]) => [point(lo, || "bbox[0]".into())?, point(hi, || "bbox[1]".into())?],
        None => padded_bounds(&shape.points),
    };
    let grid = Grid { dims: file.dims(), basis: file.basis()?, lo, hi, angle: 0.0 };
    grid.check().map_err(crate::solve::SolveError::from)?;
    Ok(grid)
}

fn padded_bounds<const D: usize>(points: &[[f64; D]]) -> [[f64; D]; 2] {
    let fold = |pick: fn(f64, f64) -> f64, start: f64| -> [f64; D] {
        std::array::from_fn(|d| points.iter().map(|point| point[d]).fold(start, pick))
    };
    let (lo, hi) = (fold(f64::min, f64::INFINITY), fold(f64::max, f64::NEG_INFINITY));
    let pad: [f64; D] = std::array::from_fn(|d| 0.1 * (hi[d] - lo[d]));
    [std::array::from_fn(|d| lo[d] - pad[d]), std::array::from_fn(|d| hi[d] + pad[d])]
}

pub(super) fn point_pins<const D: usize>(raw: &[RawPin], shape: &Shape<D>) -> Result<Vec<PointPin<D>>, ProblemError> {
    let pins = raw.iter().enumerate();
    pins.map(|(k, raw)| {
        let corners = corners(raw, k, shape)?;
        let at = match &raw.point {
            Some(at) => point(at, || format!("pins[{k}].point"))?,
            None => std::array::from_fn(|d| corners.iter().map(|&(vertex, w)| w * shape.points[vertex][d]).sum()),
        };
        Ok(PointPin::new(at, point(&raw.target, || format!("pins[{k}].target"))?))
    })
    .collect()
}

/// Returns the vertices that a pin is attached to, with barycentric weights; none for a pin at a free point.
fn corners<const D: usize>(raw: &RawPin, k: usize, shape: &Shape<D>) -> Result<Vec<(usize, f64)>, ProblemError> {
    let missing = |name: &str, index: usize, count: usize| {
        let what = format!("names {name} {index}, there are {count}");
        ProblemError::key(format!("pins[{k}].{name}"), what, format!("count from 0 to {}", count.saturating_sub(1)))
    };
    match (raw.vertex, &raw.point, raw.triangle, raw.bary) {
        (Some(vertex), None, None, None) if vertex < shape.points.len() => Ok(vec![(vertex, 1.0)]),
        (Some(vertex), None, None, None) => Err(missing("vertex", vertex, shape.points.len())),
        (None, Some(_), None, None) => Ok(Vec::new()),
        (None, None, Some(triangle), Some(bary)) => match shape.triangles.get(triangle) {
            Some(corners) => Ok(corners.iter().map(|&corner| corner as usize).zip(bary).collect()),
            None => Err(missing("triangle", triangle, shape.triangles.len())),
        },
        _ => Err(ProblemError::key(
            format!("pins[{k}]"),
            "does not name a point to hold",
            "give one of `vertex`, `point`, or `triangle` with `bary`",
        )),
    }
}

/// Returns the pin rows. The row of a pin on a triangle is Σ_k bary_k · (row of corner k), interpolated by the mesh instead of
/// the lattice.
fn pin_rows<const D: usize>(file: &ProblemFile, problem: &Problem<D>) -> LeastSquaresRows<D> {
    let mut rows = LeastSquaresRows::new();
    for (k, (raw, pin)) in file.pins.iter().zip(problem.pins).enumerate() {
        match corners(raw, k, problem.shape) {
            Ok(corners) if corners.len() > 1 => {
                let mut row = vec![0.0; problem.grid.handle_count()];
                for (vertex, share) in corners {
                    problem
                        .grid
                        .for_each_weight(problem.shape.points[vertex], |term| row[term.handle] += share * term.weight);
                }
                let entries = row.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0);
                rows.push(pin.weight, entries, pin.target);
            }
            _ => pins::push_pin(&mut rows, problem.grid, pin, problem.settings),
        }
    }
    rows
}

pub(super) fn moved_handles<const D: usize>(file: &ProblemFile) -> Result<Vec<HandlePin<D>>, ProblemError> {
    let count: usize = file.dims::<D>().iter().product();
    let handles = file.handles.iter().enumerate();
    handles
        .map(|(k, raw)| {
            if raw.index >= count {
                let what = format!("is {}, the lattice has {count} handles", raw.index);
                return Err(ProblemError::key(format!("handles[{k}].index"), what, "count from 0, x fastest"));
            }
            Ok(HandlePin { index: raw.index, target: point(&raw.target, || format!("handles[{k}].target"))? })
        })
        .collect()
}

/// Builds the energy; `samples` in the file replace those of the shape.
fn distortion<const D: usize>(
    file: &ProblemFile,
    problem: &Problem<D>,
) -> Result<Box<dyn Distortion<D>>, ProblemError> {
    let Some(raw) = file.samples.as_ref().filter(|_| problem.settings.energy == Energy::Area) else {
        return Ok(energy::build(problem.grid, problem.shape, problem.pins, problem.settings, &Cancel::never())
            .map_err(SolveError::from)?);
    };
    let samples = raw.iter().enumerate().map(|(k, values)| {
        let (at, area) = values.split_at(D.min(values.len()));
        let at = point(at, || format!("samples[{k}]"))?;
        match area {
            &[area] if area >= 0.0 && area.is_finite() => Ok(Sample { at, area, stiffness: 1.0 }),
            _ => Err(ProblemError::key(format!("samples[{k}]"), "has no area", "give a place and an area from 0")),
        }
    });
    Ok(Box::new(Area::new(problem.grid, &samples.collect::<Result<Vec<_>, ProblemError>>()?, &Cancel::never())))
}
