//! Pins that give way: pairs less than a span of the lattice apart whose targets demand more than the lattice can do between them.
//!
//! In: pins with their targets, settings. Out: pairs with their compliances, which are 0 up to the limit, where pins are exact,
//! and a smooth function of positions, targets and weights above it (docs/METHOD.md, "Pins that give way").

use super::linalg::small_matrix::{apply, distance, minus};
use super::pins::{held_point, held_target};
use super::rigid_motion::RigidMotion;
use super::settings::{PinHold, Settings};
use super::targets::Targets;
use crate::lattice::Grid;
use crate::smoothstep::smoothstep;

/// Added to distances, in spans, so that pins at the same point have a finite compliance.
const MIN_DISTANCE: f64 = 1e-4;

/// Distance in spans below which pins may demand less stretch and less rotation, because the lattice has to rotate and stretch a
/// whole span with them.
const NEAR: f64 = 0.44;

/// Compliance of a span that two pins stretch, in units of the squared distance of the pins times the number of cells over the
/// stiffness of the shape. Measured values are between 0.2 and 0.8, depending on how full the cells are.
const SPAN_COMPLIANCE: f64 = 0.25;

/// Up to about this multiple of the limit pairs yield with a constant force, and beyond it with a decreasing one.
const CONSTANT_FORCE_LIMIT: f64 = 10.0;

/// Upper limit of the compliance, in units of that of a pin that holds exactly.
const SOFTEST: f64 = 1e6;

/// Two pins whose difference yields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct YieldingPair {
    /// Indices of the pins.
    pub(crate) pins: [usize; 2],
    /// Compliance k times the stiffness of a pin that holds exactly; above 0.
    pub(crate) compliance: f64,
}

/// Returns the pairs of pins that yield. `firmness` is the stiffness of a pin that holds exactly over that of the shape, in units
/// of one over squared length.
pub(crate) fn yielding_pairs<const D: usize>(
    grid: &Grid<D>,
    targets: &Targets<D>,
    settings: &Settings,
    firmness: f64,
) -> Vec<YieldingPair> {
    let pins = &targets.pins;
    if settings.pin_hold == PinHold::Soft || pins.len() < 2 {
        return Vec::new();
    }
    let rigid = RigidMotion::fit_continuous(grid, targets);
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

/// Demand of a pair: the vector from one pin to the other at rest, between their targets, and at rest but rotated by the rigid
/// fit of all pins.
struct Demand<const D: usize> {
    rest: [f64; D],
    now: [f64; D],
    turned: [f64; D],
}

impl<const D: usize> Demand<D> {
    /// Compliance of the pair; 0 where the pins are a span or more apart, or demand no more than they may.
    fn compliance(&self, grid: &Grid<D>, max_stretch: f64, firmness: f64) -> f64 {
        let square: f64 = (0..D).map(|d| (self.rest[d] / grid.spacing(d)).powi(2)).sum();
        if square >= 1.0 {
            return 0.0;
        }
        let spans = square.sqrt() + MIN_DISTANCE;
        let origin = [0.0; D];
        let [rest, now] = [&self.rest, &self.now].map(|between| distance(between, &origin));
        // Mean span along the direction of the pair.
        let span = if square > 0.0 { rest / square.sqrt() } else { grid.spacing(0) };
        let least = span * MIN_DISTANCE;
        let length = rest + least;
        let times = (now + least) / length;
        // Compressing a pair counts as much as stretching it.
        let stretch = (times - 1.0).max(1.0 / times - 1.0);
        let change = distance(&self.now, &self.turned) / length;
        let freedom = smoothstep(spans / NEAR);
        // Far pairs may rotate freely, near ones only with the other pins.
        let turning = (change * change - (times - 1.0).powi(2)).max(0.0);
        let asked = (stretch * stretch + (1.0 - freedom) * turning).sqrt();
        let excess = asked / ((max_stretch - 1.0) * freedom) - 1.0;
        if excess <= 0.0 {
            return 0.0;
        }
        let fade = (1.0 - square).powi(3);
        // Compliance of the span that the pair would have to stretch.
        let lattice = SPAN_COMPLIANCE * firmness * grid.cell_count() as f64 * length * length;
        let compliance = lattice * fade * excess * excess / (1.0 + excess) * (1.0 + excess / CONSTANT_FORCE_LIMIT);
        compliance / (1.0 + compliance / SOFTEST)
    }
}
