//! What a user sets: pins, and the lattice that they bend.
//!
//! Plain data in frame heights, y up, origin at the lower left of the display window, as in shot files.

use super::LiveError;
use crate::lattice::Basis;
use crate::space::ScreenPoint;

/// Greatest stiffness, and one over the least.
const MOST_STIFF: f64 = 10.0;

/// Handles an axis at most.
const MOST_HANDLES: usize = 64;

/// Frame heights beyond which a number was surely meant as pixels.
const FURTHEST: f64 = 1000.0;

/// Everything that one moment of a warp needs beside the [`Shape`](super::Shape).
///
/// ```
/// use pinwarp::live::{Controls, Pin, Shape, warp};
/// use pinwarp::space::{FrameSize, ScreenPoint};
/// let pin = Pin::new(ScreenPoint::new(0.8, 0.5), ScreenPoint::new(0.9, 0.6));
/// let controls = Controls { pins: vec![pin], ..Controls::default() };
/// let warp = warp(&controls, &Shape::Frame, FrameSize::new(1920, 1080))?;
/// assert!((warp.field.carry(pin.rest).0 - pin.target.0).length() < 1e-5);
/// # Ok::<(), pinwarp::live::LiveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Controls {
    /// Handles across and up, 2 to 64 (B-splines: from 4 on).
    pub dims: [usize; 2],
    /// How handles are blended.
    pub basis: Basis,
    /// How much the lattice resists being bent, 0.1 to 10; 1 is usual. Its cube scales the weight of the regulariser
    /// ([`Settings::with_stiffness`](crate::solve::Settings::with_stiffness)): more spreads the pull of a pin evenly over the whole shape. The
    /// usual weight is small beside the distortion, so less than 1 changes little.
    pub stiffness: f64,
    /// Scales offsets, rotations and the logarithms of scales; 0: no warp.
    pub strength: f64,
    /// What is moved.
    pub moved: Moved,
    /// Pins, in the user's order.
    pub pins: Vec<Pin>,
}

/// Which part of the picture moves. It decides what happens around the lattice's box and at the border of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moved {
    /// All of it: the border of a whole frame is held, so that its background neither slides nor kinks.
    #[default]
    Picture,
    /// What a mask selects: it is free, and the rest stays.
    Masked,
}

/// A point of the picture and where it has to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// Where it is before the warp; over a shot: in the frame in which pins are placed.
    pub rest: ScreenPoint,
    /// Where it goes; over a shot `target - rest` is added to wherever the pinned point is in the frame.
    pub target: ScreenPoint,
    /// The turn it holds, radians, counter-clockwise, more than a turn allowed; `None`: free.
    pub rotation: Option<f64>,
    /// The scale it holds, above 0; `None`: free.
    pub scale: Option<f64>,
}

impl Pin {
    /// A pin that holds nothing but its point.
    #[must_use]
    pub const fn new(rest: ScreenPoint, target: ScreenPoint) -> Self {
        Self { rest, target, rotation: None, scale: None }
    }
}

impl Default for Controls {
    /// A 10 x 10 B-spline lattice of usual stiffness and full strength, without pins.
    fn default() -> Self {
        Self {
            dims: [10, 10],
            basis: Basis::Bspline,
            stiffness: 1.0,
            strength: 1.0,
            moved: Moved::Picture,
            pins: Vec::new(),
        }
    }
}

impl Controls {
    /// Whether it is plain without solving that nothing moves (a shot's own pins aside).
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        let moves = |pin: &Pin| {
            let turns = pin.rotation.is_some_and(|angle| angle != 0.0);
            pin.rest != pin.target || turns || pin.scale.is_some_and(|scale| scale != 1.0)
        };
        self.strength == 0.0 || !self.pins.iter().any(moves)
    }

    /// How far a warp carries a point at most, frame heights, where nothing can be solved yet: no sensible one carries any
    /// further than its furthest pin and half more, or, turning, than across the frame.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let furthest = self.pins.iter().map(|pin| (pin.target - pin.rest).0.length()).fold(0.0, f64::max);
        let turns = self.pins.iter().any(|pin| pin.rotation.is_some());
        self.strength.abs() * furthest * 1.5 + if turns { 1.0 } else { 0.0 }
    }

    /// Refuses what no slider may send: numbers that are none, and values out of range.
    pub(super) fn check(&self) -> Result<(), LiveError> {
        let fault = |what: String, hint: &str| Err(LiveError::Controls { what, hint: hint.to_owned() });
        if !(1.0 / MOST_STIFF..=MOST_STIFF).contains(&self.stiffness) {
            return fault(format!("a stiffness of {} is out of range", self.stiffness), "keep it within 0.1 to 10");
        }
        let least = if self.basis == Basis::Bspline { 4 } else { 2 };
        if self.dims.iter().any(|count| !(least..=MOST_HANDLES).contains(count)) {
            let what = format!("a lattice of {} x {} handles is out of range", self.dims[0], self.dims[1]);
            return fault(what, "give 2 to 64 an axis, with B-splines 4 to 64");
        }
        if !self.strength.is_finite() {
            return fault(format!("a strength of {} is no number", self.strength), "give 1, or 0 for no warp");
        }
        for (index, pin) in self.pins.iter().enumerate() {
            let places = [pin.rest.0, pin.target.0];
            if places.iter().any(|place| !place.is_finite() || place.abs().max_element() > FURTHEST) {
                let what = format!("pin {} lies at {} and goes to {}", index + 1, places[0], places[1]);
                return fault(what, "give places in frame heights, within 1000 of the frame");
            }
            if pin.rotation.is_some_and(|angle| !angle.is_finite())
                || pin.scale.is_some_and(|scale| !(scale > 0.0 && scale.is_finite()))
            {
                let what = format!("pin {} holds a rotation or scale that is none", index + 1);
                return fault(what, "give a finite angle, and a scale above 0");
            }
        }
        Ok(())
    }
}
