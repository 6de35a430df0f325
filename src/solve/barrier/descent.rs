//! Newton's method for the energy with the barrier: descends from a state without folds to a minimum without folds.
//!
//! In: points of the barrier, forces of the pins, a state. Out: a minimum. Every step lowers the energy and ends before det J reaches
//! the pole of the potential at any point. Far from the minimum every step has its own factor; near it a factor is reused, with
//! Anderson acceleration, while that costs less than a new one.

use super::points::{BarrierPoints, PenalisedPoint};
use super::potential::{MIN_DET, STRENGTH};
use super::reactions::Reactions;
use crate::solve::cached_factor::CachedFactor;
use crate::solve::cancel::Cancelled;
use crate::solve::energy::RotationHessian;
use crate::solve::factor_reuse::{CONVEXITY_LIMITS, FactorReuse};
use crate::solve::linalg::factorization::Factorization;
use crate::solve::minimization::{Minimization, MinimizationResult, largest_step};

/// Fraction of the distance to the pole that a step may take.
pub(super) const CAUTION: f64 = 0.9;

/// Maximum number of updates of the pins' multipliers.
const ROUNDS: usize = 3;

/// A pin within this distance of its target, in box diagonals, counts as held.
const HELD: f64 = 1e-9;

/// After a step longer than this, in box diagonals, that lowered the energy by more than [`SLOW`], the next step uses a convex
/// matrix: the state is still far from the minimum.
const NEAR: f64 = 1e-2;

/// Fraction of the energy up to which a decrease counts as small.
const SLOW: f64 = 0.1;

/// After a step that was shortened to less than this fraction, the next step uses a convex matrix.
const SHORT: f64 = 0.05;

/// After a step that was shortened to less than this fraction, the factor is not reused.
const SHORTENED: f64 = 0.5;

/// Maximum number of trials of the line search, each with half the step.
const HALVINGS: usize = 20;

/// Armijo constant: the fraction of the linear prediction by which a step must lower the energy.
const DESCENT: f64 = 1e-4;

/// Relative rounding error of energies.
const ROUNDING: f64 = 1e-11;

/// Largest cost of a new factor, in steps with a reused one; that of energies without a second derivative.
const MOST_COSTLY: f64 = 8.0;

pub(super) type Vectors<const D: usize> = Vec<[f64; D]>;

/// A state with its energy and residual, which is minus half the derivative of the energy.
struct State<const D: usize> {
    handles: Vectors<D>,
    energy: f64,
    residual: Vectors<D>,
    penalised: Vec<PenalisedPoint<D>>,
}

impl<const D: usize> Minimization<'_, D> {
    /// Stiffness of the shape: the unit in which the energies of barrier and pins are measured, of the order of the largest shape
    /// energy.
    pub(super) fn stiffness(&self) -> f64 {
        self.scales.shape * self.distortion.mass()
    }
}

/// Returns from + t · by.
fn ahead<const D: usize>(from: &[[f64; D]], by: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(by).map(|(a, b)| std::array::from_fn(|d| t.mul_add(b[d], a[d]))).collect()
}

/// State of the descent.
pub(super) struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    points: &'a BarrierPoints<D>,
    reactions: Reactions<'a, D>,
    iterations: usize,
    /// Index into [`CONVEXITY_LIMITS`]: 0 is the true second derivative, higher levels are convex matrices.
    level: usize,
    cached: CachedFactor,
    reuse: FactorReuse,
}

impl<'a, const D: usize> Descent<'a, D> {
    /// Prepares a descent. Without a factor it starts with a convex matrix.
    pub(super) fn new(
        (problem, points): (&'a Minimization<'a, D>, &'a BarrierPoints<D>),
        reactions: Reactions<'a, D>,
        iterations: usize,
        mut cached: CachedFactor,
    ) -> Self {
        cached.clear_convex_state();
        Self {
            problem,
            points,
            reactions,
            iterations,
            level: usize::from(!cached.is_some()),
            cached,
            reuse: FactorReuse::new(problem.factor_cost().min(MOST_COSTLY)),
        }
    }

    /// The factor at the minimum, if it is that of the true second derivative, and the forces of the pins.
    pub(super) fn into_cached(self) -> CachedFactor {
        self.cached
    }

    /// Minimises the energy, and updates the multipliers to the forces of the pins after each minimum.
    pub(super) fn run(&mut self, first: Vectors<D>) -> Result<MinimizationResult<D>, Cancelled> {
        let problem = self.problem;
        let mut handles = first;
        let mut is_converged = false;
        for _ in 0..ROUNDS {
            (handles, is_converged) = self.minimized(handles)?;
            if self.reactions.update_multipliers(&handles) <= HELD * problem.diagonal {
                break;
            }
        }
        let has_given_way = self.reactions.any_yields(&handles);
        if !has_given_way {
            problem.constraints.enforce(problem.terms, &mut Vec::new(), &mut handles);
        }
        let is_near = |at: &[[f64; D]]| largest_step(at, &handles) <= NEAR * problem.diagonal;
        let is_checked = self.level == 0 && self.cached.convex_state().is_some_and(is_near);
        let is_minimum = (is_converged && is_checked).then_some(true);
        if !is_converged || self.level > 0 {
            self.cached.discard_factor();
        }
        self.cached.set_forces(self.reactions.multipliers());
        Ok(MinimizationResult {
            handles,
            iterations: self.iterations,
            is_converged,
            has_given_way,
            is_minimum,
            energy: None,
        })
    }

    /// Returns the minimum for the present multipliers, and whether the steps converged.
    fn minimized(&mut self, first: Vectors<D>) -> Result<(Vectors<D>, bool), Cancelled> {
        let problem = self.problem;
        let tolerance = problem.settings.tolerance.max(1e-10) * problem.diagonal;
        let mut state = self.state(first)?;
        self.restart(false);
        let last = self.iterations + problem.settings.iteration_limit;
        while self.iterations < last {
            self.iterations += 1;
            let by = self.direction(&state)?;
            let full = ahead(&state.handles, &by, 1.0);
            let length = largest_step(&state.handles, &full);
            self.reuse.record(length);
            if self.reuse.is_done(tolerance) {
                let is_open = self.points.max_step(&state.handles, &full, MIN_DET) >= 1.0;
                return Ok((if is_open { full } else { state.handles }, true));
            }
            match self.searched(&state, &by, full)? {
                Some(next) => {
                    let moved = largest_step(&state.handles, &next.handles);
                    let is_near = state.energy - next.energy <= SLOW * state.energy || moved <= NEAR * problem.diagonal;
                    let is_reusable = self.level == 0 && moved >= SHORTENED * length && !self.reuse.is_stale(tolerance);
                    self.level = usize::from(!is_near || moved < SHORT * length);
                    if self.level > 0 || !is_reusable {
                        self.cached.discard_factor();
                    }
                    state = next;
                }
                None if !self.reuse.is_fresh || !self.reuse.is_first() => self.cached.discard_factor(),
                None if self.level < CONVEXITY_LIMITS.len() - 1 => {
                    self.cached.discard_factor();
                    self.level += 1;
                }
                None => break,
            }
        }
        Ok((state.handles, false))
    }

    fn restart(&mut self, is_fresh: bool) {
        self.reuse.is_fresh = is_fresh;
        self.reuse.clear();
    }

    fn state(&self, handles: Vectors<D>) -> Result<State<D>, Cancelled> {
        let problem = self.problem;
        let mut residual = problem.constant_right_side();
        let mut energy = problem.local_energy(&handles, &mut residual);
        problem.cancel.check()?;
        let scale = STRENGTH * problem.stiffness();
        let (barrier, penalised) = self.points.energy(&handles);
        energy += scale * barrier;
        self.points.subtract_derivative(scale, &penalised, &mut residual);
        energy += self.reactions.correct(&handles, &mut residual);
        problem.normal.subtract_matvec(&handles, &mut residual);
        Ok(State { handles, energy, residual, penalised })
    }

    /// Returns the accelerated state if it lowers the energy, else one along `by`, which leads to `full`.
    fn searched(&mut self, state: &State<D>, by: &[[f64; D]], full: Vectors<D>) -> Result<Option<State<D>>, Cancelled> {
        let has_history = self.reuse.anderson.has_history();
        let mut accelerated = full.clone();
        self.reuse.anderson.step(&state.handles, &mut accelerated);
        if has_history {
            if self.points.max_step(&state.handles, &accelerated, MIN_DET) >= 1.0 {
                let next = self.state(accelerated)?;
                if next.energy <= state.energy + ROUNDING * state.energy.abs() {
                    return Ok(Some(next));
                }
            }
            self.reuse.anderson.reset();
        }
        self.line_search(state, by, full)
    }

    /// Line search along `by` (backtracking with the Armijo condition); `None` if no trial lowers the energy enough.
    fn line_search(
        &mut self,
        state: &State<D>,
        by: &[[f64; D]],
        full: Vectors<D>,
    ) -> Result<Option<State<D>>, Cancelled> {
        let way = self.points.max_step(&state.handles, &full, MIN_DET);
        let mut step_length = if way < 1.0 { CAUTION * way } else { 1.0 };
        let slope: f64 = state.residual.as_flattened().iter().zip(by.as_flattened()).map(|(x, y)| 2.0 * x * y).sum();
        for _ in 0..HALVINGS {
            let next = self.state(ahead(&state.handles, by, step_length))?;
            if next.energy <= state.energy - DESCENT * step_length * slope + ROUNDING * state.energy.abs() {
                return Ok(Some(next));
            }
            self.reuse.anderson.reset();
            step_length *= 0.5;
        }
        Ok(None)
    }

    /// Returns the Newton step; if there is no factor, the constant matrix of the local-global steps takes its place.
    fn direction(&mut self, state: &State<D>) -> Result<Vectors<D>, Cancelled> {
        if !self.cached.is_some() {
            self.refactor(state)?;
        }
        let mut by = state.residual.clone();
        match self.cached.factor() {
            Some(factor) => factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0),
            None => self.problem.factor.solve(&mut by),
        }
        Ok(by)
    }

    /// Factors the second derivative at a state. Raises the level until the matrix is positive definite; leaves no factor if none
    /// is.
    fn refactor(&mut self, state: &State<D>) -> Result<(), Cancelled> {
        let Self { problem, points, .. } = *self;
        let Minimization { distortion, cancel, .. } = *problem;
        self.restart(true);
        let scale = STRENGTH * problem.stiffness();
        let wide = problem.normal.widened(points.bandwidth());
        while let Some(&limit) = CONVEXITY_LIMITS.get(self.level) {
            let is_convex = self.level > 0;
            let mut second = wide.kron_identity::<D>(self.cached.take_buffer());
            let hessian = RotationHessian { scale: problem.scales.shape, limit };
            distortion.subtract_rotation_hessian(&state.handles, hessian, &mut second, cancel);
            points.add_curvature(scale, &state.penalised, is_convex, &mut second);
            self.reactions.correct_curvature(&state.handles, is_convex, &mut second);
            cancel.check()?;
            self.cached.set_factor(Factorization::of_positive(second, cancel));
            cancel.check()?;
            if self.cached.is_some() {
                if !is_convex {
                    self.cached.set_convex_state(&state.handles);
                }
                return Ok(());
            }
            self.level += 1;
        }
        self.level = CONVEXITY_LIMITS.len() - 1;
        Ok(())
    }
}
