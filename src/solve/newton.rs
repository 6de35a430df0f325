//! Newton's method, which ends an iteration where local-global steps converge slowly.
//!
//! In: a state near the solution. Out: converged handles, usually with one factorisation.
//! Factorisations are reused with acceleration while that costs less than a new one; where the energy would rise, steps fall
//! back to convexified matrices and then to local-global steps.

use super::anderson::Anderson;
use super::cancel::Cancelled;
use super::energy::RotationHessian;
use super::linalg::factorization::Factorization;
use super::minimization::FinalPhase;
use super::minimization::{Minimization, MinimizationResult, SAFEGUARD, largest_step};

/// Local-global steps before Newton's method where they converge slowly: they rotate parts farther than a tangent step could.
const FIRST_STEPS: usize = 8;

/// Steps over which the convergence rate is measured.
const SPAN: usize = 5;

/// Newton's method takes over at a local-global step this small (in box diagonals).
const NEAR: f64 = 3e-3;

/// Window of the acceleration of steps with a reused factorisation.
const ANDERSON_WINDOW: usize = 5;

/// Steps that a new factorisation is expected to need.
const STEPS_PER_FACTOR: f64 = 2.0;

/// A step below the tolerance is the last if the next one would be below this part of it.
const CERTAIN: f64 = 0.1;

/// A factorisation whose last step is above this many tolerances is not reused for the next move.
const STALE: f64 = 3.0;

/// A step this small (in box diagonals) is rounding: the state has converged, however flat the energy is. The first step
/// from the rigid fit may be as large as the tolerance: where all pins move rigidly, so do weakly constrained parts.
const AT_REST: f64 = 1e-10;

/// Upper limits of 1/(s1 + s2), tried in this order: the true second derivative, one without the largest of its
/// negative contributions, and one without any (B. Smith et al., "Analytic Eigensystems for Isotropic Distortion Energies",
/// 2019); past the last a step is the plain local-global one, which never raises the energy.
const CONVEXITY_LIMITS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// Step lengths that are tried where the full step would raise the energy; they cost no solve.
const STEP_LENGTHS: [f64; 3] = [0.5, 0.25, 0.0625];

/// A factorised second derivative for reuse, and the buffer of the last one that was dropped.
#[derive(Debug, Default)]
pub(crate) struct CachedFactor {
    factor: Option<Factorization>,
    buffer: Vec<f64>,
}

impl CachedFactor {
    /// There is a factor.
    pub(crate) fn is_some(&self) -> bool {
        self.factor.is_some()
    }

    fn drop_factor(&mut self) {
        if let Some(factor) = self.factor.take() {
            self.buffer = factor.into_buffer();
        }
    }
}

/// Decides when Newton's method takes over, by the convergence rate of local-global steps and the relative cost of Newton's.
#[derive(Clone, Debug)]
pub(crate) struct NewtonSwitch {
    /// All steps.
    steps: Vec<f64>,
    /// Cost of a Newton matrix and its factorisation, in local-global steps.
    matrix: f64,
    /// Step at which Newton's method takes over.
    near: f64,
    /// The iteration ends at a first step this small; at later ones as small as `rest`.
    tolerance: f64,
    rest: f64,
}

impl NewtonSwitch {
    /// `None` where Newton's method is not available.
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

    /// Records a step; true where Newton's method takes over from there.
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

    /// Convergence rate of the last steps.
    fn rate(&self) -> f64 {
        let count = self.steps.len();
        (self.steps[count - 1] / self.steps[count - 1 - SPAN]).powf(1.0 / SPAN as f64)
    }
}

/// Steps until `left` shrinks to 1 at a rate.
fn steps_left(left: f64, rate: f64) -> f64 {
    if rate < 1.0 { -left.ln() / rate.ln() } else { f64::INFINITY }
}

impl<const D: usize> Minimization<'_, D> {
    /// Continues from `handles`; every linear solve counts as an iteration, `iterations` of them so far. `notify` is called with
    /// every accepted iterate and the last one.
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
        Ok(MinimizationResult {
            handles,
            iterations,
            is_converged,
            has_given_way: false,
            is_minimum: None,
            energy: None,
        })
    }

    /// Newton's method is available and cheap.
    pub(crate) fn has_newton(&self) -> bool {
        self.settings.acceleration > 0 && self.distortion.flops().is_some() && self.normal.is_banded_enough()
    }

    /// Continues from handles that had converged for similar targets, with the factorisation used there; at most `factors`
    /// new ones. A factorisation whose last step is too large is not cached.
    pub(crate) fn newton_from(
        &self,
        mut handles: Vec<[f64; D]>,
        cached: &mut CachedFactor,
        factors: usize,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let before = handles.clone();
        if self.barrier.is_some_and(|barrier| !barrier.is_clear(&handles)) {
            let reached = MinimizationResult {
                handles,
                iterations: 0,
                is_converged: false,
                has_given_way: false,
                is_minimum: None,
                energy: None,
            };
            return self.kept_clear(reached, Some(&before));
        }
        let mut residuals = Vec::new();
        self.constraints.enforce(self.terms, &mut residuals, &mut handles);
        let mut descent = Descent::new(self, handles, std::mem::take(cached))?;
        descent.factors_left = factors;
        let mut run = MinimizationResult {
            handles: Vec::new(),
            iterations: 0,
            is_converged: false,
            has_given_way: false,
            is_minimum: None,
            energy: None,
        };
        while !run.is_converged && run.iterations < self.settings.iteration_limit {
            run.iterations += 1;
            run.is_converged = descent.step()? == StepOutcome::Converged;
        }
        if !run.is_converged && descent.is_far() {
            descent.drop_factor();
        }
        *cached = descent.cached;
        run.handles = descent.iterate.handles;
        self.constraints.enforce(self.terms, &mut residuals, &mut run.handles);
        self.kept_clear(run, Some(&before))
    }

    fn iterate(&self, handles: Vec<[f64; D]>, constant: &[[f64; D]]) -> Result<NewtonIterate<D>, Cancelled> {
        let mut right_side = constant.to_vec();
        let energy = self.local_energy(&handles, &mut right_side);
        self.cancel.check()?;
        Ok(NewtonIterate { handles, energy, right_side })
    }

    /// Cost of a new factorisation, in steps with a reused one.
    fn factor_cost(&self) -> f64 {
        let Some(flops) = self.distortion.flops() else { return f64::INFINITY };
        let [factor, solve] = self.normal.flops(D);
        let [_, product] = self.normal.flops(1);
        (flops.rotation_hessian + factor) / (flops.local_step + solve + D as f64 * product)
    }
}

/// Handles with their energy and the right side of a local-global step.
struct NewtonIterate<const D: usize> {
    handles: Vec<[f64; D]>,
    energy: f64,
    right_side: Vec<[f64; D]>,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StepOutcome {
    /// The energy did not rise.
    Accepted,
    /// The energy would have risen.
    Rejected,
    /// Below the tolerance.
    Converged,
}

/// State of the descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    constant: Vec<[f64; D]>,
    iterate: NewtonIterate<D>,
    cached: CachedFactor,
    /// The factorisation was made at the iterate of the first of `steps`.
    is_fresh: bool,
    /// Remaining new factorisations.
    factors_left: usize,
    /// Cost of a new factorisation, in steps with a reused one.
    factor_cost: f64,
    anderson: Anderson,
    /// Steps with this factorisation.
    steps: Vec<f64>,
    /// Which of [`CONVEXITY_LIMITS`] is in use.
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
            is_fresh: false,
            factors_left: usize::MAX,
            factor_cost: problem.factor_cost(),
            anderson: Anderson::new(ANDERSON_WINDOW),
            steps: Vec::new(),
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
        match &self.cached.factor {
            Some(factor) => factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0),
            None => problem.factor.solve(&mut by),
        }
        let plain = self.ahead(&by, 1.0);
        self.steps.push(largest_step(&self.iterate.handles, &plain));
        if self.is_last() {
            self.iterate.handles = plain;
            return Ok(StepOutcome::Converged);
        }
        let next = self.line_search(plain, &by)?;
        Ok(self.accept_or_reject(next))
    }

    /// A step below the tolerance after which little remains, in flat directions too.
    fn is_last(&self) -> bool {
        let tolerance = self.problem.settings.tolerance * self.problem.diagonal;
        let step = self.steps[self.steps.len() - 1];
        step <= tolerance && (self.is_fresh && self.steps.len() == 1 || step * self.rate() <= CERTAIN * tolerance)
    }

    /// Convergence rate with this factorisation.
    fn rate(&self) -> f64 {
        let [first, .., last] = self.steps[..] else { return 1.0 };
        (last / first).powf(1.0 / (self.steps.len() - 1) as f64)
    }

    /// The accelerated step where it lowers the energy, else the plain one, else a shorter one.
    fn line_search(&mut self, plain: Vec<[f64; D]>, by: &[[f64; D]]) -> Result<NewtonIterate<D>, Cancelled> {
        let problem = self.problem;
        let has_history = self.anderson.has_history();
        let mut next = plain.clone();
        if self.cached.is_some() {
            self.anderson.step(&self.iterate.handles, &mut next);
        }
        let mut next = problem.iterate(next, &self.constant)?;
        if has_history && !self.is_lower(&next) {
            self.anderson.reset();
            next = problem.iterate(plain, &self.constant)?;
        }
        // The matrix is positive definite: a short enough step along `by` lowers the energy.
        for share in STEP_LENGTHS {
            if self.is_lower(&next) || !self.cached.is_some() {
                break;
            }
            self.anderson.reset();
            next = problem.iterate(self.ahead(by, share), &self.constant)?;
        }
        Ok(next)
    }

    /// The handles plus a multiple of `by`.
    fn ahead(&self, by: &[[f64; D]], share: f64) -> Vec<[f64; D]> {
        let next = by.iter().zip(&self.iterate.handles);
        next.map(|(by, from)| std::array::from_fn(|d| from[d] + share * by[d])).collect()
    }

    fn is_lower(&self, next: &NewtonIterate<D>) -> bool {
        next.energy <= self.iterate.energy * (1.0 + SAFEGUARD)
    }

    /// Accepts a step that does not raise the energy; otherwise the factorisation is dropped.
    fn accept_or_reject(&mut self, next: NewtonIterate<D>) -> StepOutcome {
        if !self.is_lower(&next) && self.cached.is_some() {
            self.level += usize::from(self.steps.len() == 1);
            self.drop_factor();
            return StepOutcome::Rejected;
        }
        self.iterate = next;
        if !self.cached.is_some() || self.factors_left > 0 && self.is_stale() {
            self.drop_factor();
            self.level = 0;
        }
        StepOutcome::Accepted
    }

    /// The remaining steps would cost more than a new factorisation and two steps.
    fn is_stale(&self) -> bool {
        let tolerance = self.problem.settings.tolerance.max(AT_REST) * self.problem.diagonal;
        let step = self.steps[self.steps.len() - 1];
        self.steps.len() > 1 && steps_left(step / tolerance, self.rate()) > self.factor_cost + STEPS_PER_FACTOR
    }

    /// The last step was well above the tolerance.
    fn is_far(&self) -> bool {
        let tolerance = self.problem.settings.tolerance * self.problem.diagonal;
        self.steps.last().is_none_or(|&step| step > STALE * tolerance)
    }

    fn drop_factor(&mut self) {
        self.cached.drop_factor();
        self.anderson.reset();
        self.steps.clear();
    }

    /// Factors the second derivative at this iterate, convexified until it is positive definite; none past the last limit,
    /// nor where no factorisations remain.
    fn refactor(&mut self) -> Result<(), Cancelled> {
        while let (false, 1.., Some(&limit)) =
            (self.cached.is_some(), self.factors_left, CONVEXITY_LIMITS.get(self.level))
        {
            let mut second = self.problem.normal.kron_identity::<D>(std::mem::take(&mut self.cached.buffer));
            let hessian = RotationHessian { scale: self.problem.scales.shape, limit };
            let Minimization { distortion, cancel, .. } = *self.problem;
            distortion.subtract_rotation_hessian(&self.iterate.handles, hessian, &mut second, cancel);
            cancel.check()?;
            self.cached.factor = Factorization::of_positive(second, cancel);
            cancel.check()?;
            self.is_fresh = true;
            self.factors_left -= 1;
            self.level += usize::from(!self.cached.is_some());
        }
        Ok(())
    }
}
