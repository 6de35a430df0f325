//! Search for jumps in the motion between two knots, by recursive bisection in time.
//!
//! In: two knots, the weight of their interval, the problem at any time between them. Out: the weight with which no jump is
//! found.
//!
//! The state halfway between two times is compared with the mean of the states at these times, and with the parabola through
//! three states of the interval one level up. For smooth motion the differences fall by factors of four and eight with every
//! halving; at a jump of length J they stay J / 2 and at least 3 J / 8, however short the interval (bisection: R. P. Brent,
//! "Algorithms for Minimization without Derivatives", 1973).

use super::displacement::Displacement;
use super::knot::{Descent, Knot};
use super::timeline::Coupling;
use crate::solve::cancel::Cancel;

/// Depth to which an interval is bisected in its first search if a jump cannot be ruled out: a jump of all points could lie
/// exactly in the middle.
const MIN_DEPTH: u32 = 2;

/// Largest depth of the bisection; motion that is still uneven there is a jump.
const MAX_DEPTH: u32 = 11;

/// Multiple of an interval's weight with which the energy has to be convex for the search for jumps to be skipped. The proximal
/// term inside an interval has at least eight times the weight of the interval.
pub(super) const CONVEX_FACTOR: f64 = 2.0;

/// The motion is steady where its speed changes by less than this from knot to knot, in units of the least speed.
const STEADY: f64 = 2.0;

/// Tolerance of the search for jumps, as a fraction of the least speed.
const JUMP_TOLERANCE: f64 = 0.25;

/// The search for a weight with continuous motion tries this many, each twice the one before.
const DOUBLINGS: i32 = 16;

/// Builds the unsolved knot of a time; `None` if there is no problem at that time.
pub(super) type Probe<'a, const D: usize> = &'a (dyn Fn(f64) -> Option<Knot<D>> + Sync);

/// Weight of the proximal term at the fraction `s` of an interval. Half of the energy of a time counts for each side, as in the
/// trapezoidal rule, so that the motion has no kinks at knots.
pub(super) fn weight_between(weight: f64, s: f64) -> f64 {
    2.0 * weight / (s * (1.0 - s))
}

/// What the search for jumps knows of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Searched {
    /// Nothing.
    Never,
    /// Its motion was continuous with other states of its knots, or with a lower weight.
    Before,
    /// Its motion is continuous.
    Now,
}

/// The motion between two knots.
struct Interval<'a, const D: usize> {
    ends: [&'a Displacement<D>; 2],
    /// Builds the unsolved problem at a fraction of the interval, 0 to 1; `None` if there is no problem.
    probe: &'a dyn Fn(f64) -> Option<Knot<D>>,
    /// The problems built so far, with their fractions of the interval.
    probed: Vec<(f64, Option<Knot<D>>)>,
    /// Largest difference between a state and the mean of its neighbours in continuous motion, in units of the space.
    tolerance: f64,
    /// Depth to which the interval is bisected in any case.
    min_depth: u32,
}

impl<'a, const D: usize> Interval<'a, D> {
    fn new(
        ends: [&'a Displacement<D>; 2],
        probe: &'a dyn Fn(f64) -> Option<Knot<D>>,
        tolerance: f64,
        min_depth: u32,
    ) -> Self {
        Self { ends, probe, probed: Vec::new(), tolerance, min_depth }
    }

    /// Whether no jump is found between the knots with this weight.
    fn is_continuous(&mut self, weight: f64) -> bool {
        let [before, after] = self.ends;
        self.is_even([0.0, 1.0], [before, after, before], weight, 0)
    }

    /// Whether the motion between two times is even, or becomes so under bisection. `states`: those of the two times, and that of
    /// the far end of the interval one level up, of which the second time is the middle; at depth 0 there is none.
    fn is_even(&mut self, times: [f64; 2], states: [&Displacement<D>; 3], weight: f64, depth: u32) -> bool {
        let middle = f64::midpoint(times[0], times[1]);
        let Some(state) = self.state(middle, weight) else { return true };
        let [outer, inner, beyond] = states;
        let mean = outer.interpolated(inner, 0.5);
        // 3/8 outer + 3/4 inner - 1/8 beyond.
        let parabola = || mean.interpolated(&inner.interpolated(beyond, -0.5), 0.25);
        let is_near = |expected: &Displacement<D>| expected.farthest(&state) < self.tolerance;
        let is_even = is_near(&mean) || depth > 0 && is_near(&parabola());
        if is_even && depth >= self.min_depth {
            return true;
        }
        depth < MAX_DEPTH
            && self.is_even([times[0], middle], [outer, &state, inner], weight, depth + 1)
            && self.is_even([times[1], middle], [inner, &state, outer], weight, depth + 1)
    }

    /// The state at a fraction of the interval, computed as by [`super::Trajectory::solve_at`].
    fn state(&mut self, part: f64, weight: f64) -> Option<Displacement<D>> {
        let place = match self.probed.iter().position(|(known, _)| *known == part) {
            Some(place) => place,
            None => {
                self.probed.push((part, (self.probe)(part)));
                self.probed.len() - 1
            }
        };
        let knot = self.probed[place].1.as_mut()?;
        let drawn_to = self.ends[0].interpolated(self.ends[1], part);
        knot.start_from(&drawn_to);
        let weight = weight_between(weight, part);
        knot.solve_proximal((&drawn_to.points, weight), Descent::Cold, &Cancel::never()).ok()?;
        Some(knot.displacement.clone())
    }
}

/// The data that the search for jumps needs; shared by threads.
pub(super) struct JumpSearch<'a, const D: usize> {
    pub(super) knots: &'a [Option<Knot<D>>],
    pub(super) weights: &'a [f64],
    /// Number of knots of the trajectory before the first of `knots`.
    pub(super) removed_count: usize,
    pub(super) coupling: Coupling,
    pub(super) probe: Probe<'a, D>,
}

impl<const D: usize> JumpSearch<'_, D> {
    /// The weight of an interval, doubled until no jump is found in it; the initial weight if none is large enough, because the
    /// jump is in a region without points. The interval is not searched if the motion around it is steady and the energy is
    /// convex at both knots and halfway between them.
    pub(super) fn continuous_weight(&self, index: usize, searched: Searched) -> f64 {
        let initial = self.weights[index];
        if searched == Searched::Now {
            return initial;
        }
        let [Some(knot), Some(next)] = &self.knots[index..=index + 1] else { return initial };
        // Motion between two drawings is discontinuous on purpose.
        if knot.drawing != next.drawing {
            return initial;
        }
        let is_convex = knot.is_convex_up_to(next, CONVEX_FACTOR * initial);
        if is_convex && self.is_steady(index) {
            return initial;
        }
        let times = [index, index + 1].map(|knot| self.coupling.knot_time(self.removed_count + knot));
        let probe = |part: f64| (self.probe)(times[0] + part * (times[1] - times[0]));
        let tolerance = JUMP_TOLERANCE * self.coupling.least_speed;
        let ends = [&knot.displacement, &next.displacement];
        let min_depth = if is_convex || searched == Searched::Before { 0 } else { MIN_DEPTH };
        let mut interval = Interval::new(ends, &probe, tolerance, min_depth);
        let weight = |doublings: i32| initial * 2_f64.powi(doublings);
        let doublings = least_holding(DOUBLINGS, |doublings| interval.is_continuous(weight(doublings)));
        doublings.map_or(initial, weight)
    }

    /// Whether the speed hardly changes at both ends of an interval.
    fn is_steady(&self, index: usize) -> bool {
        let is_steady = |at: usize| match [at.checked_sub(1), Some(at), Some(at + 1)].map(|at| state(self.knots, at)) {
            [Some(before), Some(here), Some(after)] => {
                2.0 * before.interpolated(after, 0.5).farthest(here) < STEADY * self.coupling.least_speed
            }
            _ => true,
        };
        is_steady(index) && is_steady(index + 1)
    }
}

/// The state of a knot; `None` if there is none.
pub(super) fn state<const D: usize>(knots: &[Option<Knot<D>>], index: Option<usize>) -> Option<&Displacement<D>> {
    Some(&knots.get(index?)?.as_ref()?.displacement)
}

/// The least number from 0 to `limit` that holds, if all above it do; `None` if `limit` does not. Galloping, then bisection.
fn least_holding(limit: i32, mut holds: impl FnMut(i32) -> bool) -> Option<i32> {
    if holds(0) {
        return Some(0);
    }
    let [mut below, mut found] = [0, 1];
    while !holds(found) {
        if found == limit {
            return None;
        }
        [below, found] = [found, (2 * found).min(limit)];
    }
    while found - below > 1 {
        let middle = i32::midpoint(below, found);
        *if holds(middle) { &mut found } else { &mut below } = middle;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::least_holding;

    #[test]
    fn the_least_number_that_holds_is_found_with_few_questions() {
        for wanted in 0..=16 {
            let mut asked = 0;
            let found = least_holding(16, |number| {
                asked += 1;
                number >= wanted
            });
            assert_eq!(found, Some(wanted));
            assert!(asked <= 9, "{asked} questions for {wanted}");
        }
        assert_eq!(least_holding(16, |_| false), None);
    }
}
