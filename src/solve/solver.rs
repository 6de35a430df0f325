//! The solver: factors a problem once, then solves it for any number of targets.
//!
//! In: grid, shape, pins, handles, settings; later only targets, or paths of targets. Out: solutions.

use super::box_rotation::BoxRotation;
use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::Energies;
use super::prefactored::TargetTerms;
use super::problem::{HandlePin, PointPin, Problem};
use super::report::Solution;
use super::settings::Minima;
use super::system::{Parts, System};
use super::targets::Targets;
use super::upright::Upright;
use crate::lattice::{Folds, Lattice};

/// Solves a problem for its handles.
///
/// # Errors
/// [`SolveError`] if the problem is malformed (dims, indices, non-finite numbers) or the factorisation fails.
pub fn solve<const D: usize>(problem: &Problem<D>) -> Result<Solution<D>, SolveError> {
    Ok(Solver::new(problem)?.solve())
}

/// A problem with its factored matrix, for fixed grid, shape, pinned points and moved handles.
///
/// ```
/// use pinwarp::lattice::{Basis, Grid};
/// use pinwarp::solve::{PointPin, Problem, Settings, Shape, Solver};
/// let grid = Grid { dims: [6, 6], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.0, 1.0], angle: 0.0 };
/// let shape = Shape::of_triangles(vec![[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]], vec![[0, 1, 2]]);
/// let mut pin = PointPin::new([0.5, 0.9], [0.5, 0.9]);
/// let settings = Settings::default();
/// let problem = Problem { grid: &grid, shape: &shape, pins: &[pin], handles: &[], settings: &settings };
/// let solver = Solver::new(&problem)?;
/// pin.target = [0.7, 0.9];
/// let solution = solver.update(&[pin], &[])?;
/// let moved = solution.lattice.evaluate([0.5, 0.5]);
/// assert!((moved[0] - 0.7).abs() < 1e-6 && (moved[1] - 0.5).abs() < 1e-6);
/// # Ok::<(), pinwarp::solve::SolveError>(())
/// ```
#[derive(Debug)]
pub struct Solver<const D: usize> {
    /// The system of the upright box.
    system: System<D>,
    box_rotation: BoxRotation<D>,
}

impl<const D: usize> Solver<D> {
    /// Samples the shape and factors the matrix.
    ///
    /// # Errors
    /// [`SolveError`] if the problem is malformed or its matrix is singular.
    pub fn new(problem: &Problem<D>) -> Result<Self, SolveError> {
        Self::build(problem, &Cancel::never())
    }

    /// Same as [`Self::new`], but cancellable.
    ///
    /// # Errors
    /// Those of [`Self::new`], and [`SolveError::Cancelled`].
    pub(crate) fn build(problem: &Problem<D>, cancel: &Cancel) -> Result<Self, SolveError> {
        problem.grid.check()?;
        let upright = Upright::of(problem.grid);
        let (pins, handles) = (upright.pins(problem.pins), upright.handles(problem.handles));
        let (grid, shape) = (problem.grid.upright(), upright.shape(problem.shape));
        let problem_upright =
            Problem { grid: &grid, shape: &shape, pins: &pins, handles: &handles, settings: problem.settings };
        let system = System::new(&problem_upright, cancel)?;
        Ok(Self { box_rotation: BoxRotation::new(problem.grid, system.branching()), system })
    }

    /// Factors a checked problem from components that are already built.
    pub(crate) fn assemble(problem: &Problem<D>, parts: Parts<D>) -> Result<Self, SolveError> {
        debug_assert!(problem.grid.angle == 0.0, "the box is upright");
        let mut system = System::assemble(problem, parts, &Cancel::never())?;
        system.mark_active_cells(problem.shape);
        Ok(Self { box_rotation: BoxRotation::new(problem.grid, None), system })
    }

    /// Returns the solver with a hook that may cancel its solves.
    #[must_use]
    pub const fn with_cancel<'a>(&'a self, cancel: &'a Cancel<'a>) -> CancellableSolver<'a, D> {
        CancellableSolver { solver: self, cancel }
    }

    /// Solves for the targets in the problem.
    #[must_use]
    pub fn solve(&self) -> Solution<D> {
        self.with_cancel(&Cancel::never()).solve().expect("the targets are checked, and nothing cancels the solve")
    }

    /// Same as [`Self::solve`]; `observe` receives the energies of every step, and at the end those of the solution.
    pub(crate) fn solve_observed(&self, mut observe: impl FnMut(Energies)) -> Solution<D> {
        let solved = self.with_cancel(&Cancel::never()).run(&self.system.own_targets(), Some(&mut observe));
        solved
            .map(|solution| self.box_rotation.solution(solution))
            .expect("the targets are checked, and nothing cancels the solve")
    }

    /// Solves for new targets and prescribed gradients of the same pins and handles.
    ///
    /// # Errors
    /// [`SolveError`] if the pins or handles are not those of the problem, or a target is not finite.
    pub fn update(&self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Solution<D>, SolveError> {
        self.with_cancel(&Cancel::never()).update(pins, handles)
    }

    /// Solves for the last targets of a path. If the path winds parts of the shape (in 2D, if pairs of pins rotate against each
    /// other by more than 150 degrees), it determines the direction and number of turns, and every step is solved from the
    /// previous one. Otherwise this is [`Self::update`], and the path does not matter.
    ///
    /// # Errors
    /// Those of [`Self::update`], for any targets of the path.
    pub fn follow(&self, path: &[Targets<D>]) -> Result<Solution<D>, SolveError> {
        self.with_cancel(&Cancel::never()).follow(path)
    }

    /// Returns the folded cells of a lattice over the same grid, and which of them are active.
    #[must_use]
    pub(crate) fn folds(&self, lattice: &Lattice<D>) -> Folds<D> {
        self.system.folds(lattice)
    }

    /// The factored problem of the upright box.
    pub(crate) fn system(&self) -> &System<D> {
        &self.system
    }

    /// The box of the problem.
    pub(crate) const fn box_rotation(&self) -> &BoxRotation<D> {
        &self.box_rotation
    }
}

/// A [`Solver`] whose solves may be cancelled.
#[derive(Clone, Copy, Debug)]
pub struct CancellableSolver<'a, const D: usize> {
    pub(crate) solver: &'a Solver<D>,
    pub(crate) cancel: &'a Cancel<'a>,
}

impl<const D: usize> CancellableSolver<'_, D> {
    /// Same as [`Solver::solve`].
    ///
    /// # Errors
    /// [`SolveError::Cancelled`].
    pub fn solve(&self) -> Result<Solution<D>, SolveError> {
        let solution = self.run(&self.solver.system.own_targets(), None)?;
        Ok(self.solver.box_rotation.solution(solution))
    }

    /// Same as [`Solver::update`].
    ///
    /// # Errors
    /// Those of [`Solver::update`], and [`SolveError::Cancelled`].
    pub fn update(&self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Solution<D>, SolveError> {
        let Solver { system, box_rotation } = self.solver;
        let targets = box_rotation.upright().targets(pins, handles);
        let to = system.retargeted(&targets, self.cancel)?;
        Ok(box_rotation.solution(self.run(&system.targets(&targets, &to), None)?))
    }

    /// Same as [`Solver::follow`].
    ///
    /// # Errors
    /// Those of [`Solver::follow`], and [`SolveError::Cancelled`].
    pub fn follow(&self, path: &[Targets<D>]) -> Result<Solution<D>, SolveError> {
        let Some(goal) = path.last() else { return self.solve() };
        let Solver { system, box_rotation } = self.solver;
        let upright = box_rotation.upright().path(path);
        match system.follow_winding(&upright, self.cancel)? {
            Some(result) => Ok(box_rotation.solution(system.finish(upright.last().unwrap_or(goal), result))),
            None => self.update(&goal.pins, &goal.handles),
        }
    }

    fn run(
        &self,
        targets: &TargetTerms<D>,
        observe: Option<&mut dyn FnMut(Energies)>,
    ) -> Result<Solution<D>, SolveError> {
        let system = &self.solver.system;
        let goal = targets.goal;
        if !goal.pins.iter().any(|pin| pin.weight > 0.0) && goal.handles.is_empty() {
            return Ok(system.unmoved(goal));
        }
        let result = match system.settings().minima {
            Minima::Least => system.least(targets, observe, self.cancel)?,
            Minima::Nearest => system.minimization(targets, self.cancel).run(observe)?,
        };
        self.cancel.check()?;
        Ok(system.finish(goal, result))
    }
}
