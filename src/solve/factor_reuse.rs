//! Reuse of a factored second derivative: how its steps converge, and whether a new factor would cost less than the remaining ones.
//!
//! In: lengths of steps. Out: whether the last one ends the descent, and whether the factor is worth keeping.

use super::anderson::Anderson;

/// Upper limits of 1/(s1 + s2), tried in this order: the true second derivative, one without its largest negative contributions,
/// and one without any (B. Smith et al., "Analytic Eigensystems for Isotropic Distortion Energies", 2019).
pub(crate) const CONVEXITY_LIMITS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// Window of the Anderson acceleration of steps with a reused factor.
const ANDERSON_WINDOW: usize = 5;

/// Number of steps that a new factor is expected to need.
const STEPS_PER_FACTOR: f64 = 2.0;

/// A step below the tolerance is the last one if the next would be below this fraction of the tolerance.
const CERTAIN: f64 = 0.1;

/// The steps with one factor.
pub(crate) struct FactorReuse {
    /// Whether the factor was computed at the state from which the first step started.
    pub(crate) is_fresh: bool,
    /// Acceleration of the steps.
    pub(crate) anderson: Anderson,
    /// Lengths of the steps.
    steps: Vec<f64>,
    /// Cost of a new factor, in steps with a reused one.
    factor_cost: f64,
}

impl FactorReuse {
    /// No steps yet.
    pub(crate) fn new(factor_cost: f64) -> Self {
        Self { is_fresh: false, anderson: Anderson::new(ANDERSON_WINDOW), steps: Vec::new(), factor_cost }
    }

    /// Forgets the steps, because the factor changes.
    pub(crate) fn clear(&mut self) {
        self.steps.clear();
        self.anderson.reset();
    }

    /// Records the length of a step.
    pub(crate) fn record(&mut self, step: f64) {
        self.steps.push(step);
    }

    /// The length of the last step.
    pub(crate) fn last(&self) -> Option<f64> {
        self.steps.last().copied()
    }

    /// Whether there was one step only.
    pub(crate) fn is_first(&self) -> bool {
        self.steps.len() == 1
    }

    /// Whether the last step was below the tolerance and little distance remains, also along flat directions.
    pub(crate) fn is_done(&self, tolerance: f64) -> bool {
        self.last().is_some_and(|step| {
            step <= tolerance && (self.is_fresh && self.is_first() || step * self.rate() <= CERTAIN * tolerance)
        })
    }

    /// Whether the remaining steps would cost more than a new factor and the steps that it needs.
    pub(crate) fn is_stale(&self, tolerance: f64) -> bool {
        let left = |step: f64| steps_left(step / tolerance, self.rate());
        self.steps.len() > 1 && self.last().is_some_and(|step| left(step) > self.factor_cost + STEPS_PER_FACTOR)
    }

    /// Convergence rate of the steps.
    fn rate(&self) -> f64 {
        let [first, .., last] = self.steps[..] else { return 1.0 };
        (last / first).powf(1.0 / (self.steps.len() - 1) as f64)
    }
}

/// Number of steps until `left` has shrunk to 1 at the given rate.
pub(crate) fn steps_left(left: f64, rate: f64) -> f64 {
    if rate < 1.0 { -left.ln() / rate.ln() } else { f64::INFINITY }
}
