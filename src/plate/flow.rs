//! Points that are carried to their targets by small pushes, each of which is one-to-one.
//!
//! In: pins with targets, the box whose border rests. Out: a map of the plane and its inverse, both exact (docs/METHOD.md, "Whole pictures").
//!
//! ```text
//! push:   x ↦ x + s φ(|x − c|²/r²),   φ(q) = (1 − q)³ for q < 1, else 0      (C2; |∇φ| ≤ SLOPE / r)
//! ```
//!
//! With |s| SLOPE ≤ STEEP r and STEEP < 1 a push maps its disc onto itself, one-to-one. Discs of one step do not overlap; so
//! the whole, one push after the other, is one-to-one whatever the pins ask for.

use super::swirl::Swirl;
use crate::space::ScreenBox;
use glam::{DMat2, DVec2};

/// 6/√5 (4/5)²: the steepest that φ(u²) falls, at u = 1/√5.
const SLOPE: f64 = 1.717_301_664;
/// A push moves no further than this part of what it could without folding.
const STEEP: f64 = 0.4;
/// Discs fill this part of the room that they have.
const FILL: f64 = 0.95;
/// Largest radius, frame heights.
const LARGEST: f64 = 0.35;
/// A pin whose disc is smaller than this part of its way goes more slowly than the others.
const SLOW: f64 = 0.05;
/// Radius at which a pin stands still before another that does not give way, frame heights: a fifth of a pixel at HD.
const FLOOR: f64 = 2e-4;
/// Part of the longest way that every pin's share of the room is raised by, so that no disc is tiny.
const EVEN: f64 = 0.05;
/// Steps after which a pin stays where it is: it stands before another that does not give way.
const MOST_STEPS: usize = 128;
/// What is left of a way, as a part of it, that counts as nothing.
const ARRIVED: f64 = 1e-12;
/// Newton steps of an inverse.
const MOST_NEWTON: usize = 40;
/// A disc is smooth over a box of this part of its radius.
const PIECE: f64 = 0.25;

/// A pin as the flow sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FlowPin {
    /// Where it is.
    pub(super) from: DVec2,
    /// Where it goes.
    pub(super) to: DVec2,
    /// 0 to 1: how much others keep off it.
    pub(super) weight: f64,
    /// How far its disc may reach beyond the border, frame heights.
    pub(super) give: f64,
    /// Angle, radians, and logarithm of the scale that are left to turn and swell by, once it is there.
    pub(super) turn: [f64; 2],
}

/// One push.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Push {
    center: DVec2,
    shift: DVec2,
    /// 1/r².
    inverse_square: f64,
}

/// What is done to the plane, step by step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Push(Push),
    Swirl(Swirl),
}

/// Pushes that share a box with no others.
#[derive(Clone, Debug, PartialEq)]
struct Group {
    lo: DVec2,
    hi: DVec2,
    /// One after the other.
    steps: Vec<Step>,
}

/// A one-to-one map of the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Flow {
    groups: Vec<Group>,
    /// No point moves further, frame heights.
    reach: f64,
    /// Where every pin ends.
    ends: Vec<DVec2>,
}

impl Flow {
    /// Carries pins to where they go, as far as others let them.
    pub(super) fn of(flow_pins: &[FlowPin], bounds: ScreenBox) -> Self {
        let rooms = Rooms { flow_pins, bounds, even: EVEN * longest(flow_pins) };
        let mut centers: Vec<DVec2> = flow_pins.iter().map(|flow_pin| flow_pin.from).collect();
        let mut done: Vec<f64> =
            flow_pins.iter().map(|flow_pin| f64::from(u8::from(flow_pin.to == flow_pin.from))).collect();
        let mut tracks = vec![Vec::new(); flow_pins.len()];
        let (mut clock, mut reach) = (0.0_f64, 0.0);
        for number in 0..MOST_STEPS {
            let moving = (0..flow_pins.len()).filter(|&index| done[index] < 1.0);
            let moving: Vec<(usize, [f64; 2])> = moving.map(|index| (index, rooms.speed(&centers, index))).collect();
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
                let radius = rooms.radius(&before, index);
                longest = longest.max(shift.length());
                if shift != DVec2::ZERO && radius > 0.0 {
                    let push = Push { center: before[index], shift, inverse_square: radius.powi(-2) };
                    tracks[index].push((number, Step::Push(push)));
                }
            }
            reach += longest;
        }
        for (index, flow_pin) in flow_pins.iter().enumerate() {
            let swirls = Swirl::of(centers[index], rooms.radius(&centers, index), flow_pin.turn);
            tracks[index].extend(swirls.into_iter().map(|swirl| (MOST_STEPS, Step::Swirl(swirl))));
        }
        reach += tracks.iter().flatten().map(|(_, step)| step.swing()).sum::<f64>();
        Self { groups: groups(tracks), reach, ends: centers }
    }

    /// Where every pin ends, in their order.
    pub(super) fn ends(&self) -> &[DVec2] {
        &self.ends
    }

    /// The disc that each of these pins starts with, frame heights, if all were as far from their targets.
    pub(super) fn first_radii(flow_pins: &[FlowPin], bounds: ScreenBox) -> Vec<f64> {
        let even: Vec<FlowPin> = flow_pins.iter().map(|flow_pin| FlowPin { to: flow_pin.from, ..*flow_pin }).collect();
        let rooms = Rooms { flow_pins: &even, bounds, even: 1.0 };
        let centers: Vec<DVec2> = flow_pins.iter().map(|flow_pin| flow_pin.from).collect();
        (0..flow_pins.len()).map(|index| rooms.radius(&centers, index)).collect()
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.groups.is_empty()
    }

    /// No point moves further, frame heights.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// How far a point moves (exactly 0 outside of all discs), and the gradient of the map.
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

    /// What has to be added to a point to find where it came from, and the gradient of the map there.
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

    /// Whether a box is small beside the discs that may touch it.
    pub(super) fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        let extent = (hi - lo).max_element();
        let touching = self.groups.iter().filter(|group| group.hi.cmpge(lo).all() && group.lo.cmple(hi).all());
        touching.flat_map(|group| &group.steps).all(|step| {
            let (center, radius) = step.disc();
            let nearest = center.clamp(lo, hi);
            nearest.distance_squared(center) >= radius * radius || extent <= PIECE * radius
        })
    }

    /// The steps of the group around a point; none elsewhere. Boxes of groups do not overlap, and no step leaves its box.
    fn steps_at(&self, point: DVec2) -> &[Step] {
        let around = |group: &&Group| point.cmpgt(group.lo).all() && point.cmplt(group.hi).all();
        self.groups.iter().find(around).map_or(&[], |group| &group.steps)
    }
}

/// The room of each pin.
struct Rooms<'a> {
    flow_pins: &'a [FlowPin],
    bounds: ScreenBox,
    even: f64,
}

impl Rooms<'_> {
    /// The disc of a pin: off the border, and apart from those of others; who goes further has more of the room.
    fn radius(&self, centers: &[DVec2], index: usize) -> f64 {
        let own = &self.flow_pins[index];
        let at = centers[index];
        let mut radius = LARGEST.min(FILL * inside(self.bounds, at).max(0.0) + own.give);
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

    /// The longest step that a pin allows, and its speed, both as parts of its way.
    fn speed(&self, centers: &[DVec2], index: usize) -> [f64; 2] {
        let flow_pin = &self.flow_pins[index];
        let way = flow_pin.from.distance(flow_pin.to);
        let room = (self.radius(centers, index) - FLOOR).max(0.0) / way;
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

    /// How far it moves a point beside what the pushes of its pin add up to.
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
    /// φ at a place counted from the centre, and its gradient; `None` outside.
    fn bump(&self, from_center: DVec2) -> Option<(f64, DVec2)> {
        let rest = 1.0 - from_center.length_squared() * self.inverse_square;
        (rest > 0.0).then(|| (rest * rest * rest, from_center * (-6.0 * rest * rest * self.inverse_square)))
    }

    fn displace(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let (height, slope) = self.bump(point - self.center)?;
        Some((self.shift * height, DMat2::from_cols(self.shift * slope.x, self.shift * slope.y)))
    }

    /// Newton's method on a = φ(y − s a), whose residual rises with a: within 0 and 1 there is one solution.
    fn back(&self, point: DVec2) -> Option<(DVec2, DMat2)> {
        let from_center = point - self.center;
        let (mut height, mut slope) = self.bump(from_center)?;
        let (mut lo, mut hi, mut share) = (0.0, 1.0, height);
        for _ in 0..MOST_NEWTON {
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

/// How far a point lies inside a box; below 0 outside.
pub(super) fn inside(bounds: ScreenBox, point: DVec2) -> f64 {
    (point - bounds.min.0).min(bounds.max.0 - point).min_element()
}

fn longest(flow_pins: &[FlowPin]) -> f64 {
    flow_pins.iter().map(|flow_pin| flow_pin.from.distance(flow_pin.to)).fold(0.0, f64::max)
}

/// Tracks of pins whose boxes overlap, together; in each the steps in their order, those of one number by pin.
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
        // What the grown box meets may make it meet more.
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
