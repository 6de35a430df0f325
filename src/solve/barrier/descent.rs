//! Newton's method for the energy with the barrier, from a state in which nothing folds to a minimum in which nothing folds.
//!
//! In: the minimum without the barrier. Out: itself where every point of the barrier is clear, else a minimum with it. Steps end before a
//! determinant reaches the pole, and lower the energy.

use super::points::{BarrierPoints, FINE};
use super::potential::{CLEAR, POLE};
use super::reactions::Reactions;
use crate::solve::cancel::Cancelled;
use crate::solve::energy::RotationHessian;
use crate::solve::linalg::factorization::Factorization;
use crate::solve::minimization::{Minimization, MinimizationResult, largest_step};
use std::collections::BTreeMap;

/// Strength of the barrier, in units of the shape's stiffness.
const STRENGTH: f64 = 1.0;

/// The least determinant of a first state.
const FIRST: f64 = 2.5 * POLE;

/// The least determinant of a last state, from which a similar problem is continued.
const LAST: f64 = 1.01 * POLE;

/// Part of the way to the pole that a step may go.
const CAUTION: f64 = 0.9;

/// Changes of the multipliers of pins.
const ROUNDS: usize = 3;

/// Pins this near to their targets (in box diagonals) hold.
const HELD: f64 = 1e-9;

/// Steps above this (in box diagonals) that lower the energy by more than [`SLOW`] are made with a convex matrix: they come from far.
const NEAR: f64 = 1e-2;

/// A small part of the energy.
const SLOW: f64 = 0.1;

/// A step that is cut to less than this part was not a good one.
const SHORT: f64 = 0.05;

/// Upper limits of 1/(s1 + s2), tried in this order: the second derivative, then matrices that are more and more convex, as in Newton's method
/// without the barrier.
const LEVELS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// How often cells that fold between points get twice as many along an axis.
const REFINEMENTS: usize = 2;

/// Halvings of a step.
const HALVINGS: usize = 20;

/// Part of the descent along the tangent that a step has to make.
const DESCENT: f64 = 1e-4;

/// Rounding of energies.
const ROUNDING: f64 = 1e-11;

type Vectors<const D: usize> = Vec<[f64; D]>;

/// A state with its energy and minus half of its derivative.
struct State<const D: usize> {
    handles: Vectors<D>,
    energy: f64,
    residual: Vectors<D>,
}

impl<const D: usize> Minimization<'_, D> {
    /// The unit of the shape's energy: its greatest value is of this order.
    pub(super) fn stiffness(&self) -> f64 {
        self.scales.shape * self.distortion.mass()
    }

    /// A minimum without the barrier where that is clear, else one with it. `before`: a state of a similar problem, from which it continues.
    pub(crate) fn kept_clear(
        &self,
        free: MinimizationResult<D>,
        before: Option<&[[f64; D]]>,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let Some(barrier) = self.barrier.filter(|barrier| !barrier.is_clear(&free.handles)) else { return Ok(free) };
        let mut reactions = Reactions::new(self);
        // Pins do not give way all at once where the barrier begins to act.
        let t = (barrier.least_det(&free.handles) / CLEAR).clamp(0.0, 1.0);
        reactions.start_from(&self.softly_solved(&free.handles)?, t * t * (3.0 - 2.0 * t));
        let mut result = free;
        let mut finer = BTreeMap::new();
        for round in 0..=REFINEMENTS {
            let refined = (!finer.is_empty()).then(|| barrier.refined(&finer));
            let points = refined.as_ref().unwrap_or_else(|| barrier.points());
            let first = match before.filter(|before| round == 0 && points.least_det(before) >= LAST) {
                Some(before) => before.to_vec(),
                None => {
                    let share = points.way_to_crossing(&self.start, &result.handles, FIRST);
                    if share < 1.0 { blend(&self.start, &result.handles, CAUTION * share) } else { result.handles }
                }
            };
            let mut descent = Descent {
                problem: self,
                points,
                reactions: reactions.clone(),
                iterations: result.iterations,
                level: 1,
            };
            result = descent.run(first)?;
            let folded = barrier.folded(&result.handles);
            if folded.is_empty() {
                break;
            }
            for cell in folded {
                *finer.entry(cell).or_insert(FINE[usize::from(D > 2)]) *= 2;
            }
        }
        Ok(result)
    }

    /// A step of the local-global iteration that enforces nothing: hard rows are off by their forces over their stiffness.
    fn softly_solved(&self, handles: &[[f64; D]]) -> Result<Vectors<D>, Cancelled> {
        let mut next = self.constant_right_side();
        self.local_energy(handles, &mut next);
        self.cancel.check()?;
        self.factor.solve(&mut next);
        Ok(next)
    }
}

/// (1 − t) · from + t · to.
fn blend<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(to).map(|(a, b)| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t)).collect()
}

/// from + t · by.
fn ahead<const D: usize>(from: &[[f64; D]], by: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(by).map(|(a, b)| std::array::from_fn(|d| t.mul_add(b[d], a[d]))).collect()
}

/// The descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    points: &'a BarrierPoints<D>,
    reactions: Reactions<'a, D>,
    iterations: usize,
    /// 0: the second derivative, 1: a convex matrix.
    level: usize,
}

impl<const D: usize> Descent<'_, D> {
    /// Minimises, with multipliers that follow the forces of the pins.
    fn run(&mut self, first: Vectors<D>) -> Result<MinimizationResult<D>, Cancelled> {
        let problem = self.problem;
        let mut handles = first;
        let mut is_converged = false;
        for _ in 0..ROUNDS {
            (handles, is_converged) = self.minimized(handles)?;
            if self.reactions.advance(&handles) <= HELD * problem.diagonal {
                break;
            }
        }
        let has_given_way = self.reactions.give_way(&handles);
        if !has_given_way {
            problem.constraints.enforce(problem.terms, &mut Vec::new(), &mut handles);
        }
        let is_minimum = (is_converged && self.level == 0).then_some(true);
        Ok(MinimizationResult {
            handles,
            iterations: self.iterations,
            is_converged,
            has_given_way,
            is_minimum,
            energy: None,
        })
    }

    /// The minimum for these multipliers, and whether the steps converged to it.
    fn minimized(&mut self, first: Vectors<D>) -> Result<(Vectors<D>, bool), Cancelled> {
        let problem = self.problem;
        let tolerance = problem.settings.tolerance.max(1e-10) * problem.diagonal;
        let mut state = self.state(first)?;
        let last = self.iterations + problem.settings.iteration_limit;
        while self.iterations < last {
            self.iterations += 1;
            let by = self.direction(&state)?;
            let full = ahead(&state.handles, &by, 1.0);
            let length = largest_step(&state.handles, &full);
            if length <= tolerance {
                let is_open = self.points.way_to_crossing(&state.handles, &full, POLE) >= 1.0;
                return Ok((if is_open { full } else { state.handles }, true));
            }
            match self.searched(&state, &by)? {
                Some(next) => {
                    let moved = largest_step(&state.handles, &next.handles);
                    let is_near = state.energy - next.energy <= SLOW * state.energy || moved <= NEAR * problem.diagonal;
                    self.level = usize::from(!is_near || moved < SHORT * length);
                    state = next;
                }
                None if self.level < LEVELS.len() - 1 => self.level += 1,
                None => break,
            }
        }
        Ok((state.handles, false))
    }

    fn state(&self, handles: Vectors<D>) -> Result<State<D>, Cancelled> {
        let problem = self.problem;
        let mut residual = problem.constant_right_side();
        let mut energy = problem.local_energy(&handles, &mut residual);
        problem.cancel.check()?;
        let scale = STRENGTH * problem.stiffness();
        let (barrier, narrow) = self.points.energy(&handles);
        energy += scale * barrier;
        self.points.subtract_derivative(scale, &narrow, &mut residual);
        energy += self.reactions.correct(&handles, &mut residual);
        problem.normal.subtract_matvec(&handles, &mut residual);
        Ok(State { handles, energy, residual })
    }

    /// A step along the direction that lowers the energy; `None`: there is none.
    fn searched(&self, state: &State<D>, by: &[[f64; D]]) -> Result<Option<State<D>>, Cancelled> {
        let way = self.points.way_to_crossing(&state.handles, &ahead(&state.handles, by, 1.0), POLE);
        let mut share = if way < 1.0 { CAUTION * way } else { 1.0 };
        let slope: f64 = state.residual.as_flattened().iter().zip(by.as_flattened()).map(|(x, y)| 2.0 * x * y).sum();
        for _ in 0..HALVINGS {
            let next = self.state(ahead(&state.handles, by, share))?;
            if next.energy <= state.energy - DESCENT * share * slope + ROUNDING * state.energy.abs() {
                return Ok(Some(next));
            }
            share *= 0.5;
        }
        Ok(None)
    }

    /// The step of Newton's method, with a convex matrix where the second derivative is not positive definite.
    fn direction(&mut self, state: &State<D>) -> Result<Vectors<D>, Cancelled> {
        let Self { problem, points, reactions, .. } = self;
        let Minimization { distortion, cancel, .. } = **problem;
        let narrow = points.narrow_points(&state.handles);
        let scale = STRENGTH * problem.stiffness();
        let wide = problem.normal.widened(points.bandwidth());
        let mut by = state.residual.clone();
        while let Some(&limit) = LEVELS.get(self.level) {
            let is_convex = self.level > 0;
            let mut second = wide.kron_identity::<D>(Vec::new());
            let hessian = RotationHessian { scale: problem.scales.shape, limit };
            distortion.subtract_rotation_hessian(&state.handles, hessian, &mut second, cancel);
            points.add_curvature(scale, &narrow, is_convex, &mut second);
            reactions.correct_curvature(&state.handles, is_convex, &mut second);
            cancel.check()?;
            if let Some(factor) = Factorization::of_positive(second, cancel) {
                factor.solve(by.as_flattened_mut().as_chunks_mut::<1>().0);
                return Ok(by);
            }
            cancel.check()?;
            self.level += 1;
        }
        self.level = LEVELS.len() - 1;
        problem.factor.solve(&mut by);
        Ok(by)
    }
}
