//! The knots of a trajectory, solved together: minimises Σ E(x_k) + Σ ω_k ‖d_{k+1} − d_k‖², d the displacements of the model's
//! points.
//!
//! In: problems at the times of the knots. Out: the states of the knots and the weights ω.

use super::displacement::Displacement;
use super::interior::Interior;
use super::knot::{Descent, Knot, have_branches};
use super::speed_limits::speed_limits;
use super::timeline::Coupling;
use crate::solve::cancel::Cancel;
use crate::solve::error::SolveError;
use crate::solve::point_weights::PointWeights;
use crate::solve::winding::Winding;
use rayon::prelude::*;
use std::ops::Range;

/// Largest number of sweeps between two changes of the weights.
const SWEEPS: usize = 40;

/// Largest number of changes of the weights.
const MAX_WEIGHT_UPDATES: usize = 30;

/// Number of relaxations for each knot after which a chain stays as it is, in the plane and in space, where one takes ten times as
/// long. In the plane hardly any chain needs a third of them.
const MAX_RELAXATIONS: [usize; 2] = [1000, 100];

/// Number of relaxations for which one counts where the barrier acts, because it takes about so many times as long.
const GUARDED_COST: usize = 10;

/// Same where pins give way to the barrier. The pose contradicts itself there, and no weight makes the pins arrive.
const YIELDING_COST: usize = 100;

/// A move of a knot's points by less than this, in box diagonals, does not make its neighbours be solved again.
const TOLERANCE: f64 = 2e-5;

/// Same as [`TOLERANCE`] while weights are still being raised. Stiffly coupled knots converge slowly, and choosing the next
/// weights needs no more accuracy.
const COARSE_TOLERANCE: f64 = 3e-4;

/// Smallest ratio of a weight to those of the neighbouring intervals.
const TAPER: f64 = 0.5;

/// Multiple of an interval's weight with which the energy has to be convex at three states of the interval for the motion inside to
/// count as continuous. The proximal term inside an interval has at least eight times the weight of the interval.
const CONVEX_FACTOR: f64 = 2.0;

/// The motion is steady where its speed changes by less than this from knot to knot, in units of the least speed.
const STEADY: f64 = 2.0;

/// Largest weight that exceeding the speed limit can cause, as a multiple of the initial weight. Where the model still moves too
/// far with this weight, the points do not capture its motion.
const MAX_SPEED_WEIGHT_FACTOR: f64 = 1e5;

/// Smallest and largest factor by which one change raises a weight because of the speed limit.
const GROWTH: [f64; 2] = [1.5, 30.0];

/// A window of knots, coupled by the weights of the intervals between them.
///
/// A forward pass solves every knot from the state of the previous one. Block Gauss-Seidel sweeps in red-black order then minimise
/// the sum, so that the motion does not lag behind the pins. A block is a hold: consecutive knots with one problem, which share a
/// state. Blocks of one colour have fixed neighbours, so all of them are solved at once (Y. Saad, "Iterative Methods for Sparse
/// Linear Systems", 2003, section 12.4.1). Long chains are solved in overlapping windows: the first half of a window becomes final,
/// the second half is solved again with the knots that follow.
///
/// ω_k starts as the user's weight. Where the model moves farther between two knots than the motion of pins, surface and rigid fit
/// allows, ω is raised over enough intervals for that move: it acts as the multiplier of a speed limit (J. Nocedal and S. Wright,
/// "Numerical Optimization", 2006, section 17.4).
pub(crate) struct Chain<'a, const D: usize> {
    pub(crate) knots: Vec<Option<Knot<D>>>,
    /// ω of each interval, per squared unit of the space.
    pub(crate) weights: Vec<PointWeights>,
    /// Number of leading knots that are final: 0 in the first window, then 1, the last knot of the previous window.
    settled: usize,
    /// Number of knots that the forward pass has solved.
    forward_count: usize,
    /// Initial weight of every interval.
    pub(crate) weight: f64,
    /// Speed limits of each interval: largest move of each point, in units of the space; none where nothing couples its knots.
    limits: Vec<Vec<f64>>,
    /// Whether the weight of each interval was raised for the speed limit, and not just beside such intervals.
    is_spread: Vec<bool>,
    /// The hold that each knot belongs to, ascending from 0: consecutive knots with the same problem share one state.
    hold_of: Vec<usize>,
    /// Relaxations that are left.
    remaining: usize,
    /// Winding of the pins up to the last knot.
    winding: Winding,
    coupling: Coupling,
    /// Mean diagonal of the boxes.
    diagonal: f64,
    /// Polled by the thread that solves.
    cancel: &'a Cancel<'a>,
}

impl<'a, const D: usize> Chain<'a, D> {
    /// Creates the first window of knots; nothing is solved yet.
    pub(crate) fn new(knots: Vec<Option<Knot<D>>>, coupling: &Coupling, cancel: &'a Cancel<'a>) -> Self {
        let diagonals = knots.iter().flatten().map(|knot| knot.grid().diagonal());
        let (sum, count) = diagonals.fold((0.0, 0.0), |(sum, count), diagonal| (sum + diagonal, count + 1.0));
        let diagonal: f64 = if count > 0.0 { sum / count } else { 1.0 };
        let per_frame = f64::from(coupling.knots_per_frame);
        let weight = coupling.weight * per_frame / diagonal.powi(2);
        let mut chain = Self {
            knots: Vec::new(),
            weights: Vec::new(),
            settled: 0,
            forward_count: 0,
            weight,
            limits: Vec::new(),
            is_spread: Vec::new(),
            hold_of: Vec::new(),
            remaining: 0,
            winding: Winding::default(),
            coupling: *coupling,
            diagonal,
            cancel,
        };
        chain.extend(knots);
        chain
    }

    /// Appends knots, and the intervals that lead to them.
    pub(crate) fn extend(&mut self, mut knots: Vec<Option<Knot<D>>>) {
        self.remaining += MAX_RELAXATIONS[usize::from(D > 2)] * knots.len();
        let mut take = self.knots.iter().flatten().last().map(|knot| knot.take);
        for knot in &mut knots {
            if knot.is_none() || take != knot.as_ref().map(|knot| knot.take) {
                self.winding = Winding::default();
            }
            take = knot.as_ref().map(|knot| knot.take);
            knot.iter_mut().for_each(|knot| knot.follow_winding(&mut self.winding));
        }
        let first = self.weights.len();
        self.knots.extend(knots);
        for index in first + 1..self.knots.len() {
            let (before, rest) = self.knots.split_at_mut(index);
            if let (Some(before), Some(knot)) = (in_take(before.last(), rest[0].as_ref()), &mut rest[0]) {
                knot.follow_rotation(before);
            }
        }
        let per_frame = f64::from(self.coupling.knots_per_frame);
        for pair in self.knots.windows(2).skip(first) {
            let (weight, limits) = match pair {
                [Some(knot), Some(next)] if knot.take == next.take => {
                    (self.weight, speed_limits(knot, next, self.coupling.least_speed / per_frame))
                }
                _ => (0.0, Vec::new()),
            };
            self.weights.push(PointWeights::Uniform(weight));
            self.limits.push(limits);
            self.is_spread.push(false);
        }
        self.hold_of.clear();
        let mut hold = 0;
        for index in 0..self.knots.len() {
            let is_held = index > 0 && self.is_held(index - 1);
            hold += usize::from(index > 0 && !is_held);
            self.hold_of.push(hold);
        }
    }

    /// Whether the knots at both ends of an interval have the same problem.
    fn is_held(&self, interval: usize) -> bool {
        match &self.knots[interval..=interval + 1] {
            [Some(knot), Some(next)] => next.is_held_by(knot),
            _ => false,
        }
    }

    /// The knots of a hold.
    fn knots_of(&self, hold: usize) -> Range<usize> {
        self.hold_of.partition_point(|&other| other < hold)..self.hold_of.partition_point(|&other| other <= hold)
    }

    /// Removes the first `count` knots and the intervals that begin at them. The first remaining knot becomes final.
    pub(crate) fn take_front(&mut self, count: usize) -> Vec<SettledKnot<D>> {
        let intervals = count.min(self.weights.len());
        let interiors = self.interiors(intervals);
        let settled = self.weights.drain(..intervals).zip(interiors).zip(self.is_spread.drain(..intervals));
        let mut settled =
            settled.map(|((weights, interior), is_spread)| SettledInterval { weights, interior, is_spread });
        let front = self.knots.drain(..count).map(|knot| SettledKnot {
            drawing: knot.as_ref().map_or(0, |knot| knot.drawing),
            take: knot.as_ref().map_or(0, |knot| knot.take),
            model_angle: knot.as_ref().map_or(0.0, |knot| knot.model_angle),
            state: knot.map(|knot| knot.displacement),
            interval: settled.next(),
        });
        let front = front.collect();
        drop(settled);
        self.limits.drain(..intervals);
        self.hold_of.clear();
        self.forward_count -= count;
        self.settled = 1;
        front
    }

    /// Solves all knots. `passed` is called for each knot that the forward pass reaches.
    pub(crate) fn solve(&mut self, passed: &dyn Fn()) -> Result<(), SolveError> {
        let first = self.forward_count;
        self.pass_forward(passed)?;
        self.settle(first, TOLERANCE)?;
        let mut tolerance = TOLERANCE;
        for _ in 0..MAX_WEIGHT_UPDATES {
            if self.remaining == 0 {
                return Ok(());
            }
            if self.raise_weights() {
                tolerance = COARSE_TOLERANCE;
            } else if tolerance == TOLERANCE {
                return Ok(());
            } else {
                tolerance = TOLERANCE;
            }
            self.settle(0, tolerance)?;
        }
        if tolerance > TOLERANCE { self.settle(0, TOLERANCE) } else { Ok(()) }
    }

    /// Solves every knot from the state of the previous one; the first knot, and one after a gap or a cut, alone.
    fn pass_forward(&mut self, passed: &dyn Fn()) -> Result<(), SolveError> {
        for index in self.forward_count..self.knots.len() {
            passed();
            let weights = sum(weights_beside(&self.weights, index));
            let (before, rest) = self.knots.split_at_mut(index);
            let before = in_take(before.last(), rest[0].as_ref());
            let Some(knot) = rest[0].as_mut().filter(|knot| !knot.holds_rest) else { continue };
            match before {
                Some(before) if self.hold_of[index] == self.hold_of[index - 1] => {
                    knot.displacement = before.displacement.clone();
                }
                Some(before) => {
                    knot.start_from(&before.displacement);
                    let points = &before.displacement.points;
                    knot.solve_proximal((points, &weights), Descent::Cold, self.cancel)?;
                }
                None => {
                    knot.solve_alone(self.cancel)?;
                }
            }
        }
        self.forward_count = self.knots.len();
        Ok(())
    }

    /// Sweeps until no knot moves by more than `tolerance` box diagonals. Holds before that of the knot `first - 1` are solved only if a
    /// neighbour moves.
    fn settle(&mut self, first: usize, tolerance: f64) -> Result<(), SolveError> {
        let count = self.hold_of.last().map_or(0, |hold| hold + 1);
        let first_hold = self.hold_of.get(first).copied().unwrap_or(count);
        let mut is_stale: Vec<bool> = (0..count).map(|hold| hold + 1 >= first_hold).collect();
        for half_sweep in 0..2 * SWEEPS {
            self.cancel.check()?;
            let is_due = |hold: &usize| hold % 2 == half_sweep % 2 && std::mem::take(&mut is_stale[*hold]);
            let due: Vec<usize> = (0..count).filter(is_due).collect();
            for (hold, Relaxed { moved, is_converged, cost }) in self.relax(&due)? {
                self.remaining = self.remaining.saturating_sub(cost);
                if moved > tolerance * self.diagonal {
                    is_stale[hold.saturating_sub(1)..(hold + 2).min(count)].fill(true);
                    is_stale[hold] = !is_converged;
                }
            }
            if !is_stale.contains(&true) || self.remaining == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Minimises over each of these holds, no two of which are neighbours, with all others fixed; returns what that has done
    /// to each. The knots of a hold have one state, whose energy counts for each of them.
    fn relax(&mut self, due: &[usize]) -> Result<Vec<(usize, Relaxed)>, SolveError> {
        let mut taken: Vec<(usize, Range<usize>, Option<Knot<D>>)> = Vec::with_capacity(due.len());
        for &hold in due {
            let range = self.knots_of(hold);
            let knot = self.knots[range.start].take();
            taken.push((hold, range, knot));
        }
        let (knots, weights, settled) = (&self.knots, &self.weights, self.settled);
        let relaxed = taken.par_iter_mut().map(|(hold, range, knot)| {
            let states = [range.start.checked_sub(1), Some(range.end)].map(|index| state(knots, index));
            let Some(knot) = knot.as_mut().filter(|_| range.start >= settled) else {
                return Ok((*hold, Relaxed::NONE));
            };
            let [before, _] = weights_beside(weights, range.start);
            let [_, after] = weights_beside(weights, range.end - 1);
            let beside = [before, after].map(|weights| weights.map(|weight| weight / range.len() as f64));
            Ok((*hold, relax(knot, states, &beside)?))
        });
        let moves = relaxed.collect();
        for (_, range, knot) in taken {
            let displacement = knot.as_ref().map(|knot| knot.displacement.clone());
            self.knots[range.start] = knot;
            let Some(displacement) = displacement else { continue };
            self.knots[range].iter_mut().skip(1).flatten().for_each(|held| held.displacement = displacement.clone());
        }
        moves
    }

    /// Raises the weights of points that move too far between two knots. Returns true if any weight has changed.
    fn raise_weights(&mut self) -> bool {
        let mut raised = self.weights.clone();
        for index in 0..self.weights.len() {
            let moves = self.moves(index);
            let limited = moves.iter().zip(&self.limits[index]).enumerate();
            for (point, (&length, &limit)) in limited.filter(|(_, (length, limit))| length > limit) {
                let excess = length / limit;
                let wanted = self.weights[index].of(point) * (excess * excess).clamp(GROWTH[0], GROWTH[1]);
                let weight = wanted.min(MAX_SPEED_WEIGHT_FACTOR * self.weight);
                let [first, last] = self.window((index, point), length);
                raised[first..=last].iter_mut().for_each(|slot| slot.raise(point, weight, moves.len()));
                self.is_spread[first..=last].fill(true);
            }
        }
        self.taper(&mut raised);
        let is_raised = raised != self.weights;
        self.weights = raised;
        is_raised
    }

    /// Raises weights beside higher ones to a fraction of these: a snap would otherwise move to the weaker neighbouring interval.
    fn taper(&self, raised: &mut [PointWeights]) {
        let is_coupled = |index: usize| !self.weights[index].is_zero();
        let tapered =
            |own: &PointWeights, beside: &PointWeights| own.zip(beside, |own, beside| own.max(TAPER * beside));
        for index in (1..raised.len()).filter(|&index| is_coupled(index)) {
            raised[index] = tapered(&raised[index], &raised[index - 1]);
        }
        for index in (1..raised.len()).rev().filter(|&index| is_coupled(index - 1)) {
            raised[index - 1] = tapered(&raised[index - 1], &raised[index]);
        }
    }

    /// How times within the first `count` intervals are solved.
    fn interiors(&self, count: usize) -> Vec<Interior> {
        let (knots, weights, hold_of) = (&self.knots, &self.weights, &self.hold_of);
        let convex = |weight: f64| CONVEX_FACTOR * weight;
        // Both adjacent intervals use what is known of a knot.
        let at_knot = |index: usize| {
            let coupled = weights_beside(weights, index).into_iter().filter(|weights| !weights.is_zero());
            let least = coupled.cloned().reduce(|a, b| a.zip(&b, f64::min)).map(|least| least.map(convex));
            least.zip(knots[index].as_ref()).is_none_or(|(weights, knot)| knot.is_convex(&weights))
        };
        let is_convex_at: Vec<bool> = (0..knots.len().min(count + 1)).into_par_iter().map(at_knot).collect();
        let least_speed = self.coupling.least_speed;
        let interior = |index: usize| {
            let [Some(knot), Some(next)] = &knots[index..=index + 1] else { return Interior::Coupled };
            // The model stands still during a hold.
            if hold_of[index] == hold_of[index + 1] {
                return Interior::Interpolated;
            }
            // Motion between two drawings is discontinuous on purpose, and none leads across a cut.
            if knot.drawing != next.drawing || knot.take != next.take {
                return Interior::Coupled;
            }
            let is_convex = is_convex_at[index]
                && is_convex_at[index + 1]
                && knot.is_convex_halfway(next, &weights[index].map(convex));
            // Branches may split between the knots.
            let is_tested = knot.system.has_second_derivative() && !have_branches([knot, next]);
            let is_continuous = is_convex && (is_tested || is_steady(knots, index, least_speed));
            if is_continuous { Interior::Coupled } else { Interior::Interpolated }
        };
        (0..count).into_par_iter().map(interior).collect()
    }

    /// How far each point moves in an interval, relative to the rigid fit.
    fn moves(&self, index: usize) -> Vec<f64> {
        match &self.knots[index..=index + 1] {
            [Some(knot), Some(next)] => knot.displacement.distances(&next.displacement).collect(),
            _ => Vec::new(),
        }
    }

    /// First and last of the intervals around `index` that a point needs for a move of this length to stay within their limits.
    fn window(&self, (index, point): (usize, usize), length: f64) -> [usize; 2] {
        let limit = |index: usize| self.limits[index].get(point).copied().unwrap_or(f64::INFINITY);
        let (mut first, mut last, mut sum) = (index, index, limit(index));
        let is_coupled = |index: usize| self.weights.get(index).is_some_and(|weights| !weights.is_zero());
        // Nothing is carried across a knot that holds rest.
        let gives_way = |knot: usize| self.knots[knot].as_ref().is_some_and(|knot| !knot.holds_rest);
        while sum < length {
            let before = sum;
            if first > 0 && is_coupled(first - 1) && gives_way(first) {
                first -= 1;
                sum += limit(first);
            }
            if is_coupled(last + 1) && gives_way(last + 1) {
                last += 1;
                sum += limit(last);
            }
            if sum == before {
                break;
            }
        }
        [first, last]
    }
}

/// A knot removed from the chain, with its final state.
pub(crate) struct SettledKnot<const D: usize> {
    /// The state; `None` if nothing is solved at the knot.
    pub(crate) state: Option<Displacement<D>>,
    /// The drawing that the knot belongs to.
    pub(crate) drawing: i64,
    /// Number of cuts of the camera before the knot.
    pub(crate) take: i64,
    /// Rotation of the model at the knot.
    pub(crate) model_angle: f64,
    /// The interval that begins at the knot; `None` at the last knot.
    pub(crate) interval: Option<SettledInterval>,
}

/// An interval removed from the chain.
pub(crate) struct SettledInterval {
    /// ω.
    pub(crate) weights: PointWeights,
    /// How times within it are solved.
    pub(crate) interior: Interior,
    /// Whether a fast motion is spread over it.
    pub(crate) is_spread: bool,
}

/// The knot before, unless a gap or a cut lies between.
fn in_take<'a, const D: usize>(before: Option<&'a Option<Knot<D>>>, knot: Option<&Knot<D>>) -> Option<&'a Knot<D>> {
    before?.as_ref().filter(|before| knot.is_some_and(|knot| knot.take == before.take))
}

/// Whether the speed hardly changes at both ends of an interval.
fn is_steady<const D: usize>(knots: &[Option<Knot<D>>], index: usize, least_speed: f64) -> bool {
    let is_steady = |at: usize| match [at.checked_sub(1), Some(at), Some(at + 1)].map(|at| state(knots, at)) {
        [Some(before), Some(here), Some(after)] => {
            2.0 * before.interpolated(after, 0.5).farthest(here) < STEADY * least_speed
        }
        _ => true,
    };
    is_steady(index) && is_steady(index + 1)
}

/// The state of a knot; `None` if there is none.
fn state<const D: usize>(knots: &[Option<Knot<D>>], index: Option<usize>) -> Option<&Displacement<D>> {
    Some(&knots.get(index?)?.as_ref()?.displacement)
}

/// The weights of the intervals before and after a knot; 0 where there is none.
fn weights_beside(weights: &[PointWeights], index: usize) -> [&PointWeights; 2] {
    let of =
        |interval: Option<usize>| interval.and_then(|interval| weights.get(interval)).unwrap_or(&PointWeights::ZERO);
    [of(index.checked_sub(1)), of(Some(index))]
}

fn sum([a, b]: [&PointWeights; 2]) -> PointWeights {
    a.zip(b, |a, b| a + b)
}

/// What a relaxation has done to a knot.
#[derive(Clone, Copy, Debug)]
struct Relaxed {
    /// Largest move of its points.
    moved: f64,
    /// Whether its minimum was reached.
    is_converged: bool,
    /// Number of relaxations for which it counts.
    cost: usize,
}

impl Relaxed {
    const NONE: Self = Self { moved: 0.0, is_converged: true, cost: 1 };
}

/// Minimises over a knot whose neighbours have these states and weights.
fn relax<const D: usize>(
    knot: &mut Knot<D>,
    states: [Option<&Displacement<D>>; 2],
    [start, end]: &[PointWeights; 2],
) -> Result<Relaxed, SolveError> {
    let weights = sum([start, end]);
    if weights.is_zero() || knot.holds_rest {
        return Ok(Relaxed::NONE);
    }
    let drawn_to = match states {
        [Some(before), Some(after)] => before.points_between(after, |point| end.of(point) / weights.of(point)),
        [Some(only), None] | [None, Some(only)] => only.points.clone(),
        [None, None] => return Ok(Relaxed::NONE),
    };
    let before = knot.displacement.clone();
    let result = knot.solve_proximal((&drawn_to, &weights), Descent::Warm, &Cancel::never())?;
    let cost = match (knot.system.is_free_of_barrier(&result.handles), result.has_given_way) {
        (true, _) => 1,
        (false, false) => GUARDED_COST,
        (false, true) => YIELDING_COST,
    };
    Ok(Relaxed { moved: before.farthest(&knot.displacement), is_converged: result.is_converged, cost })
}
