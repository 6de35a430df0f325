//! Newton's method, which ends an iteration where local-global steps converge slowly.
//!
//! In: a state near the solution. Out: converged handles, usually with one factorisation. A factorisation is reused, with
//! Anderson acceleration, while that costs less than a new one. Where a step would raise the energy, convexified matrices and
//! finally the local-global step are tried.

use super::cached_factor::CachedFactor;
use super::cancel::Cancelled;
use super::energy::RotationHessian;
use super::factor_reuse::{CONVEXITY_LIMITS, FactorReuse, steps_left};
use super::linalg::factorization::Factorization;
use super::minimization::FinalPhase;
use super::minimization::{Minimization, MinimizationResult, SAFEGUARD, largest_step};

/// Number of local-global steps before Newton's method where these converge slowly. They can rotate parts farther than a step
/// along the tangent.
const FIRST_STEPS: usize = 8;

/// Number of steps over which the convergence rate is measured.
const SPAN: usize = 5;

/// Newton's method takes over when a local-global step is at most this long, in box diagonals.
const NEAR: f64 = 3e-3;

/// A factorisation whose last step exceeds this many tolerances is not reused for the next move.
const STALE: f64 = 3.0;

/// Length of a step, in box diagonals, below which it is rounding error: the state has converged, however flat the energy is. The
/// first step from the rigid fit only has to be below the tolerance, because where all pins move rigidly, weakly constrained
/// parts do so too.
const AT_REST: f64 = 1e-10;

/// Step lengths that are tried where the full step would raise the energy; trying them costs no solve.
const STEP_LENGTHS: [f64; 3] = [0.5, 0.25, 0.0625];

/// Decides when Newton's method takes over, from the convergence rate of the local-global steps and the relative cost of Newton's
/// method.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSwitch {
    /// Lengths of all steps so far.
    steps: Vec<f64>,
    /// Cost of a Newton matrix and its factorisation, in local-global steps.
    matrix: f64,
    /// Length of a step at which Newton's method takes over.
    near: f64,
    /// The iteration has converged if the first step is at most `tolerance`, or a later one at most `rest`.
    tolerance: f64,
    rest: f64,
}

impl NewtonSwitch {
    /// Creates the switch; `None` if Newton's method is not available.
    pub(crate) fn of<const D: usize>(problem: &Minimization<D>) -> Option<Self> {
        let is_wanted = problem.settings.acceleration > 0 && problem.final_phase == FinalPhase::Newton;
        let flops = problem.distortion.flops().filter(|_| is_wanted)?;
        let [factor, _] = problem.normal.flops(D);
        let [_, solve] = problem.normal.flops(1);
        let tolerance = problem.settings.tolerance * problem.diagonal;
        let rest = AT_REST * problem.diagonal;
        let near = if problem.normal.is_banded_enough() { NEAR * problem.diagonal } else { tolerance.max(rest) };
        let matrix = (flops.rotation_hessian + factor) / (flops.local_step + D as f64 * solve);
        Some(Self { steps: Vec::new(), matrix, near, tolerance, rest })
    }

    /// Records the length of a step; returns true if Newton's method takes over after it.
    pub(crate) fn should_switch(&mut self, step: f64) -> bool {
        self.steps.push(step);
        let count = self.steps.len();
        let rest = if count == 1 { self.tolerance } else { self.rest };
        if step <= rest {
            return false;
        }
        step <= self.near && self.near > self.tolerance
            || count >= FIRST_STEPS && steps_left(step / self.near, self.rate()) > self.matrix
    }

    /// Convergence rate of the last [`SPAN`] steps.
    fn rate(&self) -> f64 {
        let count = self.steps.len();
        (self.steps[count - 1] / self.steps[count - 1 - SPAN]).powf(1.0 / SPAN as f64)
    }
}

impl<const D: usize> Minimization<'_, D> {
    /// Continues from `handles`. `iterations` is the number of linear solves so far, each of which counts as an iteration.
    /// `notify` receives every accepted iterate and the result.
    pub(crate) fn newton(
        &self,
        handles: &[[f64; D]],
        mut iterations: usize,
        notify: &mut dyn FnMut(&[[f64; D]]),
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let mut descent = Descent::new(self, handles.to_vec(), CachedFactor::default())?;
        let mut is_converged = false;
        while !is_converged && iterations < self.settings.iteration_limit {
            iterations += 1;
            let step = descent.step()?;
            is_converged = step == StepOutcome::Converged;
            if step == StepOutcome::Accepted {
                notify(&descent.iterate.handles);
            }
        }
        let mut handles = descent.iterate.handles;
        self.constraints.enforce(self.terms, &mut Vec::new(), &mut handles);
        notify(&handles);
        Ok(MinimizationResult::of(handles, iterations, is_converged))
    }

    /// Whether Newton's method is available and cheap.
    pub(crate) fn has_newton(&self) -> bool {
        self.settings.acceleration > 0 && self.distortion.flops().is_some() && self.normal.is_banded_enough()
    }

    /// Continues from handles that had converged for similar targets, with the factorisation `cached` there and at most `factors`
    /// new ones. A factorisation whose last step was too long is not kept in the cache.
    pub(crate) fn newton_from(
        &self,
        mut handles: Vec<[f64; D]>,
        cached: &mut CachedFactor,
        factors: usize,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let before = handles.clone();
        cached.clear_convex_state();
        if self.barrier.is_some_and(|barrier| !barrier.is_clear(&handles)) {
            let reached = MinimizationResult::of(handles, 0, false);
            return self.with_barrier(reached, Some(&before), cached);
        }
        let mut residuals = Vec::new();
        self.constraints.enforce(self.terms, &mut residuals, &mut handles);
        let mut descent = Descent::new(self, handles, std::mem::take(cached))?;
        descent.factors_left = factors;
        let mut run = MinimizationResult::of(Vec::new(), 0, false);
        while !run.is_converged && run.iterations < self.settings.iteration_limit {
            run.iterations += 1;
            run.is_converged = descent.step()? == StepOutcome::Converged;
        }
        if !run.is_converged && descent.is_far() {
            descent.discard_factor();
        }
        *cached = descent.cached;
        cached.set_forces(Vec::new());
        run.handles = descent.iterate.handles;
        self.constraints.enforce(self.terms, &mut residuals, &mut run.handles);
        if self.barrier.is_none_or(|barrier| barrier.is_clear(&run.handles)) {
            return Ok(run);
        }
        // The factor lacks the second derivative of the barrier.
        cached.discard_factor();
        self.with_barrier(run, Some(&before), cached)
    }

    fn iterate(&self, handles: Vec<[f64; D]>, constant: &[[f64; D]]) -> Result<NewtonIterate<D>, Cancelled> {
        let mut right_side = constant.to_vec();
        let energy = self.local_energy(&handles, &mut right_side);
        self.cancel.check()?;
        Ok(NewtonIterate { handles, energy, right_side })
    }

    /// Cost of a new factorisation, in steps with a reused one; infinite if the energy does not implement its second derivative.
    pub(crate) fn factor_cost(&self) -> f64 {
        let Some(flops) = self.distortion.flops() else { return f64::INFINITY };
        let [factor, solve] = self.normal.flops(D);
        let [_, product] = self.normal.flops(1);
        (flops.rotation_hessian + factor) / (flops.local_step + solve + D as f64 * product)
    }
}

/// Handles with their energy and the right-hand side of a local-global step.
struct NewtonIterate<const D: usize> {
    handles: Vec<[f64; D]>,
    energy: f64,
    right_side: Vec<[f64; D]>,
}

/// Outcome of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepOutcome {
    /// The energy did not rise.
    Accepted,
    /// The energy would have risen.
    Rejected,
    /// The step was below the tolerance.
    Converged,
}

/// State of the descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    constant: Vec<[f64; D]>,
    iterate: NewtonIterate<D>,
    cached: CachedFactor,
    /// Number of new factorisations that are still allowed.
    factors_left: usize,
    reuse: FactorReuse,
    /// Index into [`CONVEXITY_LIMITS`]. Beyond the last the plain local-global step is taken, which never raises the energy.
    level: usize,
}

impl<'a, const D: usize> Descent<'a, D> {
    fn new(problem: &'a Minimization<'a, D>, handles: Vec<[f64; D]>, cached: CachedFactor) -> Result<Self, Cancelled> {
        let constant = problem.constant_right_side();
        let iterate = problem.iterate(handles, &constant)?;
        Ok(Self {
            problem,
            constant,
            iterate,
            cached,
            factors_left: usize::MAX,
            reuse: FactorReuse::new(problem.factor_cost()),
            level: 0,
        })
    }

    fn step(&mut self) -> Result<StepOutcome, Cancelled> {
        if !self.cached.is_some() {
            self.refactor()?;
        }
        let problem = self.problem;
        let mut by = self.iterate.right_side.clone();
        problem.normal.subtract_matvec(&self.iterate.handles, &mut by);
        match self.cached.factor() {
            Some(factor) => factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0),
            None => problem.factor.solve(&mut by),
        }
        let plain = self.ahead(&by, 1.0);
        self.reuse.record(largest_step(&self.iterate.handles, &plain));
        if self.reuse.is_done(self.tolerance()) {
            self.iterate.handles = plain;
            return Ok(StepOutcome::Converged);
        }
        let next = self.line_search(plain, &by)?;
        Ok(self.accept_or_reject(next))
    }

    fn tolerance(&self) -> f64 {
        self.problem.settings.tolerance * self.problem.diagonal
    }

    /// Returns the accelerated iterate if that does not raise the energy, else the plain one, else one at a shorter step.
    fn line_search(&mut self, plain: Vec<[f64; D]>, by: &[[f64; D]]) -> Result<NewtonIterate<D>, Cancelled> {
        let problem = self.problem;
        let has_history = self.reuse.anderson.has_history();
        let mut next = plain.clone();
        if self.cached.is_some() {
            self.reuse.anderson.step(&self.iterate.handles, &mut next);
        }
        let mut next = problem.iterate(next, &self.constant)?;
        if has_history && !self.is_lower(&next) {
            self.reuse.anderson.reset();
            next = problem.iterate(plain, &self.constant)?;
        }
        // The matrix is positive definite, so a short enough step along `by` lowers the energy.
        for step_length in STEP_LENGTHS {
            if self.is_lower(&next) || !self.cached.is_some() {
                break;
            }
            self.reuse.anderson.reset();
            next = problem.iterate(self.ahead(by, step_length), &self.constant)?;
        }
        Ok(next)
    }

    /// Returns the handles plus a multiple of `by`.
    fn ahead(&self, by: &[[f64; D]], step_length: f64) -> Vec<[f64; D]> {
        let next = by.iter().zip(&self.iterate.handles);
        next.map(|(by, from)| std::array::from_fn(|d| from[d] + step_length * by[d])).collect()
    }

    fn is_lower(&self, next: &NewtonIterate<D>) -> bool {
        next.energy <= self.iterate.energy * (1.0 + SAFEGUARD)
    }

    /// Accepts an iterate that does not raise the energy; otherwise drops the factorisation.
    fn accept_or_reject(&mut self, next: NewtonIterate<D>) -> StepOutcome {
        if !self.is_lower(&next) && self.cached.is_some() {
            self.level += usize::from(self.reuse.is_first());
            self.discard_factor();
            return StepOutcome::Rejected;
        }
        self.iterate = next;
        if !self.cached.is_some() || self.factors_left > 0 && self.is_stale() {
            self.discard_factor();
            self.level = 0;
        }
        StepOutcome::Accepted
    }

    /// Whether a new factorisation would cost less than the remaining steps.
    fn is_stale(&self) -> bool {
        self.reuse.is_stale(self.problem.settings.tolerance.max(AT_REST) * self.problem.diagonal)
    }

    /// Whether the last step was well above the tolerance.
    fn is_far(&self) -> bool {
        self.reuse.last().is_none_or(|step| step > STALE * self.tolerance())
    }

    fn discard_factor(&mut self) {
        self.cached.discard_factor();
        self.reuse.clear();
    }

    /// Factors the second derivative at the present iterate, and convexifies it until it is positive definite. Leaves no factor
    /// beyond the last limit, or when no more factorisations are allowed.
    fn refactor(&mut self) -> Result<(), Cancelled> {
        while let (false, 1.., Some(&limit)) =
            (self.cached.is_some(), self.factors_left, CONVEXITY_LIMITS.get(self.level))
        {
            let mut second = self.problem.normal.kron_identity::<D>(self.cached.take_buffer());
            let hessian = RotationHessian { scale: self.problem.scales.shape, limit };
            let Minimization { distortion, cancel, .. } = *self.problem;
            distortion.subtract_rotation_hessian(&self.iterate.handles, hessian, &mut second, cancel);
            cancel.check()?;
            self.cached.set_factor(Factorization::of_positive(second, cancel));
            cancel.check()?;
            if limit.is_infinite() && self.cached.is_some() {
                self.cached.set_convex_state(&self.iterate.handles);
            }
            self.reuse.is_fresh = true;
            self.factors_left -= 1;
            self.level += usize::from(!self.cached.is_some());
        }
        Ok(())
    }
}
