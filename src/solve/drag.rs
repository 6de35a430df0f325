//! Drags: the lattice follows pins from move to move, with the factor of a second derivative that serves for many of them.
//!
//! In: a solver, a lattice to start from; then targets, move by move. Out: lattices, at the end a solution.
//! A move is a step along the tangent of the last state and two or three corrections: each a triangular solve.

use super::iterate::{Iteration, Run};
use super::newton::{Finish, Kept};
use super::solver::{Solver, Targets};
use super::waypoint::Waypoint;
use super::{Guard, HandlePin, PointPin, Settings, Solution, SolveError};
use crate::lattice::Lattice;
use crate::spelling::counted;

/// Most steps of a move with a second derivative at hand.
const STEPS: usize = 5;

/// Most local-global steps of a move without one, so that it keeps pace with the hand.
const LOCAL_GLOBAL_STEPS: usize = 14;

/// A move also ends when no handle moves farther than this part of the box diagonal, and a tenth of it is left: a hundredth
/// of a pixel at 1080 lines.
const TOLERANCE: f64 = 3e-5;

/// A drag under way. What it gives depends on the way of the pins, where there is more than one rest; a solve does not.
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
/// let mut drag = solver.drag(&solver.solve().lattice)?;
/// for step in 1..=10 {
///     pin.target[0] = 0.5 + 0.02 * f64::from(step);
///     let lattice = drag.follow(&[pin], &[])?;
///     assert!((lattice.carry([0.5, 0.9])[0] - pin.target[0]).abs() < 1e-6);
/// }
/// assert!(drag.settle(&[pin], &[])?.report.is_converged);
/// # Ok::<(), pinwarp::solve::SolveError>(())
/// ```
#[derive(Debug)]
pub struct Drag<'a, const D: usize> {
    solver: &'a Solver<D>,
    handles: Vec<[f64; D]>,
    kept: Kept,
}

impl<const D: usize> Solver<D> {
    /// Begins a drag from a lattice, mostly the last solution.
    ///
    /// # Errors
    /// [`SolveError`] where the lattice has another number of handles.
    pub fn drag(&self, from: &Lattice<D>) -> Result<Drag<'_, D>, SolveError> {
        let (found, wanted) = (from.handles.len(), self.grid().handle_count());
        if found != wanted {
            return Err(SolveError::Invalid {
                what: format!("the drag starts from {}, the grid has {wanted}", counted(found, "handle", "handles")),
                hint: "start from a solution of the same solver".into(),
            });
        }
        Ok(Drag { solver: self, handles: from.handles.clone(), kept: Kept::default() })
    }
}

impl<const D: usize> Drag<'_, D> {
    /// Follows the pins of the problem to new targets in a few steps, without a report. Pins arrive at once; the shape
    /// follows in the same move or, after a jump, within a few (docs/METHOD.md, "Convergence", has how far it lags).
    ///
    /// # Errors
    /// As [`Solver::update`].
    pub fn follow(&mut self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Lattice<D>, SolveError> {
        let settings = Settings { tolerance: TOLERANCE, ..self.solver.settings().clone() };
        // A factor is made at the beginning of a move or not at all, so that no move takes much longer than others.
        let factors = usize::from(!self.kept.is_some());
        self.run(pins, handles, (&settings, [STEPS, LOCAL_GLOBAL_STEPS], factors))?;
        Ok(Lattice { grid: self.solver.grid().clone(), handles: self.handles.clone() })
    }

    /// Follows to the tolerance of the settings, with a report: the end of a drag, or every move of one.
    ///
    /// # Errors
    /// As [`Solver::update`].
    pub fn settle(&mut self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Solution<D>, SolveError> {
        let settings = self.solver.settings().clone();
        let limit = settings.iteration_limit;
        let run = self.run(pins, handles, (&settings, [limit; 2], usize::MAX))?;
        let is_held = pins.iter().any(|pin| pin.weight > 0.0) || !handles.is_empty();
        if is_held && (settings.guard == Guard::Report || self.solver.is_safe(&self.handles)) {
            let goal = Waypoint { pins: pins.to_vec(), handles: handles.to_vec() };
            return Ok(self.solver.finish(&goal, run, None));
        }
        let solution = self.solver.update(pins, handles)?;
        self.handles.clone_from(&solution.lattice.handles);
        Ok(solution)
    }

    /// Moves on; limits of steps with and without a second derivative, and of new factors.
    fn run(
        &mut self,
        pins: &[PointPin<D>],
        handles: &[HandlePin<D>],
        (settings, limits, factors): (&Settings, [usize; 2], usize),
    ) -> Result<Run<D>, SolveError> {
        let terms = self.solver.retargeted(pins, handles)?;
        let iteration = self.solver.iteration(&Targets { pins, handles, terms: &terms });
        let knows_newton = iteration.knows_newton();
        let settings = Settings { iteration_limit: limits[usize::from(!knows_newton)], ..settings.clone() };
        let run = if knows_newton {
            Iteration { settings: &settings, ..iteration }.descend(self.handles.clone(), &mut self.kept, factors)
        } else {
            let finish = if factors > 1 { Finish::Newton } else { Finish::LocalGlobal };
            Iteration { first: Some(&self.handles), settings: &settings, finish, ..iteration }.run(None)
        };
        self.handles.clone_from(&run.handles);
        Ok(run)
    }
}
