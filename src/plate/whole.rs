//! The warp of a whole picture with a fixed border: the smooth part of a lattice, followed by a flow that moves the
//! pins to their targets.
//!
//! In: a lattice solved with compliant pins, the pins. Out: the parts of a [`Field`](super::Field):
//! x ↦ flow(x + α w(x) L(x)), where L is the displacement of the lattice, w is 0 at the border and α 0 to 1
//! (docs/METHOD.md, "Whole pictures").

use super::extrapolation::ExtrapolatedLattice;
use super::flow::{Flow, FlowPin};
use super::ramp::Ramp;
use crate::lattice::ScreenLattice;
use crate::space::{ScreenBox, ScreenPoint};
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::sync::Arc;

/// Least and greatest width of the ramp, as fractions of the frame's shorter side.
const RAMP: [f64; 2] = [0.02, 0.2];
/// Greatest compression by the lattice at any sample point.
const MAX_COMPRESSION: f64 = 0.75;
/// Upper bound of the displacement relative to that of the furthest pin; for a single pin, for several.
const MAX_DISPLACEMENT_RATIO: [f64; 2] = [1.04, 1.4];
/// How much steeper the remainder for the flow may be than the whole, as a factor and as an absolute margin.
const STEEPNESS_LIMIT: [f64; 2] = [1.2, 0.1];
/// Sample points per span of the lattice.
const SAMPLES_PER_SPAN: usize = 6;
/// Least and greatest number of sample points per axis.
const SAMPLES_PER_AXIS: [usize; 2] = [48, 160];
/// The border gives way if a pin comes closer to it than this fraction of its path towards the border and along it.
const NEAR: f64 = 0.1;
/// The border gives way to a pin that leaves it inwards from a rest point closer than this, in frame heights: a pixel at HD.
const EDGE: f64 = 1e-3;
/// The disc of such a pin reaches beyond the border by this multiple of the missing distance.
const SLACK_PER_DISTANCE: f64 = 3.0;
/// Reach of rotated and scaled pins, in frame heights.
const LEVER: f64 = 0.15;
/// Sample points of the border per axis.
const BORDER_SAMPLES: usize = 2048;

/// A pin of a whole picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WholePin {
    /// Position before the warp.
    pub(crate) rest: ScreenPoint,
    /// Target position.
    pub(crate) target: ScreenPoint,
    /// Fraction of the path that the pin moves, 0 to 1.
    pub(crate) weight: f64,
    /// Prescribed rotation, in radians.
    pub(crate) rotation: Option<f64>,
    /// Logarithm of the prescribed scale.
    pub(crate) log_scale: Option<f64>,
}

/// The warp of a whole picture. Its border is fixed except where pins are dragged past it.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeWarp {
    /// The lattice, already scaled by the fraction that is used; its displacement is multiplied by a ramp that is 0 at the border.
    pub lattice: ScreenLattice,
    ramp: Ramp,
    flow: Arc<Flow>,
    /// Pins at which the border gives way: index, and displacement of the border in frame heights.
    pub given_way: Vec<(usize, f64)>,
    /// Final position of every pin.
    pub ends: Vec<ScreenPoint>,
}

impl WholeWarp {
    /// Uses the lattice as far as it keeps the picture one-to-one, and moves the pins the rest of the way by a flow.
    #[must_use]
    pub(crate) fn fit(lattice: &ScreenLattice, pins: &[WholePin]) -> Self {
        let grid = &lattice.grid;
        let bounds = ScreenBox::new(ScreenPoint(grid.lo.into()), ScreenPoint(grid.hi.into()));
        let ramp = Ramp::new(bounds, widths(bounds, pins));
        let full = ExtrapolatedLattice::resting(lattice, ramp);
        let fraction = lattice_fraction(&full, &ramp, (lattice, bounds), pins);
        let lattice = lattice.with_strength(fraction);
        let resting = ExtrapolatedLattice::resting(&lattice, ramp);
        let flow_pins: Vec<FlowPin> = pins.iter().map(|pin| pin.flow_pin(&resting, bounds)).collect();
        let flow = Flow::of(&flow_pins, bounds);
        let ends = flow.ends().iter().map(|&end| ScreenPoint(end)).collect();
        let given_way = given_way(&flow, &flow_pins, bounds);
        Self { lattice, ramp, flow: Arc::new(flow), given_way, ends }
    }

    /// Returns the lattice part of the warp.
    pub(super) fn extrapolated(&self) -> ExtrapolatedLattice {
        ExtrapolatedLattice::resting(&self.lattice, self.ramp)
    }

    /// Returns the flow part of the warp.
    pub(super) fn flow(&self) -> &Arc<Flow> {
        &self.flow
    }
}

impl WholePin {
    /// Returns the motion that remains for the flow after the lattice.
    fn flow_pin(&self, resting: &ExtrapolatedLattice, bounds: ScreenBox) -> FlowPin {
        let (moved, slope) = resting.displace(self.rest.0);
        let from = self.rest.0 + moved;
        let gradient = DMat2::IDENTITY + slope;
        // The lattice never rotates by 90 degrees or more: its bound on compression excludes that.
        let turned = (gradient.x_axis.y - gradient.y_axis.x).atan2(gradient.x_axis.x + gradient.y_axis.y);
        let swollen = 0.5 * gradient.determinant().ln();
        let turn = [
            self.rotation.map_or(0.0, |angle| (angle - turned) * self.weight),
            self.log_scale.map_or(0.0, |scale| (scale - swollen) * self.weight),
        ];
        FlowPin {
            from,
            to: from.lerp(self.target.0, self.weight),
            weight: self.weight,
            border_slack: self.border_slack(bounds),
            turn,
        }
    }

    fn path(&self) -> DVec2 {
        (self.target.0 - self.rest.0) * self.weight
    }

    /// Returns how far the border gives way to the pin. A pin that moves away from a side of the frame stretches what
    /// lies between; a border that followed it would leave a hole.
    fn border_slack(&self, bounds: ScreenBox) -> f64 {
        let (rest, path) = (self.rest.0, self.path());
        let length = path.length();
        let missing = |axis: usize, outwards: f64, side: f64| {
            let room = (outwards * (side - rest[axis])).min(outwards * (side - rest[axis] - path[axis]));
            let inwards = -outwards * path[axis];
            let stays_near = if inwards > 0.0 { (path[1 - axis].abs() - inwards).max(0.0) } else { length };
            (NEAR * length).min(EDGE).max(NEAR * stays_near) - room
        };
        let sides =
            [0, 1].map(|axis| missing(axis, -1.0, bounds.min.0[axis]).max(missing(axis, 1.0, bounds.max.0[axis])));
        SLACK_PER_DISTANCE * sides[0].max(sides[1]).clamp(0.0, 1.0 / SLACK_PER_DISTANCE)
    }

    /// Returns how far a rotation and a scale move the surroundings of the pin.
    fn lever(&self) -> f64 {
        let most = |part: Option<f64>| part.map_or(0.0, |part| part.abs().min(1.0));
        LEVER * (most(self.rotation) + most(self.log_scale)) * self.weight
    }
}

/// Returns the widths of the ramp: the distance of the nearest pin from each side, so that the lattice acts on all pins.
fn widths(bounds: ScreenBox, pins: &[WholePin]) -> [[f64; 2]; 2] {
    let side = bounds.size().min_element();
    let [least, most] = RAMP.map(|part| part * side);
    let nearest = |distance: &dyn Fn(DVec2) -> f64| {
        let near = pins.iter().map(|pin| distance(pin.rest.0).max(0.0) / pin.weight.max(1e-3));
        near.fold(most, f64::min).max(least)
    };
    [0, 1].map(|axis| [nearest(&|at| at[axis] - bounds.min.0[axis]), nearest(&|at| bounds.max.0[axis] - at[axis])])
}

/// Returns the fraction of the lattice that is used: 1, unless the lattice compresses the picture too much, moves any
/// point further than the pins move, or leaves the flow more than it removes. All three are convex in the fraction, so
/// it varies continuously with the pins.
fn lattice_fraction(
    full: &ExtrapolatedLattice,
    ramp: &Ramp,
    (lattice, bounds): (&ScreenLattice, ScreenBox),
    pins: &[WholePin],
) -> f64 {
    let longest = pins.iter().map(|pin| pin.path().length() + pin.lever()).fold(0.0, f64::max);
    if longest == 0.0 {
        return 0.0;
    }
    let [displacement, compression] = max_displacement_and_compression(full, ramp, lattice);
    let carried: Vec<DVec2> = pins.iter().map(|pin| full.displace(pin.rest.0).0 * pin.weight).collect();
    let still: Vec<FlowPin> = pins
        .iter()
        .map(|pin| FlowPin {
            from: pin.rest.0,
            to: pin.rest.0,
            weight: pin.weight,
            border_slack: pin.border_slack(bounds),
            turn: [0.0; 2],
        })
        .collect();
    let radii = Flow::first_radii(&still, bounds);
    let left = |part: f64| pins.iter().zip(&carried).map(move |(pin, by)| (pin.path() - *by * part).length());
    let steepness = |part: f64| {
        let steep = left(part).zip(&radii).filter(|(_, radius)| **radius > 0.0).map(|(left, radius)| left / radius);
        steep.fold(0.0, f64::max)
    };
    let moving = pins.iter().filter(|pin| pin.path() != DVec2::ZERO).count();
    let most = MAX_DISPLACEMENT_RATIO[usize::from(pins.len() > 1 && moving > 0)] * longest;
    let steepest = STEEPNESS_LIMIT[0] * steepness(0.0) + STEEPNESS_LIMIT[1];
    let is_good = |part: f64| {
        part * displacement + left(part).fold(0.0, f64::max) <= most
            && steepness(part) <= steepest
            && part * compression <= MAX_COMPRESSION
    };
    if is_good(1.0) {
        return 1.0;
    }
    let (mut lo, mut hi) = (0.0, 1.0);
    for _ in 0..52 {
        let middle = 0.5 * (lo + hi);
        if is_good(middle) { lo = middle } else { hi = middle }
    }
    lo
}

/// Returns the greatest displacement by the lattice part, and its greatest compression: the greatest −λ of the
/// symmetric part of its gradient. Below 1 the map is one-to-one on the frame, which is convex.
fn max_displacement_and_compression(full: &ExtrapolatedLattice, ramp: &Ramp, lattice: &ScreenLattice) -> [f64; 2] {
    let grid = &lattice.grid;
    let places = |axis: usize| {
        let [least, most] = SAMPLES_PER_AXIS;
        let count = (SAMPLES_PER_SPAN * grid.basis.spans(grid.dims[axis])).clamp(least, most);
        let even = (0..=count).map(|k| grid.lo[axis] + grid.size(axis) * k as f64 / count as f64);
        let mut places: Vec<f64> = even.chain(ramp.places(axis)).collect();
        places.sort_by(f64::total_cmp);
        places
    };
    let (columns, rows) = (places(0), places(1));
    let of_row = |&y: &f64| {
        let along = columns.iter().map(|&x| {
            let (moved, slope) = full.displace(DVec2::new(x, y));
            let (a, d) = (slope.x_axis.x, slope.y_axis.y);
            let b = 0.5 * (slope.x_axis.y + slope.y_axis.x);
            [moved.length(), (0.25 * (a - d).powi(2) + b * b).sqrt() - 0.5 * (a + d)]
        });
        along.fold([0.0, 0.0], greater)
    };
    rows.par_iter().map(of_row).reduce(|| [0.0, 0.0], greater)
}

fn greater(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}

/// Returns the pins at which the flow moves the border, and how far.
fn given_way(flow: &Flow, flow_pins: &[FlowPin], bounds: ScreenBox) -> Vec<(usize, f64)> {
    let mut found: Vec<(usize, f64)> = Vec::new();
    let free = || {
        flow_pins.iter().enumerate().filter(|(_, flow_pin)| flow_pin.border_slack > 0.0 && flow_pin.from != flow_pin.to)
    };
    if free().next().is_none() {
        return found;
    }
    let (lo, hi) = (bounds.min.0, bounds.max.0);
    let border = (0..=BORDER_SAMPLES).flat_map(|k| {
        let place = lo.lerp(hi, k as f64 / BORDER_SAMPLES as f64);
        [DVec2::new(place.x, lo.y), DVec2::new(place.x, hi.y), DVec2::new(lo.x, place.y), DVec2::new(hi.x, place.y)]
    });
    for point in border {
        let moved = flow.displace(point).0.length();
        let off = |flow_pin: &FlowPin| flow_pin.from.distance_squared(point).min(flow_pin.to.distance_squared(point));
        let nearest = free().min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b)));
        let Some((pin, _)) = nearest.filter(|_| moved > 0.0) else { continue };
        match found.iter_mut().find(|(other, _)| *other == pin) {
            Some((_, most)) => *most = most.max(moved),
            None => found.push((pin, moved)),
        }
    }
    found.sort_by_key(|(pin, _)| *pin);
    found
}
