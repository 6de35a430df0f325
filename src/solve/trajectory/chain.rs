//! The knots of a trajectory, solved together: Σ E(x_k) + Σ ω_k ‖d_{k+1} − d_k‖², d the displacement of the model's points.
//!
//! In: knots at their times. Out: their states, the weights ω and where they had to be raised.
//!
//! A pass forward continues every knot from the one before; block Gauss-Seidel sweeps, backward and forward in turn, then
//! bring the sum to a minimum, so that no knot lags. ω_k begins as the user's weight. Where the model moves farther between two
//! knots than pins, surface and rigid fit give reason for, ω is raised over as many knots as that move needs: the multiplier of
//! a limit of the speed (J. Nocedal and S. Wright, "Numerical Optimization", 2006, section 17.4).

use super::knot::{Descent, Displacement, Knot};
use super::timeline::Coupling;
use crate::solve::cancel::Cancel;
use crate::solve::error::SolveError;

/// A knot may move this many times as far as what gives reason to.
const FREEDOM: f64 = 2.0;

/// Sweeps between two changes of weights, at most.
const SWEEPS: usize = 40;

/// Changes of weights, at most.
const ROUNDS: usize = 30;

/// A knot whose points move less than this part of the box diagonal does not disturb its neighbours.
const TOLERANCE: f64 = 2e-5;

/// An interval holds a proximal term of at least four times its weight; this much of it has to make the energy convex.
const CONVEX_SHARE: f64 = 2.0;

/// A weight is at least this part of its neighbours'.
const TAPER: f64 = 0.5;

/// Doublings of a weight until the energy is convex, at most.
const DOUBLINGS: usize = 16;

/// Limits of the factor by which a weight is raised at once.
const GROWTH: [f64; 2] = [1.5, 30.0];

/// Knots and what couples them.
pub(crate) struct Chain<'a, const D: usize> {
    pub(crate) knots: Vec<Option<Knot<D>>>,
    /// One an interval: ω, in squared units of the space.
    pub(crate) weights: Vec<f64>,
    /// The weight they begin with.
    pub(crate) weight: f64,
    /// One an interval: how far points may move, in units of the space.
    limits: Vec<f64>,
    /// One an interval: known to be convex where its knots are.
    is_convex: Vec<bool>,
    tolerance: f64,
    cancel: &'a Cancel<'a>,
}

impl<'a, const D: usize> Chain<'a, D> {
    /// Couples knots; they are not solved yet.
    pub(crate) fn new(knots: Vec<Option<Knot<D>>>, coupling: &Coupling, cancel: &'a Cancel<'a>) -> Self {
        let diagonals = knots.iter().flatten().map(|knot| knot.grid().diagonal());
        let (sum, count) = diagonals.fold((0.0, 0.0), |(sum, count), diagonal| (sum + diagonal, count + 1.0));
        let diagonal: f64 = if count > 0.0 { sum / count } else { 1.0 };
        let per_frame = f64::from(coupling.knots_per_frame);
        let weight = coupling.weight * per_frame / diagonal.powi(2);
        let is_coupled = |pair: &[Option<Knot<D>>]| pair.iter().all(Option::is_some);
        let weights = knots.windows(2).map(|pair| if is_coupled(pair) { weight } else { 0.0 }).collect();
        let limit = |pair: &[Option<Knot<D>>]| match pair {
            [Some(knot), Some(next)] => FREEDOM * knot.motion(next) + coupling.least_speed / per_frame,
            _ => f64::INFINITY,
        };
        let limits: Vec<f64> = knots.windows(2).map(limit).collect();
        let is_convex = vec![false; limits.len()];
        Self { knots, weights, weight, limits, is_convex, tolerance: TOLERANCE * diagonal, cancel }
    }

    /// Solves all knots; `passed` hears how many the pass forward has solved.
    pub(crate) fn solve(&mut self, passed: &dyn Fn(usize)) -> Result<(), SolveError> {
        self.pass_forward(passed)?;
        self.settle()?;
        for _ in 0..ROUNDS {
            if !self.tighten() {
                break;
            }
            self.settle()?;
        }
        Ok(())
    }

    /// Every knot from the one before; the first, and one after a gap, alone.
    fn pass_forward(&mut self, passed: &dyn Fn(usize)) -> Result<(), SolveError> {
        for index in 0..self.knots.len() {
            passed(index + 1);
            let weight = self.pull(index);
            let (before, rest) = self.knots.split_at_mut(index);
            let Some(knot) = &mut rest[0] else { continue };
            match before.last() {
                Some(Some(before)) => {
                    knot.displacement = before.displacement.clone();
                    let points = &before.displacement.points;
                    knot.solve_near((points, weight), Descent::Cold, self.cancel)?;
                }
                _ => {
                    knot.solve_alone(self.cancel)?;
                }
            }
        }
        Ok(())
    }

    /// Sum of the weights at a knot.
    fn pull(&self, index: usize) -> f64 {
        let before = if index > 0 { self.weights[index - 1] } else { 0.0 };
        before + self.weights.get(index).copied().unwrap_or(0.0)
    }

    /// Sweeps until nothing moves.
    fn settle(&mut self) -> Result<(), SolveError> {
        let count = self.knots.len();
        let mut is_stale = vec![true; count];
        for sweep in 0..SWEEPS {
            for step in 0..count {
                let index = if sweep % 2 == 0 { count - 1 - step } else { step };
                if std::mem::take(&mut is_stale[index]) && self.relax(index)? > self.tolerance {
                    is_stale[index.saturating_sub(1)..(index + 2).min(count)].fill(true);
                    is_stale[index] = false;
                    self.is_convex[index.saturating_sub(1)..(index + 1).min(count - 1)].fill(false);
                }
            }
            if !is_stale.contains(&true) {
                break;
            }
        }
        Ok(())
    }

    /// Minimises over one knot; how far its points moved.
    fn relax(&mut self, index: usize) -> Result<f64, SolveError> {
        let weight = self.pull(index);
        if weight == 0.0 {
            return Ok(0.0);
        }
        let share = self.weights.get(index).copied().unwrap_or(0.0) / weight;
        let state = |index: Option<usize>| Some(&self.knots.get(index?)?.as_ref()?.displacement);
        let drawn_to = match (state(index.checked_sub(1)), state(Some(index + 1))) {
            (Some(before), Some(after)) => before.interpolated(after, share),
            (Some(only), None) | (None, Some(only)) => only.clone(),
            (None, None) => return Ok(0.0),
        };
        let Some(knot) = &mut self.knots[index] else { return Ok(0.0) };
        let before = knot.displacement.clone();
        knot.solve_near((&drawn_to.points, weight), Descent::Warm, self.cancel)?;
        Ok(before.farthest(&knot.displacement))
    }

    /// Raises the weights where the model moves too far between two knots; false where it does nowhere.
    fn tighten(&mut self) -> bool {
        let excess: Vec<f64> = (0..self.weights.len()).map(|index| self.excess(index)).collect();
        let mut raised = self.weights.clone();
        for (index, &excess) in excess.iter().enumerate().filter(|(_, excess)| **excess > 1.0) {
            let weight = self.weights[index] * (excess * excess).clamp(GROWTH[0], GROWTH[1]);
            let [first, last] = self.window(index, excess * self.limits[index]);
            raised[first..=last].iter_mut().for_each(|slot| *slot = slot.max(weight));
        }
        for (index, slot) in raised.iter_mut().enumerate() {
            *slot = slot.max(self.convex_weight(index));
        }
        self.taper(&mut raised);
        let is_raised = raised != self.weights;
        self.weights = raised;
        is_raised
    }

    /// Weights fall off slowly from interval to interval: a snap must not hop to a neighbour that is weaker.
    fn taper(&self, raised: &mut [f64]) {
        let is_coupled = |index: usize| self.weights[index] > 0.0;
        for index in (1..raised.len()).filter(|&index| is_coupled(index)) {
            raised[index] = raised[index].max(TAPER * raised[index - 1]);
        }
        for index in (1..raised.len()).rev().filter(|&index| is_coupled(index - 1)) {
            raised[index - 1] = raised[index - 1].max(TAPER * raised[index]);
        }
    }

    /// The weight of an interval, doubled until the energy is convex between its knots.
    fn convex_weight(&mut self, index: usize) -> f64 {
        let mut weight = self.weights[index];
        let [Some(knot), Some(next)] = &self.knots[index..=index + 1] else { return weight };
        if std::mem::replace(&mut self.is_convex[index], true) {
            return weight;
        }
        for _ in 0..DOUBLINGS {
            let held = CONVEX_SHARE * weight;
            if knot.is_convex_towards(&next.displacement, held, self.cancel)
                && next.is_convex_towards(&knot.displacement, held, self.cancel)
            {
                break;
            }
            weight *= 2.0;
        }
        weight
    }

    /// How far an interval moves over its limit, as a ratio.
    fn excess(&self, index: usize) -> f64 {
        match &self.knots[index..=index + 1] {
            [Some(knot), Some(next)] => knot.displacement.farthest(&next.displacement) / self.limits[index],
            _ => 0.0,
        }
    }

    /// The intervals around one over which a move of this length stays within the limits.
    fn window(&self, index: usize, length: f64) -> [usize; 2] {
        let (mut first, mut last, mut sum) = (index, index, self.limits[index]);
        let is_coupled = |index: usize| self.weights.get(index).is_some_and(|&weight| weight > 0.0);
        while sum < length {
            let before = sum;
            if first > 0 && is_coupled(first - 1) {
                first -= 1;
                sum += self.limits[first];
            }
            if is_coupled(last + 1) {
                last += 1;
                sum += self.limits[last];
            }
            if sum == before {
                break;
            }
        }
        [first, last]
    }

    /// The states of all knots.
    pub(crate) fn into_states(self) -> Vec<Option<Displacement<D>>> {
        self.knots.into_iter().map(|knot| knot.map(|knot| knot.displacement)).collect()
    }
}
