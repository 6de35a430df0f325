//! How far the points of a model may move between two knots.
//!
//! In: the problems of two knots. Out: a limit for each point, of its move relative to the rigid fit of the pins.

use super::knot::{Knot, have_branches};
use crate::solve::linalg::small_matrix::{distance, minus};
use crate::solve::problem::{HandlePin, PointPin};
use crate::solve::targets::Targets;

/// Permitted motion of a point between two knots, as a multiple of what gives it reason to move: pins, its surface and the rigid fit.
const MOTION_FACTOR: f64 = 2.0;

/// Same as [`MOTION_FACTOR`] for branching lattices, which are watched at the tips of limbs: they move farther than the middle.
const TIP_MOTION_FACTOR: f64 = 3.0;

/// Motion that is permitted to every point, as a multiple of the greatest motion of pins, surface and rigid fit anywhere: parts that
/// move past others draw them along.
const SHARED_FACTOR: f64 = 1.0;

/// Farthest that each point may move from one knot to the next, in units of the space; `least` is permitted to all.
pub(super) fn speed_limits<const D: usize>(knot: &Knot<D>, next: &Knot<D>, least: f64) -> Vec<f64> {
    let factor = if have_branches([knot, next]) { TIP_MOTION_FACTOR } else { MOTION_FACTOR };
    let moves = |from: &[[f64; D]], to: &[[f64; D]]| -> Vec<f64> {
        from.iter().zip(to).map(|(from, to)| move_in_model([knot, next], [from, to])).collect()
    };
    let surface = moves(&knot.points, &next.points);
    let rigid = moves(&knot.rigid.points, &next.rigid.points);
    let pins = PinMotion::between(knot, next);
    let greatest = surface.iter().chain(&rigid).copied().fold(pins.in_model, f64::max);
    let limit = |(surface, rigid): (&f64, &f64)| {
        let own = pins.on_surface.max(*surface).max(*rigid).min(greatest);
        (factor * own).max(SHARED_FACTOR * greatest) + least
    };
    surface.iter().zip(&rigid).map(limit).collect()
}

/// Distance between places over the upright boxes of two knots, in the frame of the model.
fn move_in_model<const D: usize>(knots: [&Knot<D>; 2], places: [&[f64; D]; 2]) -> f64 {
    let [from, to] = [0, 1].map(|end| knots[end].in_model.point_from_upright(*places[end]));
    distance(&from, &to)
}

/// Greatest moves of the targets of pins and handles. A prescribed gradient moves what lies within a span of its pin, or within
/// its region.
#[derive(Default)]
struct PinMotion {
    /// In the frame of the model.
    in_model: f64,
    /// Relative to the places of pins and handles at rest.
    on_surface: f64,
}

impl PinMotion {
    fn between<const D: usize>(knot: &Knot<D>, next: &Knot<D>) -> Self {
        let (Some(from), Some(to)) = (knot.goal(), next.goal()) else { return Self::default() };
        if from.pins.len() != to.pins.len() || from.handles.len() != to.handles.len() {
            return Self::default();
        }
        let [starts, ends] = [(knot, from), (next, to)].map(|(knot, goal)| rests_and_targets(knot, goal));
        let span = (0..D).map(|axis| knot.grid().spacing(axis)).fold(0.0, f64::max);
        let spins = from.pins.iter().zip(&to.pins).filter_map(|(from, to)| spin(from, to, span));
        let mut motion = spins.fold(0.0, f64::max);
        let mut on_surface = motion;
        for ([rest, target], [next_rest, next_target]) in starts.iter().zip(&ends) {
            motion = motion.max(move_in_model([knot, next], [target, next_target]));
            let offset = knot.in_model.rotated(minus(target, rest));
            let next_offset = next.in_model.rotated(minus(next_target, next_rest));
            on_surface = on_surface.max(distance(&offset, &next_offset));
        }
        Self { in_model: motion, on_surface }
    }
}

/// Places at rest and targets of all pins and moved handles.
fn rests_and_targets<const D: usize>(knot: &Knot<D>, goal: &Targets<D>) -> Vec<[[f64; D]; 2]> {
    let pins = goal.pins.iter().map(|pin: &PointPin<D>| [pin.at, pin.target]);
    let handles =
        goal.handles.iter().map(|handle: &HandlePin<D>| [knot.grid().rest_handle(handle.index), handle.target]);
    pins.chain(handles).collect()
}

/// How far the change of a pin's prescribed gradient moves what is around it.
fn spin<const D: usize>(from: &PointPin<D>, to: &PointPin<D>, span: f64) -> Option<f64> {
    let radius = to.region.map_or(span, |region| region.radius.max(span));
    let (from, to) = (from.gradient?, to.gradient?);
    let change = from.as_flattened().iter().zip(to.as_flattened()).map(|(from, to)| (to - from).powi(2));
    Some(change.sum::<f64>().sqrt() * radius)
}
