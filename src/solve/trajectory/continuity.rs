//! Search for jumps in the motion between two knots, by recursive bisection in time.
//!
//! In: two knots, the weight of their interval, the problem at any time between them. Out: whether a jump was found.
//!
//! The state halfway between two times is compared with the mean of the states at these times. For smooth motion the difference
//! falls by a factor of four with every halving; at a jump of length J it stays J / 2, however short the interval (bisection: R.
//! P. Brent, "Algorithms for Minimization without Derivatives", 1973).

use super::displacement::Displacement;
use super::knot::{Descent, Knot};
use crate::solve::cancel::Cancel;

/// Depth to which an interval is always bisected if a jump cannot be ruled out: a jump of all points could lie exactly in the
/// middle.
pub(crate) const LEAST_DEPTH: u32 = 2;

/// Largest depth of the bisection; motion that is still uneven there is a jump.
const MOST_DEPTH: u32 = 11;

/// Weight of the proximal term at the fraction `s` of an interval. Half of the energy of a time counts for each side, as in the
/// trapezoidal rule, so that the motion has no kinks at knots.
pub(super) fn weight_between(weight: f64, s: f64) -> f64 {
    2.0 * weight / (s * (1.0 - s))
}

/// The motion between two knots.
pub(crate) struct Interval<'a, const D: usize> {
    ends: [&'a Displacement<D>; 2],
    /// Builds the unsolved problem at a fraction of the interval, 0 to 1; `None` if there is no problem.
    probe: &'a dyn Fn(f64) -> Option<Knot<D>>,
    /// The problems built so far, with their fractions of the interval.
    probed: Vec<(f64, Option<Knot<D>>)>,
    /// Largest difference between a state and the mean of its neighbours in continuous motion, in units of the space.
    tolerance: f64,
    /// Depth to which the interval is bisected in any case.
    least_depth: u32,
}

impl<'a, const D: usize> Interval<'a, D> {
    pub(crate) fn new(
        ends: [&'a Displacement<D>; 2],
        probe: &'a dyn Fn(f64) -> Option<Knot<D>>,
        tolerance: f64,
        least_depth: u32,
    ) -> Self {
        Self { ends, probe, probed: Vec::new(), tolerance, least_depth }
    }

    /// Whether no jump is found between the knots with this weight.
    pub(crate) fn is_continuous(&mut self, weight: f64) -> bool {
        let ends = self.ends.map(Clone::clone);
        self.is_even([0.0, 1.0], &ends, weight, 0)
    }

    /// Whether the motion between two times is even, or becomes so under bisection.
    fn is_even(
        &mut self,
        [from, to]: [f64; 2],
        [before, after]: &[Displacement<D>; 2],
        weight: f64,
        depth: u32,
    ) -> bool {
        let middle = f64::midpoint(from, to);
        let Some(state) = self.state(middle, weight) else { return true };
        let is_even = before.interpolated(after, 0.5).farthest(&state) < self.tolerance;
        if is_even && depth >= self.least_depth {
            return true;
        }
        if depth >= MOST_DEPTH {
            return false;
        }
        let halves = [([from, middle], [before.clone(), state.clone()]), ([middle, to], [state, after.clone()])];
        for (times, states) in halves {
            if !self.is_even(times, &states, weight, depth + 1) {
                return false;
            }
        }
        true
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
        knot.solve_near((&drawn_to.points, weight), Descent::Cold, &Cancel::never()).ok()?;
        Some(knot.displacement.clone())
    }
}
