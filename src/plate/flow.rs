//! Moves points to their targets by a sequence of small one-to-one pushes.
//!
//! In: pins with targets, and the box whose border is fixed. Out: a map of the plane and its inverse, both exact
//! (docs/METHOD.md, "Whole pictures"). The discs of one step do not overlap, so the composition of all pushes is one-to-one
//! for any pins.

use super::swirl::Swirl;
use crate::space::ScreenBox;
use glam::{DMat2, DVec2};

/// 6/√5 (4/5)²: the steepest slope of φ(u²), at u = 1/√5.
const SLOPE: f64 = 1.717_301_664;
/// Fraction of the fold-free limit that a push may use.
const STEEP: f64 = 0.4;
/// Fraction of the available space that discs fill.
const FILL: f64 = 0.95;
/// Largest radius, in frame heights.
const LARGEST: f64 = 0.35;
/// A pin whose disc is smaller than this fraction of its path moves more slowly than the others.
const SLOW: f64 = 0.05;
/// Radius at which a pin stops in front of another that blocks it, in frame heights: a fifth of a pixel at HD.
const FLOOR: f64 = 2e-4;
/// Fraction of the longest path that is added to every pin's share of the space, so that no disc becomes tiny.
const EVEN: f64 = 0.05;
/// Maximum number of steps, after which a pin that is blocked by another stays where it is.
const MAX_STEPS: usize = 128;
/// Remaining fraction of a path below which a pin has arrived.
const ARRIVED: f64 = 1e-12;
/// Maximum number of Newton steps of an inverse.
const MAX_NEWTON: usize = 40;
/// A disc counts as smooth over a box of this fraction of its radius.
const PIECE: f64 = 0.25;

/// A pin of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowPin {
    /// Start position.
    pub(super) from: DVec2,
    /// Target position.
    pub(super) to: DVec2,
    /// Strength, 0 to 1, with which the pin repels the discs of others.
    pub(super) weight: f64,
    /// Distance that the disc may reach beyond the border, in frame heights.
    pub(super) border_slack: f64,
    /// Remaining rotation (radians) and logarithm of the scale, applied after the pin has arrived.
    pub(super) turn: [f64; 2],
}

/// A translation that falls off to 0 at the rim of a disc:
///
/// ```text
/// x ↦ x + s φ(|x − c|²/r²),   φ(q) = (1 − q)³ for q < 1, else 0      (C2; |∇φ| ≤ SLOPE / r)
/// ```
///
/// With |s| SLOPE ≤ STEEP r and STEEP < 1 it maps its disc one-to-one onto itself.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Push {
    center: DVec2,
    shift: DVec2,
    /// 1/r².
    inverse_square: f64,
}

/// One step of the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Push(Push),
    Swirl(Swirl),
}

/// Steps whose box overlaps that of no other group.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    lo: DVec2,
    hi: DVec2,
    /// Steps, in order.
    steps: Vec<Step>,
}

/// A one-to-one map of the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Flow {
    groups: Vec<Group>,
    /// Upper bound of the displacement, in frame heights.
    reach: f64,
    /// Final position of every pin.
    ends: Vec<DVec2>,
}

impl Flow {
    /// Creates the flow that moves pins to their targets, as far as the other pins allow.
    pub(super) fn of(flow_pins: &[FlowPin], bounds: ScreenBox) -> Self {
        let packing = DiscPacking { flow_pins, bounds, even: EVEN * longest(flow_pins) };
        let mut centers: Vec<DVec2> = flow_pins.iter().map(|flow_pin| flow_pin.from).collect();
        let mut done: Vec<f64> =
            flow_pins.iter().map(|flow_pin| f64::from(u8::from(flow_pin.to == flow_pin.from))).collect();
        let mut tracks = vec![Vec::new(); flow_pins.len()];
        let (mut clock, mut reach) = (0.0_f64, 0.0);
        for number in 0..MAX_STEPS {
            let moving = (0..flow_pins.len()).filter(|&index| done[index] < 1.0);
            let moving: Vec<(usize, [f64; 2])> = moving.map(|index| (index, packing.speed(&centers, index))).collect();
            if moving.is_empty() {
                break;
            }
            let left = if clock < 1.0 { 1.0 - clock } else { f64::INFINITY };
            let step = moving.iter().map(|(_, [step, _])| *step).fold(left, f64::min);
            clock = if step == left { 1.0 } else { clock + step };
            let before = centers.clone();
            let mut longest = 0.0_f64;
            for (index, [_, speed]) in moving {
                let flow_pin = &flow_pins[index];
                done[index] += step * speed;
                centers[index] = flow_pin.from.lerp(flow_pin.to, done[index]);
                if done[index] >= 1.0 - ARRIVED {
                    done[index] = 1.0;
                    centers[index] = flow_pin.to;
                }
                let shift = centers[index] - before[index];
                let radius = packing.radius(&before, index);
                longest = longest.max(shift.length());
                if shift != DVec2::ZERO && radius > 0.0 {
                    let push = Push { center: before[index], shift, inverse_square: radius.powi(-2) };
                    tracks[index].push((number, Step::Push(push)));
                }
            }
            reach += longest;
        }
        for (index, flow_pin) in flow_pins.iter().enumerate() {
            let swirls = Swirl::of(centers[index], packing.radius(&centers, index), flow_pin.turn);
            tracks[index].extend(swirls.into_iter().map(|swirl| (MAX_STEPS, Step::Swirl(swirl))));
        }
        reach += tracks.iter().flatten().map(|(_, step)| step.swing()).sum::<f64>();
        Self { groups: groups(tracks), reach, ends: centers }
    }

    /// Returns the final position of every pin, in input order.
    pub(super) fn ends(&self) -> &[DVec2] {
        &self.ends
    }

    /// Returns the initial disc radius of each pin, in frame heights, as if all had equally long paths.
    pub(super) fn first_radii(flow_pins: &[FlowPin], bounds: ScreenBox) -> Vec<f64> {
        let even: Vec<FlowPin> = flow_pins.iter().map(|flow_pin| FlowPin { to: flow_pin.from, ..*flow_pin }).collect();
        let packing = DiscPacking { flow_pins: &even, bounds, even: 1.0 };
        let centers: Vec<DVec2> = flow_pins.iter().map(|flow_pin| flow_pin.from).collect();
        (0..flow_pins.len()).map(|index| packing.radius(&centers, index)).collect()
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.groups.is_empty()
    }

    /// Upper bound of the displacement, in frame heights.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// Returns the displacement of a point (exactly 0 outside of all discs), and the gradient of the map.
    pub(super) fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        let (mut moved, mut gradient) = (DVec2::ZERO, DMat2::IDENTITY);
        for step in self.steps_at(point) {
            if let Some((by, slope)) = step.displace(point + moved) {
                moved += by;
                gradient = (DMat2::IDENTITY + slope) * gradient;
            }
        }
        (moved, gradient)
    }

    /// Returns the offset from a point to its preimage, and the gradient of the map there.
    pub(super) fn back(&self, point: DVec2) -> (DVec2, DMat2) {
        let (mut offset, mut gradient) = (DVec2::ZERO, DMat2::IDENTITY);
        for step in self.steps_at(point).iter().rev() {
            if let Some((by, slope)) = step.back(point + offset) {
                offset += by;
                gradient *= DMat2::IDENTITY + slope;
            }
        }
        (offset, gradient)
    }

    /// Whether a box is small compared with the discs that may touch it.
    pub(super) fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        let extent = (hi - lo).max_element();
        let touching = self.groups.iter().filter(|group| group.hi.cmpge(lo).all() && group.lo.cmple(hi).all());
        touching.flat_map(|group| &group.steps).all(|step| {
            let (center, radius) = step.disc();
            let nearest = center.clamp(lo, hi);
            nearest.distance_squared(center) >= radius * radius || extent <= PIECE * radius
        })
    }

    /// Returns the steps of the group that contains a point, if any. Boxes of groups do not overlap, and no step moves
    /// a point out of its box.
    fn steps_at(&self, point: DVec2) -> &[Step] {
        let around = |group: &&Group| point.cmpgt(group.lo).all() && point.cmplt(group.hi).all();
        self.groups.iter().find(around).map_or(&[], |group| &group.steps)
    }
}

/// Computes the space available to each pin.
struct DiscPacking<'a> {
    flow_pins: &'a [FlowPin],
    bounds: ScreenBox,
    even: f64,
}

impl DiscPacking<'_> {
    /// Returns the radius of a pin's disc, which stays inside the border and clear of the other discs. Pins with longer
    /// paths get a larger share of the space.
    fn radius(&self, centers: &[DVec2], index: usize) -> f64 {
        let own = &self.flow_pins[index];
        let at = centers[index];
        let mut radius = LARGEST.min(FILL * inside(self.bounds, at).max(0.0) + own.border_slack);
        let claim = |flow_pin: &FlowPin| flow_pin.from.distance(flow_pin.to) + self.even * flow_pin.weight;
        for (other, flow_pin) in self.flow_pins.iter().enumerate() {
            if other != index && flow_pin.weight > 0.0 {
                let all = claim(own) + claim(flow_pin);
                let share = if all > 0.0 { claim(own) / all } else { 0.5 };
                radius = radius.min(FILL * share * at.distance(centers[other]) / flow_pin.weight);
            }
        }
        radius
    }

    /// Returns the longest step that a pin may take and its speed, both as fractions of its path.
    fn speed(&self, centers: &[DVec2], index: usize) -> [f64; 2] {
        let flow_pin = &self.flow_pins[index];
        let length = flow_pin.from.distance(flow_pin.to);
        let room = (self.radius(centers, index) - FLOOR).max(0.0) / length;
        [STEEP * room.max(SLOW) / SLOPE, (room / SLOW).min(1.0)]
    }
}

impl Step {
    fn disc(&self) -> (DVec2, f64) {
        match self {
            Self::Push(push) => (push.center, push.inverse_square.powf(-0.5)),
            Self::Swirl(swirl) => swirl.disc(),
        }
    }

    /// Bound of the displacement that comes on top of the sum of the pin's pushes.
    fn swing(&self) -> f64 {
        match self {
            Self::Push(_) => 0.0,
            Self::Swirl(swirl) => swirl.reach(),
        }
    }

    fn displace(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        match self {
            Self::Push(push) => push.displace(point),
            Self::Swirl(swirl) => swirl.displace(point),
        }
    }

    fn back(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        match self {
            Self::Push(push) => push.back(point),
            Self::Swirl(swirl) => swirl.back(point),
        }
    }
}

impl Push {
    /// Returns φ at a position relative to the centre, and its gradient; `None` outside the disc.
    fn bump(&self, from_center: DVec2) -> Option<(f64, DVec2)> {
        let rest = 1.0 - from_center.length_squared() * self.inverse_square;
        (rest > 0.0).then(|| (rest * rest * rest, from_center * (-6.0 * rest * rest * self.inverse_square)))
    }

    fn displace(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let (height, slope) = self.bump(point - self.center)?;
        Some((self.shift * height, DMat2::from_cols(self.shift * slope.x, self.shift * slope.y)))
    }

    /// Solves a = φ(y − s a) by Newton's method. The residual increases with a, so there is exactly one solution in 0..1.
    fn back(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let from_center = point - self.center;
        let (mut height, mut slope) = self.bump(from_center)?;
        let (mut lo, mut hi, mut share) = (0.0, 1.0, height);
        for _ in 0..MAX_NEWTON {
            (height, slope) = self.bump(from_center - self.shift * share).unwrap_or_default();
            let miss = share - height;
            if miss < 0.0 {
                lo = share
            } else {
                hi = share
            }
            let next = share - miss / (1.0 + slope.dot(self.shift));
            let next = if next > lo && next < hi { next } else { 0.5 * (lo + hi) };
            if miss == 0.0 || (next - share).abs() <= 1e-16 {
                break;
            }
            share = next;
        }
        Some((self.shift * -share, DMat2::from_cols(self.shift * slope.x, self.shift * slope.y)))
    }
}

/// Returns the distance of a point from the border of a box, negative outside.
fn inside(bounds: ScreenBox, point: DVec2) -> f64 {
    (point - bounds.min.0).min(bounds.max.0 - point).min_element()
}

fn longest(flow_pins: &[FlowPin]) -> f64 {
    flow_pins.iter().map(|flow_pin| flow_pin.from.distance(flow_pin.to)).fold(0.0, f64::max)
}

/// Merges tracks of pins whose boxes overlap. Each group keeps the order of its steps; steps of equal number are ordered by pin.
fn groups(tracks: Vec<Vec<(usize, Step)>>) -> Vec<Group> {
    struct Open {
        lo: DVec2,
        hi: DVec2,
        steps: Vec<(usize, usize, Step)>,
    }
    let mut open: Vec<Open> = Vec::new();
    for (index, track) in tracks.into_iter().enumerate().filter(|(_, track)| !track.is_empty()) {
        let discs = || track.iter().map(|(_, step)| step.disc());
        let lo = discs().map(|(center, radius)| center - radius).fold(DVec2::INFINITY, DVec2::min);
        let hi = discs().map(|(center, radius)| center + radius).fold(DVec2::NEG_INFINITY, DVec2::max);
        let steps = track.into_iter().map(|(number, step)| (number, index, step)).collect();
        let mut grown = Open { lo, hi, steps };
        // The grown box may overlap further groups.
        while let Some(met) =
            open.iter().position(|other| other.lo.cmplt(grown.hi).all() && other.hi.cmpgt(grown.lo).all())
        {
            let other = open.swap_remove(met);
            grown.lo = grown.lo.min(other.lo);
            grown.hi = grown.hi.max(other.hi);
            grown.steps.extend(other.steps);
        }
        open.push(grown);
    }
    let closed = open.into_iter().map(|mut group| {
        group.steps.sort_by_key(|&(number, index, _)| (number, index));
        Group { lo: group.lo, hi: group.hi, steps: group.steps.into_iter().map(|(.., step)| step).collect() }
    });
    closed.collect()
}
