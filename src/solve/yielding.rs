//! Pins that give way: pairs less than a span of the lattice apart that ask for more than it can do between them.
//!
//! In: pins with their targets, settings. Out: pairs with their compliances: 0 below the limit, where pins are exact, and a
//! smooth function of places, targets and weights above it (docs/METHOD.md, "Pins that give way").

use super::linalg::small_matrix::{apply, distance, minus};
use super::pins::{RigidMotion, held_point, held_target};
use super::problem::{HandlePin, PointPin};
use super::settings::{PinHold, Settings};
use crate::lattice::Grid;

/// Distances are longer by this part of a span: pins on one point have a finite compliance.
const LEAST_DISTANCE: f64 = 1e-4;

/// Pins nearer than this many spans may ask for less stretch, and to turn less: the lattice has to turn and stretch a whole span.
const NEAR: f64 = 0.44;

/// Compliance of a span that two pins stretch, in units of the squared distance of the pins times the cells over the stiffness of the
/// whole shape: between 0.2 and 0.8 where cells are full and where they are not.
const SPAN_COMPLIANCE: f64 = 0.25;

/// Pairs give way at a constant force up to about this many times the limit, and at less and less beyond.
const OUTRAGEOUS: f64 = 10.0;

/// The greatest compliance, in units of that of a pin that holds.
const SOFTEST: f64 = 1e6;

/// Two pins whose difference yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct YieldingPair {
    /// Indices of the pins.
    pub(crate) pins: [usize; 2],
    /// k times the stiffness of a pin that holds, above 0.
    pub(crate) compliance: f64,
}

/// The pairs of pins that yield. `firmness`: stiffness of a pin that holds over that of the whole shape, one over squared length.
pub(crate) fn yielding_pairs<const D: usize>(
    grid: &Grid<D>,
    (pins, handles): (&[PointPin<D>], &[HandlePin<D>]),
    settings: &Settings,
    firmness: f64,
) -> Vec<YieldingPair> {
    if settings.pin_hold == PinHold::Soft || pins.len() < 2 {
        return Vec::new();
    }
    let rigid = RigidMotion::fit(grid, pins, handles).continuous();
    let places: Vec<[f64; D]> = pins.iter().map(|pin| held_point(grid, pin, settings)).collect();
    let mut order: Vec<usize> = (0..pins.len()).filter(|&pin| pins[pin].weight > 0.0).collect();
    order.sort_by(|&a, &b| places[a][0].total_cmp(&places[b][0]));
    let mut pairs = Vec::new();
    for (position, &first) in order.iter().enumerate() {
        let within = |later: &&usize| places[**later][0] - places[first][0] < grid.spacing(0);
        for &later in order[position + 1..].iter().take_while(within) {
            let between = |of: &dyn Fn(usize) -> [f64; D]| minus(&of(later), &of(first));
            let rest = between(&|pin| places[pin]);
            let now = between(&|pin| held_target(grid, &pins[pin], settings));
            let demand = Demand { rest, now, turned: apply(&rigid.rotation(), &rest) };
            let weight = pins[first].weight.min(1.0) * pins[later].weight.min(1.0);
            let compliance = weight * demand.compliance(grid, settings.max_stretch, firmness);
            if compliance > 0.0 {
                pairs.push(YieldingPair { pins: [first.min(later), first.max(later)], compliance });
            }
        }
    }
    pairs
}

/// What a pair of pins asks for: from one pin to the other, at rest and by their targets, and as the rigid fit of all pins takes it.
struct Demand<const D: usize> {
    rest: [f64; D],
    now: [f64; D],
    turned: [f64; D],
}

impl<const D: usize> Demand<D> {
    /// The compliance that the pair gets: 0 where it is a span apart and where it asks for no more than it may.
    fn compliance(&self, grid: &Grid<D>, max_stretch: f64, firmness: f64) -> f64 {
        let square: f64 = (0..D).map(|d| (self.rest[d] / grid.spacing(d)).powi(2)).sum();
        if square >= 1.0 {
            return 0.0;
        }
        let spans = square.sqrt() + LEAST_DISTANCE;
        let origin = [0.0; D];
        let [rest, now] = [&self.rest, &self.now].map(|between| distance(between, &origin));
        // The mean span along the pair.
        let span = if square > 0.0 { rest / square.sqrt() } else { grid.spacing(0) };
        let least = span * LEAST_DISTANCE;
        let length = rest + least;
        let times = (now + least) / length;
        // To press pins together is as much as to draw them apart.
        let stretch = (times - 1.0).max(1.0 / times - 1.0);
        let change = distance(&self.now, &self.turned) / length;
        let t = (spans / NEAR).min(1.0);
        let freedom = t * t * (3.0 - 2.0 * t);
        // Far pairs may turn freely, near ones with the rest of the pins.
        let turning = (change * change - (times - 1.0).powi(2)).max(0.0);
        let asked = (stretch * stretch + (1.0 - freedom) * turning).sqrt();
        let excess = asked / ((max_stretch - 1.0) * freedom) - 1.0;
        if excess <= 0.0 {
            return 0.0;
        }
        let fade = (1.0 - square).powi(3);
        // The compliance of the span that the pair would have to stretch.
        let lattice = SPAN_COMPLIANCE * firmness * grid.cell_count() as f64 * length * length;
        let compliance = lattice * fade * excess * excess / (1.0 + excess) * (1.0 + excess / OUTRAGEOUS);
        compliance / (1.0 + compliance / SOFTEST)
    }
}
