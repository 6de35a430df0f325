//! Decides which of two limbs of a drawing lies in front where they cross.
//!
//! In: the crossings of a drawing's [`BranchedLattice`], the pins and their keys. Out: [`PartLevels`]. One decision holds for a whole
//! crossing, and for all frames in which it lasts. It compares how far the pins of either limb are pulled anywhere in the shot.

use super::crossing_times::CrossingTimes;
use super::pin_places::pin_places;
use crate::pipeline::{PreparedShot, TimeSample};
use crate::shot::{Goal, OffsetUnit, Pin, Source};
use crate::solve::{BranchedLattice, Crossing};

/// A pin is of one limb and not of the other if it is this much nearer to it along the shape.
const OF_LIMB: f64 = 0.85;

/// A pin is of one limb only if it is at most so many times as far from it as the nearest pin is: what pulls the other arm is no pin of
/// the chest.
const BESIDE_NEAREST: f64 = 2.0;

/// The levels of a layer's polygons.
#[derive(Clone, Debug, Default)]
pub(super) struct PartLevels {
    /// One per polygon, in the order of [`BranchedLattice::pieces`]; the greater one lies in front. Empty if all are 0.
    pub(super) of_polygons: Vec<u32>,
    /// Indices of pins at the limbs that cross most, of those whose orders do not decide: in front, behind.
    pub(super) pins: Option<[usize; 2]>,
}

impl PartLevels {
    /// `orders`: one per polygon; where those of two limbs differ they decide for the whole crossing.
    pub(super) fn of(
        prepared: &PreparedShot,
        layer: usize,
        (now, branches): (&TimeSample, &BranchedLattice<2>),
        orders: &[i32],
    ) -> Self {
        // In scenes depth decides.
        if matches!(prepared.shot.source, Source::Scene(_)) {
            return Self::default();
        }
        let crossings = branches.crossings(orders);
        if crossings.is_empty() {
            return Self::default();
        }
        let times = CrossingTimes { prepared, layer, now, branches, pieces: branches.digest_of_pieces() };
        let pins = pin_places(prepared, layer, (now, branches));
        let places: Vec<_> = pins.iter().map(|pin| (pin.at, pin.triangle)).collect();
        let lengths = branches.lengths_along_shape(&places);
        let reach = |pin: usize, at: [f64; 2]| reach(&prepared.shot.layers[layer].pins[pin], at, branches);
        let reaches: Vec<f64> = pins.iter().map(|pin| reach(pin.pin, pin.at)).collect();
        let front_of = |crossing: &Crossing| {
            crossing.ordered.unwrap_or_else(|| front(&times.over_time(crossing), (&lengths, &reaches)))
        };
        let fronts: Vec<(&Crossing, usize)> = crossings.iter().map(|crossing| (crossing, front_of(crossing))).collect();
        let open = fronts.iter().filter(|(crossing, _)| crossing.ordered.is_none());
        let greatest = open.max_by_key(|(crossing, _)| crossing.area());
        let named = |&(crossing, front): &(&Crossing, usize)| {
            let means = mean_lengths(crossing, &lengths);
            let nearest = |side: usize| {
                let share = |k: &usize| nearness(side, means[*k]);
                (0..pins.len()).min_by(|a, b| share(a).total_cmp(&share(b))).map(|nearest| pins[nearest].pin)
            };
            Some([nearest(front)?, nearest(1 - front)?])
        };
        Self { of_polygons: branches.levels(&fronts, orders), pins: greatest.and_then(named) }
    }
}

/// Returns the side of a crossing that lies in front: that whose own pins are pulled further, or of equal ones that of the smaller
/// branches, or on one branch that which moves further. `lengths`: distance of each pin from each piece, along the shape.
fn front(crossing: &Crossing, (lengths, reaches): (&[Vec<f64>], &[f64])) -> usize {
    let means = mean_lengths(crossing, lengths);
    let own = |side: usize| {
        let nearest = means.iter().map(|lengths| lengths[side]).fold(f64::INFINITY, f64::min);
        let is_own = |lengths: [f64; 2]| nearness(side, lengths) < OF_LIMB && lengths[side] <= BESIDE_NEAREST * nearest;
        let own = means.iter().zip(reaches).filter(|(lengths, _)| is_own(**lengths));
        own.map(|(_, reach)| *reach).fold(0.0, f64::max)
    };
    match [own(0), own(1)] {
        [one, other] if one != other => usize::from(other > one),
        _ => crossing.smaller.unwrap_or(usize::from(crossing.moved[1] > crossing.moved[0])),
    }
}

/// Returns the mean distance of each pin from either side of a crossing.
fn mean_lengths(crossing: &Crossing, lengths: &[Vec<f64>]) -> Vec<[f64; 2]> {
    lengths.iter().map(|lengths| [0, 1].map(|side| crossing.mean(side, |piece| lengths[piece]))).collect()
}

/// Returns the distance of a pin from a side of a crossing, as a fraction of that from the other side; 1 if it is connected with neither.
/// `lengths`: distance from either side.
fn nearness(side: usize, lengths: [f64; 2]) -> f64 {
    let [near, far] = [lengths[side], lengths[1 - side]];
    match (near.is_finite(), far.is_finite()) {
        (true, true) if far > 0.0 => near / far,
        (true, false) => 0.0,
        (false, true) => f64::INFINITY,
        _ => 1.0,
    }
}

/// Returns how far the keys of a pin pull it at most, in frame heights. `at`: its place at rest.
fn reach(pin: &Pin, at: [f64; 2], branches: &BranchedLattice<2>) -> f64 {
    let length = |offset: [f64; 2]| offset[0].hypot(offset[1]);
    let of_goal = |goal: Goal| match (goal, pin.unit) {
        (Goal::Offset(offset), OffsetUnit::Frame) => length(offset.0.to_array()),
        (Goal::Offset(offset), OffsetUnit::Box) => length(branches.grid().scaled_to_box(offset.0.to_array())),
        (Goal::Target(place), _) => length([place.0.x - at[0], place.0.y - at[1]]),
        // Goals of world layers.
        (Goal::SceneOffset(_) | Goal::SceneTarget(_), _) => 0.0,
    };
    pin.keys.iter().map(|key| of_goal(key.goal)).fold(0.0, f64::max)
}
