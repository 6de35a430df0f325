//! Trajectories: the lattice of a layer as a continuous function of time.
//!
//! In: a [`Timeline`] and a [`Coupling`]. Out: a [`Trajectory`], which gives the state at any time between its knots. After A.
//! Mielke and R. Rossi, "Existence and uniqueness results for a class of rate-independent hysteresis problems", 2007 (vanishing
//! viscosity). docs/METHOD.md, "Time", defines trajectories and says what is guaranteed.

mod bits;
mod chain;
mod displacement;
mod interior;
mod knot;
mod solved_knots;
mod speed_limits;
mod timeline;

pub(crate) use timeline::knots_per_gib;
pub(crate) use timeline::{Coupling, TimedProblem, Timeline};

use super::box_rotation::BoxRotation;
use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::MinimizationResult;
use super::point_weights::PointWeights;
use super::report::Solution;
use super::settings::Settings;
use super::targets::Targets;
use super::upright::Upright;
use chain::{Chain, SettledInterval};
use displacement::Displacement;
use interior::Interior;
use knot::{Knot, Proximal};
use rayon::prelude::*;
use solved_knots::SolvedKnots;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Distance from a knot, as a fraction of an interval, below which the state of the knot is used as it is.
const AT_KNOT: f64 = 1e-5;

/// Smallest number of knots per window.
const MIN_WINDOW: usize = 16;

/// The solved knots of a layer's lattice over a range of time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trajectory<const D: usize> {
    knots: SolvedKnots<D>,
    /// How times within each interval are solved.
    interiors: Vec<Interior>,
    /// ω of intervals whose weight was not raised.
    weight: f64,
    /// Runs of intervals over which a fast motion is spread.
    spreads: Vec<Spread>,
}

/// A fast motion that was spread over time by raised weights.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Spread {
    /// First and last frame.
    pub frames: [f64; 2],
    /// Largest speed of a point relative to the rigid fit of the pins, in units of the space per frame.
    pub speed: f64,
}

impl<const D: usize> Trajectory<D> {
    /// Solves all knots.
    ///
    /// # Errors
    /// Errors of the timeline and of its solves, and [`SolveError::Cancelled`].
    pub(crate) fn solve<T>(timeline: &T, coupling: Coupling, cancel: &Cancel) -> Result<Self, T::Error>
    where
        T: Timeline<D> + Sync,
        T::Error: Send,
    {
        let count = if coupling.weight > 0.0 { coupling.knot_count() } else { 0 };
        let parts = AtomicUsize::new(0);
        // Every knot is built and solved.
        let part_done = || timeline.progress(1 + parts.fetch_add(1, Ordering::Relaxed), 2 * count);
        let build = |index: usize| -> Result<Option<Knot<D>>, T::Error> {
            let problem = timeline.at(coupling.knot_time(index))?;
            let knot = problem.map(|problem| Knot::new(problem, timeline.settings(), &Cancel::never())).transpose();
            part_done();
            Ok(knot?)
        };
        let build = |range: std::ops::Range<usize>| -> Result<Vec<_>, T::Error> {
            if timeline.is_light() { range.into_par_iter().map(build).collect() } else { range.map(build).collect() }
        };
        let window = timeline.window().max(MIN_WINDOW);
        let mut end = window.min(count);
        let mut chain = Chain::new(build(0..end)?, &coupling, cancel);
        let mut done = Vec::new();
        loop {
            chain.solve(&part_done)?;
            if end == count {
                break;
            }
            done.extend(chain.take_front(window / 2));
            let next = (end + window / 2).min(count);
            chain.extend(build(end..next)?);
            end = next;
        }
        let weight = chain.weight;
        done.extend(chain.take_front(chain.knots.len()));
        let intervals: Vec<SettledInterval> = done.iter_mut().filter_map(|knot| knot.interval.take()).collect();
        let weights = intervals.iter().map(|interval| interval.weights.clone()).collect();
        let model_angles = done.iter().map(|knot| knot.model_angle).collect();
        let takes = done.iter().map(|knot| knot.take).collect();
        let (drawings, states) = done.into_iter().map(|knot| (knot.drawing, knot.state)).unzip();
        let knots = SolvedKnots { coupling, states, model_angles, drawings, takes, weights };
        let interiors = intervals.iter().map(|interval| interval.interior).collect();
        Ok(Self { spreads: find_spreads(&knots, &intervals), knots, interiors, weight })
    }

    /// Number of knots with a state.
    #[must_use]
    pub(crate) fn knot_count(&self) -> usize {
        self.knots.states.iter().flatten().count()
    }

    /// The motions that were spread over time.
    #[must_use]
    pub(crate) fn spreads(&self) -> &[Spread] {
        &self.spreads
    }

    /// Solves the problem of a time. The result depends on the time and the trajectory alone, to the bit.
    ///
    /// # Errors
    /// [`SolveError`] if the problem is malformed or the solve is cancelled.
    pub(crate) fn solve_at(
        &self,
        time: f64,
        problem: TimedProblem<D>,
        settings: &Settings,
        cancel: &Cancel,
    ) -> Result<Solution<D>, SolveError> {
        let grid = problem.grid.clone();
        let shape = Upright::of(&grid).shape(&problem.shape).into_owned();
        let mut knot = Knot::new(problem, settings, cancel)?;
        knot.system.mark_active_cells(&shape);
        self.knots.orient(&mut knot, time);
        let result = self.solve_knot(&mut knot, time, cancel)?;
        let goal = knot.goal().cloned().unwrap_or(Targets { pins: Vec::new(), handles: Vec::new() });
        let box_rotation = BoxRotation::new(&grid, knot.system.branching());
        Ok(box_rotation.solution(knot.system.finish(&goal, result)))
    }

    /// The state of a knot if there is one at this time, else the proximal step between the neighbouring knots. Outside the range of the
    /// trajectory, pins and handles at rest mean rest.
    fn solve_knot(&self, knot: &mut Knot<D>, time: f64, cancel: &Cancel) -> Result<MinimizationResult<D>, SolveError> {
        let place = self.knots.place(time);
        let last = self.knots.states.len() as f64 - 1.0;
        if knot.is_resting && (place < -AT_KNOT || place > last + AT_KNOT) {
            return Ok(knot.at_rest());
        }
        match self.neighbourhood(time, (knot.drawing, knot.take)) {
            Neighbourhood::Alone => knot.solve_alone(cancel),
            Neighbourhood::Knot(state) => Ok(knot.at(state)),
            Neighbourhood::Proximal(proximal) => knot.solve_between(&proximal, cancel),
        }
    }

    /// The knots that determine the state at a time. Before the first knot, after the last, beside a gap or a cut, and where only one
    /// neighbour has the same drawing, the proximal term has a single knot and a weight inversely proportional to the distance
    /// from it: that of the interval on its other side, so that the motion goes on at about the same speed.
    fn neighbourhood(&self, time: f64, (drawing, take): (i64, i64)) -> Neighbourhood<'_, D> {
        let SolvedKnots { states, drawings, takes, .. } = &self.knots;
        let place = self.knots.place(time);
        let last = states.len() as f64 - 1.0;
        let any_state = |knot: f64| {
            let index = Some(knot as usize).filter(|&index| knot >= 0.0 && takes.get(index) == Some(&take))?;
            states[index].as_ref()
        };
        let state = |knot: f64| any_state(knot).filter(|_| drawings[knot as usize] == drawing);
        if let Some(state) = state(place.round()).filter(|_| (place - place.round()).abs() < AT_KNOT) {
            return Neighbourhood::Knot(state);
        }
        let before = place.floor().min(last);
        let after = place.ceil().max(0.0);
        let pair = match (state(before), state(after)) {
            (None, None) => (any_state(before), any_state(after)),
            own => own,
        };
        // Raised weights hold the outermost knots away from their minima, which lie far from them.
        let single = |state: &Displacement<D>, distance: f64, beside: Option<usize>| {
            let weights = beside.and_then(|interval| self.knots.weights.get(interval)).unwrap_or(&PointWeights::ZERO);
            let weights = weights.map(|weight| weight.max(self.weight) / distance);
            Neighbourhood::Proximal(Proximal { displacement: state.clone(), weights })
        };
        match pair {
            // What stands still does so to the bit.
            (Some(from), Some(to)) if self.interiors[before as usize] == Interior::Interpolated && from == to => {
                Neighbourhood::Knot(from)
            }
            (Some(_), Some(_)) => {
                let interval = before as usize;
                let proximal = self.knots.proximal(interval, place - before, self.interiors[interval]);
                proximal.map_or(Neighbourhood::Alone, Neighbourhood::Proximal)
            }
            (Some(only), None) => single(only, place - before, (before as usize).checked_sub(1)),
            (None, Some(only)) => single(only, after - place, Some(after as usize)),
            (None, None) => Neighbourhood::Alone,
        }
    }
}

/// Runs of intervals over which a fast motion is spread.
fn find_spreads<const D: usize>(knots: &SolvedKnots<D>, intervals: &[SettledInterval]) -> Vec<Spread> {
    let SolvedKnots { coupling, states, .. } = knots;
    let mut spreads: Vec<Spread> = Vec::new();
    for index in (0..intervals.len()).filter(|&index| intervals[index].is_spread) {
        let [Some(state), Some(next)] = &states[index..=index + 1] else { continue };
        let speed = state.farthest(next) * f64::from(coupling.knots_per_frame);
        let frames = [index, index + 1].map(|knot| coupling.knot_time(knot));
        match spreads.last_mut() {
            Some(last) if last.frames[1] == frames[0] => {
                *last = Spread { frames: [last.frames[0], frames[1]], speed: last.speed.max(speed) };
            }
            _ => spreads.push(Spread { frames, speed }),
        }
    }
    spreads
}

/// The knots that determine the state at a time.
enum Neighbourhood<'a, const D: usize> {
    /// There is none: the time is solved alone.
    Alone,
    /// The time is that of a knot with this state.
    Knot(&'a Displacement<D>),
    /// The time is solved with this proximal term.
    Proximal(Proximal<D>),
}
