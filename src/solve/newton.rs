//! Newton's method for the end of an iteration: the second derivative knows what local-global steps creep along.
//!
//! In: a state that local-global steps have brought near. Out: handles at rest, mostly with one factorisation.
//! Steps use a factor again, accelerated, while that costs less than a new one; where the energy would rise they fall
//! back to convex and to plain ones.

use super::anderson::Anderson;
use super::energy::Turns;
use super::iterate::{Iteration, Run, SAFEGUARD, largest_step};
use super::matrix::Factor;

/// Local-global steps before Newton's where they shrink slowly: they turn parts as far as no tangent reaches.
const FIRST_STEPS: usize = 8;

/// Steps that their rate is taken from.
const SPAN: usize = 5;

/// A local-global step this small (in box diagonals) needs no more of them.
const NEAR: f64 = 3e-3;

/// Steps with an old factor that acceleration looks at.
const WINDOW: usize = 5;

/// Steps that a new factor is likely to need.
const NEW_STEPS: f64 = 2.0;

/// A step below the tolerance is the last where the next one would be below this part of it.
const CERTAIN: f64 = 0.1;

/// A factor that leaves a last step above this many tolerances does not serve for another drag.
const FAR: f64 = 3.0;

/// A step this small (in box diagonals) is rounding: the state rests, however flat the energy is there. The first step
/// from the rigid fit may be as large as the tolerance: where all pins move as one, so do the parts that nearly nothing holds.
const AT_REST: f64 = 1e-10;

/// Upper limits of 1/(s1 + s2) to try, one after the other: the true second derivative, one without the worst of its
/// negative parts, and one without any (B. Smith et al., "Analytic Eigensystems for Isotropic Distortion Energies",
/// 2019); past the last a step is the plain local-global one, which never raises the energy.
const LIMITS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// Shares of a step to try where the whole one would raise the energy; they cost no solve.
const SHORTER: [f64; 3] = [0.5, 0.25, 0.0625];

/// How an iteration may end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Finish {
    /// By Newton's method, where the energy knows its second derivative.
    Newton,
    /// By local-global steps alone.
    LocalGlobal,
}

/// A factor of a second derivative that may serve again, and the memory of the last one that no longer does.
#[derive(Debug, Default)]
pub(crate) struct Kept {
    factor: Option<Factor>,
    spare: Vec<f64>,
}

impl Kept {
    /// There is a factor.
    pub(crate) fn is_some(&self) -> bool {
        self.factor.is_some()
    }

    fn drop_factor(&mut self) {
        if let Some(factor) = self.factor.take() {
            self.spare = factor.into_memory();
        }
    }
}

/// How fast local-global steps shrink, and what Newton's cost by comparison.
#[derive(Clone, Debug)]
pub(crate) struct Pace {
    /// All steps.
    steps: Vec<f64>,
    /// Newton matrix and factor, in local-global steps.
    matrix: f64,
    /// Steps as small as this need no more of them.
    near: f64,
    /// The first step is the last where it is as small as this; later ones rest at `rest`.
    tolerance: f64,
    rest: f64,
}

impl Pace {
    /// `None` where Newton's method is not to be asked.
    pub(crate) fn of<const D: usize>(problem: &Iteration<D>) -> Option<Self> {
        let is_wanted = problem.settings.acceleration > 0 && problem.finish == Finish::Newton;
        let work = problem.distortion.work().filter(|_| is_wanted)?;
        let [factor, _] = problem.normal.work(D);
        let [_, solve] = problem.normal.work(1);
        let tolerance = problem.settings.tolerance * problem.diagonal;
        let rest = AT_REST * problem.diagonal;
        let near = if problem.normal.is_banded_enough() { NEAR * problem.diagonal } else { tolerance.max(rest) };
        let matrix = (work.turns + factor) / (work.local_step + D as f64 * solve);
        Some(Self { steps: Vec::new(), matrix, near, tolerance, rest })
    }

    /// Hears of a step; whether Newton's method is to go on from there.
    pub(crate) fn is_time(&mut self, step: f64) -> bool {
        self.steps.push(step);
        let count = self.steps.len();
        let rest = if count == 1 { self.tolerance } else { self.rest };
        if step <= rest {
            return false;
        }
        step <= self.near && self.near > self.tolerance
            || count >= FIRST_STEPS && steps_left(step / self.near, self.rate()) > self.matrix
    }

    /// How steps shrink.
    fn rate(&self) -> f64 {
        let count = self.steps.len();
        (self.steps[count - 1] / self.steps[count - 1 - SPAN]).powf(1.0 / SPAN as f64)
    }
}

/// Steps until what is left shrinks to 1, at a rate.
fn steps_left(left: f64, rate: f64) -> f64 {
    if rate < 1.0 { -left.ln() / rate.ln() } else { f64::INFINITY }
}

impl<const D: usize> Iteration<'_, D> {
    /// Goes on from `handles`; every linear solve counts as an iteration, `iterations` of them so far. `tell` hears of
    /// every place that is taken, and of the last one.
    pub(crate) fn newton(
        &self,
        handles: &[[f64; D]],
        mut iterations: usize,
        tell: &mut dyn FnMut(&[[f64; D]]),
    ) -> Run<D> {
        let mut descent = Descent::new(self, handles.to_vec(), Kept::default());
        let mut is_converged = false;
        while !is_converged && iterations < self.settings.iteration_limit {
            iterations += 1;
            let step = descent.step();
            is_converged = step == Step::Last;
            if step == Step::Taken {
                tell(&descent.place.handles);
            }
        }
        let mut handles = descent.place.handles;
        self.constraints.enforce(self.terms, &mut Vec::new(), &mut handles);
        tell(&handles);
        Run { handles, iterations, is_converged }
    }

    /// Newton's method is at hand, and cheap.
    pub(crate) fn knows_newton(&self) -> bool {
        self.settings.acceleration > 0 && self.distortion.work().is_some() && self.normal.is_banded_enough()
    }

    /// Goes on from handles that were at rest for targets near by, with the factor that served there; at most `factors`
    /// new ones. A factor that leaves too much at the end is not kept.
    pub(crate) fn descend(&self, mut handles: Vec<[f64; D]>, kept: &mut Kept, factors: usize) -> Run<D> {
        let mut misses = Vec::new();
        self.constraints.enforce(self.terms, &mut misses, &mut handles);
        let mut descent = Descent::new(self, handles, std::mem::take(kept));
        descent.factors_left = factors;
        let mut run = Run { handles: Vec::new(), iterations: 0, is_converged: false };
        while !run.is_converged && run.iterations < self.settings.iteration_limit {
            run.iterations += 1;
            run.is_converged = descent.step() == Step::Last;
        }
        if !run.is_converged && descent.is_far() {
            descent.drop_factor();
        }
        *kept = descent.kept;
        run.handles = descent.place.handles;
        self.constraints.enforce(self.terms, &mut misses, &mut run.handles);
        run
    }

    fn place(&self, handles: Vec<[f64; D]>, constant: &[[f64; D]]) -> Place<D> {
        let mut right_side = constant.to_vec();
        let energy = self.local_energy(&handles, &mut right_side);
        Place { handles, energy, right_side }
    }

    /// What a new factor costs, in steps with an old one.
    fn cost_of_factor(&self) -> f64 {
        let Some(work) = self.distortion.work() else { return f64::INFINITY };
        let [factor, solve] = self.normal.work(D);
        let [_, product] = self.normal.work(1);
        (work.turns + factor) / (work.local_step + solve + D as f64 * product)
    }
}

/// Handles with their energy and the right side of a local-global step from there.
struct Place<const D: usize> {
    handles: Vec<[f64; D]>,
    energy: f64,
    right_side: Vec<[f64; D]>,
}

/// How a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    Taken,
    /// The energy would have risen.
    Refused,
    /// Below the tolerance.
    Last,
}

/// The way down.
struct Descent<'a, const D: usize> {
    problem: &'a Iteration<'a, D>,
    constant: Vec<[f64; D]>,
    place: Place<D>,
    kept: Kept,
    /// The factor belongs to the place of the first of `steps`.
    is_fresh: bool,
    /// New factors that may be made.
    factors_left: usize,
    /// What a new factor costs, in steps with an old one.
    cost_of_factor: f64,
    anderson: Anderson,
    /// Steps with this factor.
    steps: Vec<f64>,
    /// Which of [`LIMITS`] is in use.
    level: usize,
}

impl<'a, const D: usize> Descent<'a, D> {
    fn new(problem: &'a Iteration<'a, D>, handles: Vec<[f64; D]>, kept: Kept) -> Self {
        let constant = problem.constant_right_side();
        let place = problem.place(handles, &constant);
        Self {
            problem,
            constant,
            place,
            kept,
            is_fresh: false,
            factors_left: usize::MAX,
            cost_of_factor: problem.cost_of_factor(),
            anderson: Anderson::new(WINDOW),
            steps: Vec::new(),
            level: 0,
        }
    }

    fn step(&mut self) -> Step {
        if !self.kept.is_some() {
            self.refactor();
        }
        let problem = self.problem;
        let mut by = self.place.right_side.clone();
        problem.normal.subtract_product(&self.place.handles, &mut by);
        match &self.kept.factor {
            Some(factor) => factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0),
            None => problem.factor.solve(&mut by),
        }
        let plain = self.ahead(&by, 1.0);
        self.steps.push(largest_step(&self.place.handles, &plain));
        if self.is_last() {
            self.place.handles = plain;
            return Step::Last;
        }
        let next = self.lower(plain, &by);
        self.judge(next)
    }

    /// A step below the tolerance after which little is left, in flat directions, too.
    fn is_last(&self) -> bool {
        let tolerance = self.problem.settings.tolerance * self.problem.diagonal;
        let step = self.steps[self.steps.len() - 1];
        step <= tolerance && (self.is_fresh && self.steps.len() == 1 || step * self.rate() <= CERTAIN * tolerance)
    }

    /// How steps shrink with this factor.
    fn rate(&self) -> f64 {
        let [first, .., last] = self.steps[..] else { return 1.0 };
        (last / first).powf(1.0 / (self.steps.len() - 1) as f64)
    }

    /// The accelerated step where it lowers the energy, else the plain one, else a part of it.
    fn lower(&mut self, plain: Vec<[f64; D]>, by: &[[f64; D]]) -> Place<D> {
        let problem = self.problem;
        let knows_steps = self.anderson.knows_steps();
        let mut next = plain.clone();
        if self.kept.is_some() {
            self.anderson.step(&self.place.handles, &mut next);
        }
        let mut next = problem.place(next, &self.constant);
        if knows_steps && !self.is_lower(&next) {
            self.anderson.reset();
            next = problem.place(plain, &self.constant);
        }
        // The matrix is positive definite: a short enough step along `by` lowers the energy.
        for share in SHORTER {
            if self.is_lower(&next) || !self.kept.is_some() {
                break;
            }
            self.anderson.reset();
            next = problem.place(self.ahead(by, share), &self.constant);
        }
        next
    }

    /// The handles, a share of `by` farther.
    fn ahead(&self, by: &[[f64; D]], share: f64) -> Vec<[f64; D]> {
        let next = by.iter().zip(&self.place.handles);
        next.map(|(by, from)| std::array::from_fn(|d| from[d] + share * by[d])).collect()
    }

    fn is_lower(&self, next: &Place<D>) -> bool {
        next.energy <= self.place.energy * (1.0 + SAFEGUARD)
    }

    /// Takes a step that does not raise the energy; else another factor is next.
    fn judge(&mut self, next: Place<D>) -> Step {
        if !self.is_lower(&next) && self.kept.is_some() {
            self.level += usize::from(self.steps.len() == 1);
            self.drop_factor();
            return Step::Refused;
        }
        self.place = next;
        if !self.kept.is_some() || self.factors_left > 0 && self.is_stale() {
            self.drop_factor();
            self.level = 0;
        }
        Step::Taken
    }

    /// What is left costs more than a new factor and two steps with it.
    fn is_stale(&self) -> bool {
        let tolerance = self.problem.settings.tolerance.max(AT_REST) * self.problem.diagonal;
        let step = self.steps[self.steps.len() - 1];
        self.steps.len() > 1 && steps_left(step / tolerance, self.rate()) > self.cost_of_factor + NEW_STEPS
    }

    /// The last step was well above the tolerance.
    fn is_far(&self) -> bool {
        let tolerance = self.problem.settings.tolerance * self.problem.diagonal;
        self.steps.last().is_none_or(|&step| step > FAR * tolerance)
    }

    fn drop_factor(&mut self) {
        self.kept.drop_factor();
        self.anderson.reset();
        self.steps.clear();
    }

    /// Factors the second derivative at this place, limited until it is positive definite; no factor past the last limit,
    /// nor past the last that may be made.
    fn refactor(&mut self) {
        while let (false, 1.., Some(&limit)) = (self.kept.is_some(), self.factors_left, LIMITS.get(self.level)) {
            let mut second = self.problem.normal.repeated::<D>(std::mem::take(&mut self.kept.spare));
            let turns = Turns { scale: self.problem.scales.shape, limit };
            self.problem.distortion.subtract_turns(&self.place.handles, turns, &mut second);
            self.kept.factor = Factor::of_positive(second);
            self.is_fresh = true;
            self.factors_left -= 1;
            self.level += usize::from(!self.kept.is_some());
        }
    }
}
