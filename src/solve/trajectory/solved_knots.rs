//! The solved knots of a trajectory, and the proximal term of a time between two of them.
//!
//! In: states of knots, weights of intervals. Out: what a time between two knots is drawn to, and how strongly.

use super::displacement::Displacement;
use super::interior::Interior;
use super::knot::{Knot, Proximal};
use super::timeline::Coupling;
use crate::solve::linalg::small_matrix::minus;
use crate::solve::point_weights::PointWeights;
use crate::solve::winding::wrapped;

/// Solved knots, and the weights of the intervals between them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SolvedKnots<const D: usize> {
    pub(crate) coupling: Coupling,
    /// State of each knot; `None` if nothing is solved there.
    pub(crate) states: Vec<Option<Displacement<D>>>,
    /// Rotation of the model at each knot, in radians; see [`Knot::model_angle`].
    pub(crate) model_angles: Vec<f64>,
    /// Drawing that each knot belongs to.
    pub(crate) drawings: Vec<i64>,
    /// Number of cuts of the camera before each knot.
    pub(crate) takes: Vec<i64>,
    /// ω of each interval, per squared unit of the space: it couples the knots at its ends, each point by its own weight.
    pub(crate) weights: Vec<PointWeights>,
}

impl<const D: usize> SolvedKnots<D> {
    /// The number of intervals from the first knot to a time, in frames.
    pub(super) fn place(&self, time: f64) -> f64 {
        (time - self.coupling.first) * f64::from(self.coupling.knots_per_frame)
    }

    /// Sets the angle of the box relative to the frame of the model, for a time that is not a knot. The model rotates evenly from knot
    /// to knot; the box may not.
    pub(super) fn orient(&self, knot: &mut Knot<D>, time: f64) {
        let Some(last) = self.model_angles.len().checked_sub(1) else { return };
        let place = self.place(time).clamp(0.0, last as f64);
        let (before, s) = (place.floor() as usize, place.fract());
        let after = (before + 1).min(last);
        let after = if self.takes[after] == self.takes[before] { after } else { before };
        let [from, to] = [before, after].map(|knot| self.model_angles[knot]);
        knot.set_box_angle(wrapped(knot.angle - (from + s * (to - from))));
    }

    /// The proximal term at the fraction `s` of an interval. With ω' = ω the state minimises
    /// ½ E(x) + ω (‖d − d_k‖²/s + ‖d − d_{k+1}‖²/(1 − s)), which is, twice and up to a constant, E(x) + 2 ω/(s (1 − s)) ‖d − (1 −
    /// s) d_k − s d_{k+1}‖². Half of the energy of a time counts for each side, as in the trapezoidal rule, so that the motion has
    /// no kinks at knots. With a larger ω' the velocities at the knots stay the same, because the straight line between the knots
    /// becomes a cubic: docs/METHOD.md, "Time". Returns `None` if a knot has no state.
    pub(super) fn proximal(&self, interval: usize, s: f64, interior: Interior) -> Option<Proximal<D>> {
        let [Some(from), Some(to)] = &self.states[interval..=interval + 1] else { return None };
        let mut displacement = from.interpolated(to, s);
        // The model stands still between two knots of a hold, whatever comes before and after.
        let is_held = from.points == to.points;
        let factor = interior.factor();
        let cubic = if is_held { 0.0 } else { 1.0 - 1.0 / factor };
        if cubic > 0.0 {
            let [before, after] = [interval.checked_sub(1), Some(interval + 1)].map(|index| self.tie(index));
            for (index, point) in displacement.points.iter_mut().enumerate() {
                let step = |a: &Displacement<D>, b: &Displacement<D>| minus(&b.points[index], &a.points[index]);
                let chord = step(from, to);
                // Velocities at the knots, from the line between them.
                let [start, end] = [before, after].map(|beside| {
                    let beside = beside.map_or([0.0; D], |(weights, [a, b])| {
                        let ratio = weights.of(index) / self.weights[interval].of(index);
                        step(a, b).map(|by| ratio * by)
                    });
                    std::array::from_fn::<f64, D, _>(|d| f64::midpoint(chord[d], beside[d]) - chord[d])
                });
                let by = |d: usize| cubic * s * (1.0 - s) * ((1.0 - s) * start[d] - s * end[d]);
                *point = std::array::from_fn(|d| point[d] + by(d));
            }
        }
        let weights = self.weights[interval].map(|weight| 2.0 * (factor * weight) / (s * (1.0 - s)));
        Some(Proximal { displacement, weights })
    }

    /// The weights and knots of an interval beside another one; `None` if they are not of the same drawing.
    fn tie(&self, interval: Option<usize>) -> Option<(&PointWeights, [&Displacement<D>; 2])> {
        let index = interval.filter(|&index| index < self.weights.len())?;
        let [Some(from), Some(to)] = &self.states[index..=index + 1] else { return None };
        let is_one = |of: &[i64]| of[index] == of[index + 1];
        (is_one(&self.drawings) && is_one(&self.takes)).then(|| (&self.weights[index], [from, to]))
    }
}
