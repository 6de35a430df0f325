//! The solver: everything that does not depend on targets is computed and factored once, then solved many times.
//!
//! In: grid, shape, pins, handles, settings; later only targets. Out: solutions.

use super::constraints::Constraints;
use super::energy::{self, Distortion};
use super::iterate::{Energies, Iteration, Run};
use super::matrix::{Factor, Normal};
use super::misses::{self, Evidence};
use super::newton::Finish;
use super::occupied;
use super::pins::{self, Rigid};
use super::regularizer::Hold;
use super::rows::RowSet;
use super::small::distance;
use super::waypoint::Waypoint;
use super::{Guard, HandlePin, MissReason, PointPin, Problem, Scaling, Settings, Solution, SolveError, SolveReport};
use crate::lattice::{Folds, Grid, Lattice};
use crate::spelling::counted;
use std::sync::Arc;

/// A prefactored problem: the grid, the shape's samples, which points are pinned and which handles are moved.
///
/// ```
/// use pinwarp::lattice::{Basis, Grid};
/// use pinwarp::solve::{PointPin, Problem, Settings, Shape, Solver};
/// let grid = Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0] };
/// let shape = Shape::of_triangles(vec![[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]], vec![[0, 1, 2]]);
/// let mut pin = PointPin::new([0.5, 0.9], [0.5, 0.9]);
/// let settings = Settings::default();
/// let problem = Problem { grid: &grid, shape: &shape, pins: &[pin], handles: &[], settings: &settings };
/// let solver = Solver::new(&problem)?;
/// pin.target = [0.7, 0.9];
/// let solution = solver.update(&[pin], &[])?;
/// let moved = solution.lattice.carry([0.5, 0.5]);
/// assert!((moved[0] - 0.7).abs() < 1e-6 && (moved[1] - 0.5).abs() < 1e-6);
/// # Ok::<(), pinwarp::solve::SolveError>(())
/// ```
#[derive(Debug)]
pub struct Solver<const D: usize> {
    grid: Grid<D>,
    settings: Settings,
    distortion: Box<dyn Distortion<D>>,
    normal: Normal,
    factor: Factor,
    constraints: Constraints,
    scales: Scales,
    pins: Vec<PointPin<D>>,
    handles: Vec<HandlePin<D>>,
    terms: Terms<D>,
    /// Which cells hold some of the shape.
    is_occupied: Vec<bool>,
    /// What the shape itself had to say.
    warnings: Vec<String>,
}

/// Factors of the four terms and of the weak hold to the rigid fit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    pub(crate) shape: f64,
    pub(crate) pins: f64,
    pub(crate) handles: f64,
    pub(crate) regularizer: f64,
    pub(crate) hold: f64,
}

/// The terms without rotations.
#[derive(Clone, Debug)]
pub(crate) struct Terms<const D: usize> {
    pub(crate) pins: RowSet<D>,
    pub(crate) handles: RowSet<D>,
    /// Shared: no target changes it.
    pub(crate) regularizer: Arc<Hold<D>>,
}

/// Where everything has to go.
pub(crate) struct Targets<'a, const D: usize> {
    pub(crate) pins: &'a [PointPin<D>],
    pub(crate) handles: &'a [HandlePin<D>],
    pub(crate) terms: &'a Terms<D>,
}

/// What a solver is assembled from.
pub(crate) struct Parts<const D: usize> {
    pub(crate) distortion: Box<dyn Distortion<D>>,
    pub(crate) pin_rows: RowSet<D>,
    pub(crate) warnings: Vec<String>,
}

/// Part of the mean diagonal of shape and regulariser with which handles hold on to the rigid fit: it decides what nothing else decides, and
/// moves what something else decides by less than the tolerance.
const HOLD: f64 = 1e-9;

impl<const D: usize> Solver<D> {
    /// Samples the shape and factors the matrix.
    ///
    /// # Errors
    /// [`SolveError`] where the problem is malformed or its matrix is singular.
    pub fn new(problem: &Problem<D>) -> Result<Self, SolveError> {
        super::check::problem(problem)?;
        let (grid, settings) = (problem.grid, problem.settings);
        let parts = Parts {
            distortion: energy::Patched::around(
                energy::build(grid, problem.shape, problem.pins, settings),
                grid,
                problem.pins,
                settings,
            ),
            pin_rows: pins::pin_rows(grid, problem.pins, settings),
            warnings: shape_warnings(problem),
        };
        Self::assemble(problem, parts)
    }

    /// Factors a checked problem whose parts are built already.
    pub(crate) fn assemble(problem: &Problem<D>, parts: Parts<D>) -> Result<Self, SolveError> {
        let Parts { distortion, pin_rows, warnings } = parts;
        let (grid, settings) = (problem.grid, problem.settings);
        let mut moved = vec![false; grid.handle_count()];
        problem.handles.iter().for_each(|handle| moved[handle.index] = true);
        let terms = Terms {
            pins: pin_rows,
            handles: pins::handle_rows(problem.handles),
            regularizer: Arc::new(Hold::new(settings.regularizer, grid, &moved, settings.scaling)),
        };
        let mut scales = Scales::of(grid, settings, distortion.mass());
        let reach = terms.pins.reach().max(terms.regularizer.reach()).max(distortion.reach());
        let mut normal = Normal::zero(grid.handle_count(), reach);
        distortion.add_normal(scales.shape, &mut normal);
        terms.regularizer.add_normal(scales.regularizer, &mut normal);
        if settings.scaling == Scaling::Dimensionless {
            scales.hold = HOLD * normal.mean_diagonal();
            (0..grid.handle_count()).for_each(|handle| normal.add(handle, handle, scales.hold));
        }
        terms.pins.add_normal(scales.pins, &mut normal);
        terms.handles.add_normal(scales.handles, &mut normal);
        let factor = Factor::new(&normal).ok_or_else(|| SolveError::Singular {
            what: format!("{:?} with {:?}", settings.energy, settings.regularizer),
            hint: "add a pin, use the `rest` regulariser, or uniform edge weights".into(),
        })?;
        let constraints = Constraints::new(&factor, (&terms, grid.handle_count()), problem.pins, settings);
        Ok(Self {
            grid: grid.clone(),
            settings: settings.clone(),
            distortion,
            normal,
            factor,
            constraints,
            scales,
            pins: problem.pins.to_vec(),
            handles: problem.handles.to_vec(),
            terms,
            is_occupied: occupied::cells(grid, problem.shape),
            warnings,
        })
    }

    /// Solves for the targets the problem was given with.
    #[must_use]
    pub fn solve(&self) -> Solution<D> {
        self.run(&Targets { pins: &self.pins, handles: &self.handles, terms: &self.terms }, None)
    }

    /// Like [`Self::solve`]; `observe` sees the energies on the way, the last ones are the solution's.
    pub(crate) fn solve_observed(&self, mut observe: impl FnMut(Energies)) -> Solution<D> {
        self.run(&Targets { pins: &self.pins, handles: &self.handles, terms: &self.terms }, Some(&mut observe))
    }

    /// Solves for new targets (and wanted gradients) of the same pins and handles.
    ///
    /// # Errors
    /// [`SolveError`] where the pins or handles are not those of the problem, or a target is not a number.
    pub fn update(&self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Solution<D>, SolveError> {
        let terms = self.retargeted(pins, handles)?;
        Ok(self.run(&Targets { pins, handles, terms: &terms }, None))
    }

    /// Which cells of a lattice over the same grid turn over, and whether the shape lies in them.
    #[must_use]
    pub fn folds(&self, lattice: &Lattice<D>) -> Folds<D> {
        lattice.folds(&self.is_occupied)
    }

    /// The terms with other targets for the same pins and handles.
    pub(crate) fn retargeted(&self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Terms<D>, SolveError> {
        super::check::same_pins(&self.pins, pins)?;
        super::check::same_handles(&self.handles, handles)?;
        let mut terms = self.terms.clone();
        pins::retarget(&mut terms.pins, &self.grid, pins, &self.settings);
        for (row, handle) in handles.iter().enumerate() {
            terms.handles.set_target(row, handle.target);
        }
        Ok(terms)
    }

    fn run(&self, targets: &Targets<D>, observe: Option<&mut dyn FnMut(Energies)>) -> Solution<D> {
        let Targets { pins, handles, .. } = *targets;
        if !pins.iter().any(|pin| pin.weight > 0.0) && handles.is_empty() {
            let mut warnings = self.warnings.clone();
            warnings.push("no pins and no moved handles: nothing is warped; add a pin".into());
            let run = Run { handles: self.grid.rest_handles(), iterations: 0, is_converged: true };
            return self.report(&Waypoint { pins: pins.to_vec(), handles: Vec::new() }, run, warnings);
        }
        let run = self.iteration(targets).run(observe);
        let goal = || Waypoint { pins: pins.to_vec(), handles: handles.to_vec() };
        if self.settings.guard == Guard::Limit
            && !self.is_safe(&run.handles)
            && let Ok((run, stopped_at)) = self.walk_straight(&goal())
        {
            return self.finish(&goal(), run, stopped_at);
        }
        self.finish(&goal(), run, None)
    }

    /// Solves for a waypoint, from given handles on.
    pub(crate) fn settle(
        &self,
        waypoint: &Waypoint<D>,
        first: Option<&[[f64; D]]>,
        settings: &Settings,
    ) -> Result<Run<D>, SolveError> {
        let Waypoint { pins, handles } = waypoint;
        let terms = self.retargeted(pins, handles)?;
        let iteration = self.iteration(&Targets { pins, handles, terms: &terms });
        Ok(Iteration { first, settings, ..iteration }.run(None))
    }

    /// The grid at rest.
    pub(crate) fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The settings.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The solution that a run ended with, on its way to `goal`.
    pub(crate) fn finish(&self, goal: &Waypoint<D>, run: Run<D>, stopped_at: Option<f64>) -> Solution<D> {
        let mut warnings = self.warnings.clone();
        warnings.extend(pins::handle_conflicts(&self.grid, &goal.handles));
        if !run.is_converged && self.settings.tolerance > 0.0 {
            let spent = counted(run.iterations, "iteration", "iterations");
            warnings.push(format!("not converged after {spent}; the result may still move"));
        }
        let mut solution = self.report(goal, run, warnings);
        solution.report.stopped_at = stopped_at;
        if stopped_at.is_some() {
            solution.report.pin_misses.iter_mut().for_each(|miss| miss.reason = MissReason::Guard);
        }
        solution
    }

    /// The iteration for given targets.
    pub(crate) fn iteration<'a>(&'a self, targets: &Targets<'a, D>) -> Iteration<'a, D> {
        let rest = self.grid.rest_handles();
        let start = match self.settings.start {
            super::Start::Rest => rest,
            super::Start::RigidFit => {
                let rigid = Rigid::fit(&self.grid, targets.pins, targets.handles);
                rest.iter().map(|handle| rigid.image(handle)).collect()
            }
        };
        Iteration {
            distortion: self.distortion.as_ref(),
            normal: &self.normal,
            factor: &self.factor,
            constraints: &self.constraints,
            scales: self.scales,
            terms: targets.terms,
            settings: &self.settings,
            diagonal: self.grid.diagonal(),
            start,
            first: None,
            finish: Finish::Newton,
        }
    }

    fn report(&self, goal: &Waypoint<D>, run: Run<D>, warnings: Vec<String>) -> Solution<D> {
        let Waypoint { pins, handles } = goal;
        let quality = self.distortion.quality(&run.handles);
        let lattice = Lattice { grid: self.grid.clone(), handles: run.handles };
        let pin_errors: Vec<f64> = pins.iter().map(|pin| self.pin_error(&lattice, pin)).collect();
        let evidence = Evidence {
            pins,
            settings: &self.settings,
            constraints: &self.constraints,
            bounds: [self.grid.lo, self.grid.hi],
            diagonal: self.grid.diagonal(),
        };
        let folds = self.folds(&lattice);
        let report = SolveReport {
            pin_misses: misses::misses(&evidence, &pin_errors),
            pin_errors,
            folded_cells: folds.cells.len(),
            folded_model_cells: folds.occupied_count,
            least_cell_det: folds.least_det,
            least_det: quality.least_det(),
            angular: quality.angular(),
            area: quality.area(),
            handle_errors: handles.iter().map(|held| distance(&lattice.handles[held.index], &held.target)).collect(),
            stopped_at: None,
            iterations: run.iterations,
            is_converged: run.is_converged,
            conflicts: pins::conflicts(&self.grid, pins),
            warnings,
        };
        Solution { lattice, report }
    }

    fn pin_error(&self, lattice: &Lattice<D>, pin: &PointPin<D>) -> f64 {
        let target = pins::held_target(&self.grid, pin, &self.settings);
        let held = pins::held_point(&self.grid, pin, &self.settings);
        distance(&lattice.carry(held), &target)
    }
}

impl Scales {
    fn of<const D: usize>(grid: &Grid<D>, settings: &Settings, mass: f64) -> Self {
        let lambdas = settings.lambdas;
        let [shape, pins] = match settings.scaling {
            Scaling::Plain => [1.0, 1.0],
            // Negative cotangents can leave no mass to divide by.
            Scaling::Dimensionless => [if mass > 0.0 { 1.0 / mass } else { 1.0 }, 1.0 / grid.diagonal().powi(2)],
        };
        Self {
            shape: shape * lambdas.shape,
            pins: pins * lambdas.pins,
            handles: pins * lambdas.handles,
            regularizer: lambdas.regularizer,
            hold: 0.0,
        }
    }
}

fn shape_warnings<const D: usize>(problem: &Problem<D>) -> Vec<String> {
    let Problem { grid, shape, settings, .. } = *problem;
    let is_inside = |corner: &u32| {
        let point = shape.points[*corner as usize];
        (0..D).all(|axis| (grid.lo[axis]..=grid.hi[axis]).contains(&point[axis]))
    };
    let mut warnings: Vec<String> = energy::fitting(shape, settings).1.into_iter().collect();
    let mut corners = shape.triangles.iter().flatten().chain(shape.strokes.iter().flatten());
    let is_empty = shape.triangles.is_empty() && shape.strokes.is_empty();
    if !is_empty && !corners.any(is_inside) {
        warnings.push("no corner of the shape lies inside the lattice box; check the box".into());
    }
    warnings
}
