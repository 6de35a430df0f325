//! Drags: the lattice follows moving pins, reusing a factorised second derivative from move to move.
//!
//! In: a solver and a start lattice, then targets, move by move. Out: a lattice per move, and a solution when the drag settles.
//! The first step of a move goes along the tangent of the last state; two or three corrections follow, each one triangular solve.

use super::branching::BranchedLattice;
use super::cached_factor::CachedFactor;
use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::{FinalPhase, Minimization, MinimizationResult, largest_step};
use super::problem::{HandlePin, PointPin};
use super::report::Solution;
use super::settings::Settings;
use super::solver::{CancellableSolver, Solver};
use super::targets::Targets;
use crate::lattice::Lattice;
use crate::spelling::pluralised;

/// Maximum number of Newton steps per move.
const STEPS: usize = 5;

/// Maximum number of local-global steps per move where Newton's method is not available, so that the drag keeps up with the hand.
const LOCAL_GLOBAL_STEPS: usize = 14;

/// A move also ends when no handle moves farther than this fraction of the box diagonal and a tenth of it is estimated to remain:
/// less than a hundredth of a pixel at 1080 lines.
const TOLERANCE: f64 = 3e-5;

/// `settle` checks the second derivative again if a handle has moved farther than this fraction of the box diagonal since the
/// last check.
const UNCHECKED: f64 = 0.02;

/// A drag in progress. Where the energy has several minima, the result depends on the path of the pins, unlike that of a solve.
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
/// let mut drag = solver.drag(&solver.solve().lattice)?;
/// for step in 1..=10 {
///     pin.target[0] = 0.5 + 0.02 * f64::from(step);
///     let lattice = drag.follow(&[pin], &[])?;
///     assert!((lattice.evaluate([0.5, 0.9])[0] - pin.target[0]).abs() < 1e-6);
/// }
/// assert!(drag.settle(&[pin], &[])?.report.is_converged);
/// # Ok::<(), pinwarp::solve::SolveError>(())
/// ```
#[derive(Debug)]
pub struct Drag<'a, const D: usize> {
    solver: &'a Solver<D>,
    /// Positions of the unknowns over the upright box: the handles, or their copies where the lattice branches.
    handles: Vec<[f64; D]>,
    factor: CachedFactor,
    /// State at which the second derivative was last checked.
    checked: Option<Vec<[f64; D]>>,
    cancel: Option<&'a Cancel<'a>>,
}

/// What a move may cost at most.
struct MoveLimits {
    /// Number of steps where Newton's method is available.
    newton_steps: usize,
    /// Number of steps where it is not.
    local_global_steps: usize,
    /// Number of new factorisations.
    factorizations: usize,
}

impl<const D: usize> Solver<D> {
    /// Starts a drag from a plain lattice, usually that of the last solution.
    ///
    /// # Errors
    /// [`SolveError`] if the lattice has a different number of handles or if the lattice of the solver branches.
    pub fn drag(&self, from: &Lattice<D>) -> Result<Drag<'_, D>, SolveError> {
        if self.system().has_branches() {
            return Err(SolveError::Invalid {
                what: "the drag needs all branches, because the lattice of this solver branches".into(),
                hint: "start from a complete solution: `drag_from`".into(),
            });
        }
        self.drag_unknowns(&from.handles)
    }

    /// Starts a drag from a solution of this solver, with all its branches.
    ///
    /// # Errors
    /// [`SolveError`] if the solution belongs to another solver.
    pub fn drag_from(&self, from: &Solution<D>) -> Result<Drag<'_, D>, SolveError> {
        let own = |branches: &BranchedLattice<D>| {
            self.system().has_pieces_of(branches) || self.box_rotation().has_pieces_of(branches)
        };
        match &from.branches {
            Some(branches) if own(branches) => self.drag_unknowns(branches.copies()),
            None if !self.system().has_branches() => self.drag_unknowns(&from.lattice.handles),
            _ => Err(SolveError::Invalid {
                what: "the drag starts from a solution with other branches".into(),
                hint: "start from a solution of the same solver".into(),
            }),
        }
    }

    fn drag_unknowns(&self, from: &[[f64; D]]) -> Result<Drag<'_, D>, SolveError> {
        let (found, wanted) = (from.len(), self.system().rest().len());
        if found != wanted {
            return Err(SolveError::Invalid {
                what: format!("the drag starts from {}, the grid has {wanted}", pluralised(found, "handle", "handles")),
                hint: "start from a solution of the same solver".into(),
            });
        }
        let handles = self.box_rotation().upright().points(from);
        Ok(Drag { solver: self, handles, factor: CachedFactor::default(), checked: None, cancel: None })
    }
}

impl<'a, const D: usize> CancellableSolver<'a, D> {
    /// Same as [`Solver::drag`], but cancellable. A cancelled move leaves the drag in its previous state.
    ///
    /// # Errors
    /// Those of [`Solver::drag`].
    pub fn drag(&self, from: &Lattice<D>) -> Result<Drag<'a, D>, SolveError> {
        Ok(Drag { cancel: Some(self.cancel), ..self.solver.drag(from)? })
    }
}

impl<const D: usize> Drag<'_, D> {
    /// Moves pins and handles to new targets in a few steps, without a report. Pins reach their targets at once; the shape
    /// follows in the same move or, after a jump, within a few moves (docs/METHOD.md, "Convergence", gives the lag). Returns the
    /// largest branch of a lattice that branches.
    ///
    /// # Errors
    /// Those of [`Solver::update`].
    pub fn follow(&mut self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Lattice<D>, SolveError> {
        let settings = Settings { tolerance: TOLERANCE, ..self.solver.system().settings().clone() };
        // At most one factorisation per move, at its start, so that all moves take about the same time.
        let factorizations = usize::from(!self.factor.is_some());
        let limits = MoveLimits { newton_steps: STEPS, local_global_steps: LOCAL_GLOBAL_STEPS, factorizations };
        let box_rotation = self.solver.box_rotation();
        self.run(&box_rotation.upright().targets(pins, handles), &settings, limits)?;
        Ok(match self.branches() {
            Some(branches) => branches.lattice(0),
            None => {
                let grid = self.solver.system().grid().clone();
                box_rotation.lattice(Lattice { grid, handles: self.handles.clone() })
            }
        })
    }

    /// Branches after the last move; `None` where the lattice of the solver is plain.
    #[must_use]
    pub(crate) fn branches(&self) -> Option<BranchedLattice<D>> {
        let upright = self.solver.system().branches(&self.handles)?;
        Some(self.solver.box_rotation().branches(upright))
    }

    /// Moves pins and handles to new targets, converges to the tolerance of the settings and returns a report. Call it at the end
    /// of a drag, or for every move. If a handle has moved by more than a fiftieth of the box diagonal since the last check, the
    /// second derivative is checked, and the solve leaves a saddle; a second derivative that the move itself has factored counts as
    /// checked.
    ///
    /// # Errors
    /// Those of [`Solver::update`].
    pub fn settle(&mut self, pins: &[PointPin<D>], handles: &[HandlePin<D>]) -> Result<Solution<D>, SolveError> {
        let box_rotation = self.solver.box_rotation();
        let goal = box_rotation.upright().targets(pins, handles);
        let settings = self.solver.system().settings().clone();
        let steps = settings.iteration_limit;
        let limits = MoveLimits { newton_steps: steps, local_global_steps: steps, factorizations: usize::MAX };
        let mut run = self.run(&goal, &settings, limits)?;
        let unchecked = UNCHECKED * self.solver.system().grid().diagonal();
        if run.is_converged && self.checked.as_ref().is_none_or(|at| largest_step(at, &run.handles) > unchecked) {
            let is_near = |at: &&[[f64; D]]| largest_step(at, &run.handles) <= unchecked;
            let convex = self.factor.convex_state().filter(is_near);
            if let Some(at) = convex.filter(|_| self.solver.system().is_free_of_barrier(&run.handles)) {
                self.checked = Some(at.to_vec());
                run.is_minimum = Some(true);
            } else {
                run = self.solver.system().leave_saddle(run, &goal, self.cancel.unwrap_or(&Cancel::never()))?;
                self.handles.clone_from(&run.handles);
                self.checked = Some(run.handles.clone());
            }
        }
        let is_held = pins.iter().any(|pin| pin.weight > 0.0) || !handles.is_empty();
        if is_held {
            return Ok(box_rotation.solution(self.solver.system().finish(&goal, run)));
        }
        let never = Cancel::never();
        let solution = self.solver.with_cancel(self.cancel.unwrap_or(&never)).update(pins, handles)?;
        let unknowns = solution.branches.as_ref().map_or(&*solution.lattice.handles, BranchedLattice::copies);
        self.handles = box_rotation.upright().points(unknowns);
        Ok(solution)
    }

    /// Takes one move.
    fn run(
        &mut self,
        targets: &Targets<D>,
        settings: &Settings,
        limits: MoveLimits,
    ) -> Result<MinimizationResult<D>, SolveError> {
        let (system, never) = (self.solver.system(), Cancel::never());
        let cancel = self.cancel.unwrap_or(&never);
        let to = system.retargeted(targets, cancel)?;
        let minimization = system.minimization(&system.targets(targets, &to), cancel);
        let has_newton = minimization.has_newton();
        let iteration_limit = if has_newton { limits.newton_steps } else { limits.local_global_steps };
        let settings = Settings { iteration_limit, ..settings.clone() };
        let has_factorizations = limits.factorizations > 1;
        let final_phase = if has_factorizations { FinalPhase::Newton } else { FinalPhase::LocalGlobal };
        let minimization =
            Minimization { initial: Some(&self.handles), settings: &settings, final_phase, ..minimization };
        let mut run = if has_newton {
            minimization.newton_from(self.handles.clone(), &mut self.factor, limits.factorizations)?
        } else {
            minimization.run(None)?
        };
        if has_factorizations && settings.acceleration > 0 {
            run.energy = Some(minimization.energy(&run.handles));
        }
        self.handles.clone_from(&run.handles);
        Ok(run)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::{Basis, Grid};
    use crate::solve::problem::{Problem, Shape};
    use crate::solve::report::Stationarity;

    #[test]
    fn a_second_derivative_that_a_move_has_factored_counts_as_checked() {
        let grid = Grid { dims: [8, 8], basis: Basis::Bspline, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
        let shape =
            Shape::of_triangles(vec![[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]], vec![[0, 1, 2], [0, 2, 3]]);
        let pins = |x: f64| {
            [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9]].map(|at| PointPin::new(at, if at[1] > 0.5 { [x, 0.9] } else { at }))
        };
        let settings = Settings::default();
        let rest = pins(0.9);
        let problem = Problem { grid: &grid, shape: &shape, pins: &rest, handles: &[], settings: &settings };
        let solver = Solver::new(&problem).expect("a valid problem");
        let mut drag = solver.drag(&grid.at_rest()).expect("a lattice of the solver");
        let settled = drag.settle(&pins(0.905), &[]).expect("the same pins");
        assert_eq!(settled.report.stationarity, Stationarity::Minimum);
        let convex = drag.factor.convex_state::<2>().expect("the first move factors the second derivative").to_vec();
        assert_eq!(drag.checked, Some(convex));
    }
}
