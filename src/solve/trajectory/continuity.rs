//! Search for jumps in the motion between two knots, by recursive bisection in time.
//!
//! In: solved knots, the problem at any time between two of them. Out: the weight of the proximal term between them with which no
//! jump is found, or the largest, as a multiple of that which couples the knots.
//!
//! The state halfway between two times is compared with the mean of the states at these times, and with the parabola through
//! three states of the interval one level up. For smooth motion the differences fall by factors of four and eight with every
//! halving; at a jump of length J they stay J / 2 and at least 3 J / 8, however short the interval (bisection: R. P. Brent,
//! "Algorithms for Minimization without Derivatives", 1973).

use super::displacement::Displacement;
use super::knot::Knot;
use super::solved_knots::SolvedKnots;
use crate::solve::cancel::Cancel;

/// Largest depth of the bisection; motion that is still uneven there is a jump.
const MAX_DEPTH: u32 = 7;

/// Motion is a jump where the difference from the mean stays above this fraction of itself over two halvings in succession: that
/// of smooth motion falls to a quarter, at a kink to a half.
const LASTING: f64 = 0.75;

/// Tolerance of the search for jumps, as a fraction of the least speed.
const JUMP_TOLERANCE: f64 = 0.25;

/// Multiples of an interval's weight that are tried until the motion is continuous.
const FACTORS: [f64; 3] = [1.0, 256.0, 65536.0];

/// The factor with which the motion is practically the interpolation of the knots.
pub(super) const INTERPOLATING: f64 = FACTORS[FACTORS.len() - 1];

/// Number of halvings that measure a jump.
const JUMP_DEPTH: u32 = 10;

/// The largest weight shortens a jump if it leaves less than this fraction of it.
const SHORTER: f64 = 0.5;

/// How times between two knots are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interior {
    /// With the weight that couples the knots: there can be no jump.
    Coupled,
    /// With the smallest weight with which no jump is found. The interval is bisected at least so many times, and more often where
    /// its motion is uneven.
    Searched {
        /// Depth to which the interval is bisected in any case.
        min_depth: u32,
    },
    /// With a weight so large that the motion is practically the interpolation of the knots, because a search would take too long: of
    /// large lattices, and of branching ones, which are split anew at every time.
    Interpolated,
}

impl Interior {
    /// The depth to which an interval is bisected in any case where a jump cannot be ruled out: a jump of all points could lie
    /// exactly in the middle.
    pub(super) const LIKELY_JUMP: Self = Self::Searched { min_depth: 2 };
    /// The same where the energy is convex.
    pub(super) const UNLIKELY_JUMP: Self = Self::Searched { min_depth: 0 };

    /// The weight within an interval, as a multiple of that which couples the knots.
    pub(super) fn factor<const D: usize>(
        self,
        knots: &SolvedKnots<D>,
        index: usize,
        probe: &dyn Fn(f64) -> Option<Knot<D>>,
    ) -> f64 {
        match self {
            Self::Coupled => FACTORS[0],
            Self::Searched { min_depth } => Interval::new(knots, index, min_depth, probe).continuous_factor(),
            Self::Interpolated => INTERPOLATING,
        }
    }
}

/// The motion between two knots.
struct Interval<'a, const D: usize> {
    knots: &'a SolvedKnots<D>,
    /// Number of the knot at which the interval begins.
    index: usize,
    /// Builds the unsolved problem of a time; `None` if there is no problem.
    probe: &'a dyn Fn(f64) -> Option<Knot<D>>,
    /// The problems built so far, with their fractions of the interval.
    probed: Vec<(f64, Option<Knot<D>>)>,
    /// Largest difference between a state and the mean of its neighbours in continuous motion, in units of the space.
    tolerance: f64,
    /// Depth to which the interval is bisected in any case.
    min_depth: u32,
}

/// A part of an interval under bisection.
struct Part<'a, const D: usize> {
    times: [f64; 2],
    /// States at the two times, and at the far end of the part one level up, of which the second time is the middle; at depth 0
    /// there is none.
    states: [&'a Displacement<D>; 3],
    /// Differences of the state halfway from the mean, one and two levels up; infinite where there is no such level.
    differences: [f64; 2],
    depth: u32,
}

impl<'a, const D: usize> Interval<'a, D> {
    fn new(knots: &'a SolvedKnots<D>, index: usize, min_depth: u32, probe: &'a dyn Fn(f64) -> Option<Knot<D>>) -> Self {
        let tolerance = JUMP_TOLERANCE * knots.coupling.least_speed;
        Self { knots, index, probe, probed: Vec::new(), tolerance, min_depth }
    }

    /// The smallest of the tried factors with which no jump is found. If there is none, the largest, which shortens jumps of the energy
    /// most; that of the knots, 1, if it does not, because the targets of pins jump.
    fn continuous_factor(&mut self) -> f64 {
        if let Some(factor) = FACTORS.into_iter().find(|&factor| self.is_continuous(factor)) {
            return factor;
        }
        let [initial, .., largest] = FACTORS;
        let is_shorter = self.longest_jump(largest) < SHORTER * self.longest_jump(initial);
        if is_shorter { largest } else { initial }
    }

    /// How far a point moves in the shortest part of the interval, found by halving that part in which it moves farther.
    fn longest_jump(&mut self, factor: f64) -> f64 {
        let knots = self.knots;
        let [Some(before), Some(after)] = &knots.states[self.index..=self.index + 1] else { return 0.0 };
        let (mut times, mut states) = ([0.0, 1.0], [before.clone(), after.clone()]);
        for _ in 0..JUMP_DEPTH {
            let middle = f64::midpoint(times[0], times[1]);
            let Some(state) = self.state(middle, factor) else { break };
            // The later half replaces the first end, the earlier one the last.
            let end = usize::from(states[0].farthest(&state) > state.farthest(&states[1]));
            (times[end], states[end]) = (middle, state);
        }
        states[0].farthest(&states[1])
    }

    /// Whether no jump is found between the knots with this factor.
    fn is_continuous(&mut self, factor: f64) -> bool {
        let knots = self.knots;
        let [Some(before), Some(after)] = &knots.states[self.index..=self.index + 1] else { return true };
        let whole =
            Part { times: [0.0, 1.0], states: [before, after, before], differences: [f64::INFINITY; 2], depth: 0 };
        self.is_even(&whole, factor)
    }

    /// Whether the motion in a part of the interval is even, or becomes so under bisection.
    fn is_even(&mut self, part: &Part<D>, factor: f64) -> bool {
        let Part { times: [from, to], states: [outer, inner, beyond], differences, depth } = *part;
        let middle = f64::midpoint(from, to);
        let Some(state) = self.state(middle, factor) else { return true };
        let mean = outer.interpolated(inner, 0.5);
        let difference = mean.farthest(&state);
        // 3/8 outer + 3/4 inner - 1/8 beyond.
        let parabola = || mean.interpolated(&inner.interpolated(beyond, -0.5), 0.25);
        let is_even = difference < self.tolerance || depth > 0 && parabola().farthest(&state) < self.tolerance;
        if is_even && depth >= self.min_depth {
            return true;
        }
        let is_jump = !is_even && difference > LASTING * differences[0] && differences[0] > LASTING * differences[1];
        let half = |from: f64, states| Part {
            times: [from, middle],
            states,
            differences: [difference, differences[0]],
            depth: depth + 1,
        };
        depth < MAX_DEPTH
            && !is_jump
            && self.is_even(&half(from, [outer, &state, inner]), factor)
            && self.is_even(&half(to, [inner, &state, outer]), factor)
    }

    /// The state at a fraction of the interval, computed as by [`super::Trajectory::solve_at`].
    fn state(&mut self, s: f64, factor: f64) -> Option<Displacement<D>> {
        let place = match self.probed.iter().position(|(known, _)| *known == s) {
            Some(place) => place,
            None => {
                self.probed.push((s, (self.probe)(self.knots.time(self.index, s))));
                self.probed.len() - 1
            }
        };
        let knot = self.probed[place].1.as_mut()?;
        let proximal = self.knots.proximal(self.index, s, factor)?;
        knot.solve_between(&proximal, &Cancel::never()).ok()?;
        Some(knot.displacement.clone())
    }
}
