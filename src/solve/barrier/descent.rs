//! Newton's method for the energy with the barrier: descends from a state without folds to a minimum without folds.
//!
//! In: the minimum of the energy without the barrier. Out: the same state if every point of the barrier is clear (det J ≥ 0.2),
//! else a minimum with the barrier. Every step lowers the energy and ends before det J reaches the pole of the potential at any
//! point.

use super::points::{BarrierPoints, FINE};
use super::potential::{ACTIVATION_DET, MIN_DET};
use super::reactions::Reactions;
use crate::smoothstep::smoothstep;
use crate::solve::cancel::Cancelled;
use crate::solve::energy::RotationHessian;
use crate::solve::linalg::factorization::Factorization;
use crate::solve::minimization::{Minimization, MinimizationResult, largest_step};
use std::collections::BTreeMap;

/// Strength of the barrier, in units of the stiffness of the shape.
const STRENGTH: f64 = 1.0;

/// Minimum det J of the start state where the descent starts from the problem itself.
const FIRST: f64 = 2.5 * MIN_DET;

/// Minimum det J that the previous state of a similar problem must have for the descent to start from it.
const LAST: f64 = 1.01 * MIN_DET;

/// Fraction of the distance to the pole that a step may take.
const CAUTION: f64 = 0.9;

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

/// Upper limits of 1/(s1 + s2), tried in this order: the true second derivative, then increasingly convex matrices, as in
/// Newton's method without the barrier.
const LEVELS: [f64; 3] = [f64::INFINITY, 0.75, 0.5];

/// Maximum number of refinements, each of which doubles the points per axis in the cells that fold between their points.
const REFINEMENTS: usize = 2;

/// Maximum number of trials of the line search, each with half the step.
const HALVINGS: usize = 20;

/// Armijo constant: the fraction of the linear prediction by which a step must lower the energy.
const DESCENT: f64 = 1e-4;

/// Relative rounding error of energies.
const ROUNDING: f64 = 1e-11;

type Vectors<const D: usize> = Vec<[f64; D]>;

/// A state with its energy and residual, which is minus half the derivative of the energy.
struct State<const D: usize> {
    handles: Vectors<D>,
    energy: f64,
    residual: Vectors<D>,
}

impl<const D: usize> Minimization<'_, D> {
    /// Stiffness of the shape: the unit in which the energies of barrier and pins are measured, of the order of the largest shape
    /// energy.
    pub(super) fn stiffness(&self) -> f64 {
        self.scales.shape * self.distortion.mass()
    }

    /// Returns `free`, the minimum without the barrier, if it is clear, else a minimum with the barrier. The descent starts from
    /// `before`, the state of a similar problem, where that is given and has no point close to the pole.
    pub(crate) fn with_barrier(
        &self,
        free: MinimizationResult<D>,
        before: Option<&[[f64; D]]>,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let Some(barrier) = self.barrier.filter(|barrier| !barrier.is_clear(&free.handles)) else { return Ok(free) };
        let mut reactions = Reactions::new(self);
        // The force limits of the pins rise with the remaining determinant, so that pins do not give way suddenly where the
        // barrier begins to act.
        let share = smoothstep(barrier.min_det(&free.handles) / ACTIVATION_DET);
        reactions.initialise_multipliers(&self.unconstrained_step(&free.handles)?, share);
        let mut result = free;
        let mut finer = BTreeMap::new();
        for round in 0..=REFINEMENTS {
            let refined = (!finer.is_empty()).then(|| barrier.refined(&finer));
            let points = refined.as_ref().unwrap_or_else(|| barrier.points());
            let first = match before.filter(|before| round == 0 && points.min_det(before, LAST) >= LAST) {
                Some(before) => before.to_vec(),
                None => {
                    let share = points.max_step(&self.start, &result.handles, FIRST);
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

    /// Takes one local-global step without enforcing hard constraints. Each hard row then misses its target by its force divided
    /// by its stiffness.
    fn unconstrained_step(&self, handles: &[[f64; D]]) -> Result<Vectors<D>, Cancelled> {
        let mut next = self.constant_right_side();
        self.local_energy(handles, &mut next);
        self.cancel.check()?;
        self.factor.solve(&mut next);
        Ok(next)
    }
}

/// Returns (1 − t) · from + t · to.
fn blend<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(to).map(|(a, b)| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t)).collect()
}

/// Returns from + t · by.
fn ahead<const D: usize>(from: &[[f64; D]], by: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(by).map(|(a, b)| std::array::from_fn(|d| t.mul_add(b[d], a[d]))).collect()
}

/// State of the descent.
struct Descent<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    points: &'a BarrierPoints<D>,
    reactions: Reactions<'a, D>,
    iterations: usize,
    /// Index into [`LEVELS`]: 0 is the true second derivative, higher levels are convex matrices.
    level: usize,
}

impl<const D: usize> Descent<'_, D> {
    /// Minimises the energy, and updates the multipliers to the forces of the pins after each minimum.
    fn run(&mut self, first: Vectors<D>) -> Result<MinimizationResult<D>, Cancelled> {
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

    /// Returns the minimum for the present multipliers, and whether the steps converged.
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
                let is_open = self.points.max_step(&state.handles, &full, MIN_DET) >= 1.0;
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
        let (barrier, penalised) = self.points.energy(&handles);
        energy += scale * barrier;
        self.points.subtract_derivative(scale, &penalised, &mut residual);
        energy += self.reactions.correct(&handles, &mut residual);
        problem.normal.subtract_matvec(&handles, &mut residual);
        Ok(State { handles, energy, residual })
    }

    /// Line search along `by` (backtracking with the Armijo condition); `None` if no trial lowers the energy enough.
    fn searched(&self, state: &State<D>, by: &[[f64; D]]) -> Result<Option<State<D>>, Cancelled> {
        let way = self.points.max_step(&state.handles, &ahead(&state.handles, by, 1.0), MIN_DET);
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

    /// Returns the Newton step. Raises the level until the matrix is positive definite; if none is, the constant matrix of the
    /// local-global steps takes its place.
    fn direction(&mut self, state: &State<D>) -> Result<Vectors<D>, Cancelled> {
        let Self { problem, points, reactions, .. } = self;
        let Minimization { distortion, cancel, .. } = **problem;
        let penalised = points.penalised_points(&state.handles);
        let scale = STRENGTH * problem.stiffness();
        let wide = problem.normal.widened(points.bandwidth());
        let mut by = state.residual.clone();
        while let Some(&limit) = LEVELS.get(self.level) {
            let is_convex = self.level > 0;
            let mut second = wide.kron_identity::<D>(Vec::new());
            let hessian = RotationHessian { scale: problem.scales.shape, limit };
            distortion.subtract_rotation_hessian(&state.handles, hessian, &mut second, cancel);
            points.add_curvature(scale, &penalised, is_convex, &mut second);
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
