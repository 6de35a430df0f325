//! Newton's method for the end of an iteration: the second derivative knows what local-global steps creep along.
//!
//! In: a state that local-global steps have brought near. Out: handles at rest, in a few factorisations.
//! Steps use a factor again while it serves, and fall back to convex and to plain steps where the energy would rise.

use super::energy::Turns;
use super::iterate::{Iteration, Run, SAFEGUARD, largest_step};
use super::matrix::Factor;

/// Local-global steps before Newton's, at most: they turn parts as far as no tangent reaches.
const FIRST_STEPS: usize = 12;

/// The same where matrices are dense: a factorisation costs as much as a hundred local-global steps there.
const PATIENT_STEPS: usize = 40;

/// A local-global step this small (in box diagonals) needs no more of them.
const NEAR: f64 = 1e-3;

/// A step this small (in box diagonals) is rounding: the state rests, however flat the energy is there. The first step
/// from the rigid fit may be as large as the tolerance: where all pins move as one, so do the parts that nearly nothing holds.
const AT_REST: f64 = 1e-10;

/// A factor is used again while steps shrink to this part.
const STALE: f64 = 0.1;

/// Upper limits of 1/(s1 + s2) to try, one after the other: the true second derivative, one without the worst of its
/// negative parts, and one without any (B. Smith et al., "Analytic Eigensystems for Isotropic Distortion Energies",
/// 2019); past the last a step is the plain local-global one, which never raises the energy.
const LIMITS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// Shares of a step to try where the whole one would raise the energy; they cost no solve.
const SHORTER: [f64; 3] = [0.5, 0.25, 0.0625];

/// How far the local-global iteration has come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    pub(crate) iteration: usize,
    /// Its last step.
    pub(crate) step: f64,
}

impl<const D: usize> Iteration<'_, D> {
    /// Goes on from `handles` where it is time to and the energy knows its second derivative; every linear solve counts
    /// as an iteration. `tell` hears of every place that is taken, and of the last one.
    pub(crate) fn newton(
        &self,
        handles: &[[f64; D]],
        progress: Progress,
        tell: &mut dyn FnMut(&[[f64; D]]),
    ) -> Option<Run<D>> {
        let knows = self.settings.acceleration > 0 && self.distortion.knows_turns();
        let rest = if progress.iteration == 1 { self.settings.tolerance } else { AT_REST };
        if !knows || !self.is_time(progress) || progress.step <= rest * self.diagonal {
            return None;
        }
        let mut descent = Descent::new(self, handles);
        let mut iterations = progress.iteration;
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
        Some(Run { handles, iterations, is_converged })
    }

    fn is_time(&self, Progress { iteration, step }: Progress) -> bool {
        if self.normal.is_banded_enough() {
            iteration >= FIRST_STEPS || step <= NEAR * self.diagonal
        } else {
            iteration >= PATIENT_STEPS
        }
    }

    fn place(&self, handles: Vec<[f64; D]>, constant: &[[f64; D]]) -> Place<D> {
        let mut right_side = constant.to_vec();
        let energy = self.local_energy(&handles, &mut right_side);
        Place { handles, energy, right_side }
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
    factor: Option<Factor>,
    /// Memory of the last factor.
    spare: Vec<f64>,
    /// The factor belongs to this place.
    is_fresh: bool,
    /// Which of [`LIMITS`] is in use.
    level: usize,
    last_step: f64,
}

impl<'a, const D: usize> Descent<'a, D> {
    fn new(problem: &'a Iteration<'a, D>, handles: &[[f64; D]]) -> Self {
        let constant = problem.constant_right_side();
        let place = problem.place(handles.to_vec(), &constant);
        Self {
            problem,
            constant,
            place,
            factor: None,
            spare: Vec::new(),
            is_fresh: false,
            level: 0,
            last_step: f64::INFINITY,
        }
    }

    fn step(&mut self) -> Step {
        if self.factor.is_none() {
            self.refactor();
        }
        let problem = self.problem;
        let mut by = self.place.right_side.clone();
        problem.normal.subtract_product(&self.place.handles, &mut by);
        match &self.factor {
            Some(factor) => factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0),
            None => problem.factor.solve(&mut by),
        }
        let next = self.ahead(&by, 1.0);
        let step = largest_step(&self.place.handles, &next);
        if step <= problem.settings.tolerance * problem.diagonal {
            self.place.handles = next;
            return Step::Last;
        }
        let mut next = problem.place(next, &self.constant);
        // The matrix is positive definite: a short enough step along `by` lowers the energy.
        for share in SHORTER {
            if self.is_lower(&next) || self.factor.is_none() {
                break;
            }
            next = problem.place(self.ahead(&by, share), &self.constant);
        }
        self.judge(next, step)
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
    fn judge(&mut self, next: Place<D>, step: f64) -> Step {
        if !self.is_lower(&next) && self.factor.is_some() {
            self.level += usize::from(self.is_fresh);
            self.drop_factor();
            return Step::Refused;
        }
        self.place = next;
        self.is_fresh = false;
        if self.factor.is_none() || step > STALE * self.last_step {
            self.drop_factor();
            self.level = 0;
        }
        self.last_step = step;
        Step::Taken
    }

    fn drop_factor(&mut self) {
        self.spare = self.factor.take().map_or_else(Vec::new, Factor::into_memory);
    }

    /// Factors the second derivative at this place, limited until it is positive definite; no factor past the last limit.
    fn refactor(&mut self) {
        self.is_fresh = true;
        while let (None, Some(&limit)) = (&self.factor, LIMITS.get(self.level)) {
            let mut second = self.problem.normal.repeated::<D>(std::mem::take(&mut self.spare));
            let turns = Turns { scale: self.problem.scales.shape, limit };
            self.problem.distortion.subtract_turns(&self.place.handles, turns, &mut second);
            self.factor = Factor::of_positive(second);
            self.level += usize::from(self.factor.is_none());
        }
    }
}
