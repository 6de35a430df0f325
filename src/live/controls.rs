//! The user's parameters: pins, and the lattice that they deform.
//!
//! Plain data in frame heights, y up, origin at the lower left of the display window, as in shot files.

use super::LiveError;
use crate::lattice::{Basis, MAX_HANDLES};
use crate::solve::Guard;
use crate::space::ScreenPoint;

/// Largest smoothness, and the reciprocal of the smallest.
const MAX_SMOOTHNESS: f64 = 10.0;

/// Coordinates beyond this many frame heights are assumed to be in pixels by mistake.
const FURTHEST: f64 = 1000.0;

/// The parameters of a warp at one time, besides the [`ShapeSource`](super::ShapeSource).
///
/// ```
/// use pinwarp::live::{Controls, Pin, ShapeSource, warp};
/// use pinwarp::space::{FrameSize, ScreenPoint};
/// let pin = Pin::new(ScreenPoint::new(0.8, 0.5), ScreenPoint::new(0.9, 0.6));
/// let controls = Controls { pins: vec![pin], ..Controls::default() };
/// let warp = warp(&controls, &ShapeSource::Frame, FrameSize::new(1920, 1080))?;
/// assert!((warp.field.carry(pin.rest).0 - pin.target.0).length() < 1e-5);
/// # Ok::<(), pinwarp::live::LiveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Controls {
    /// Number of handles horizontally and vertically, 2 to 64 (at least 4 for B-splines).
    pub dims: [usize; 2],
    /// Basis functions of the lattice.
    pub basis: Basis,
    /// Smoothness, 0.1 to 10; the default is 1. Its cube scales the weight of the regulariser: larger values spread the pull of a pin more evenly over
    /// the shape. The default weight is small compared with the distortion, so values below 1 change little.
    pub smoothness: f64,
    /// Scales offsets, rotations and the logarithms of scales; 0 disables the warp.
    pub strength: f64,
    /// Which part of the picture moves.
    pub moved: Moved,
    /// What happens before the lattice folds; with a shot, [`Guard::Report`] means that the file decides.
    pub guard: Guard,
    /// Pins, in the user's order.
    pub pins: Vec<Pin>,
}

/// Which part of the picture moves; determines the warp outside the lattice's box and at the border of the frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moved {
    /// All of it: the border of a whole frame is held, so that its background neither slides nor kinks.
    #[default]
    Picture,
    /// What a mask selects: it moves freely, and the rest stays.
    Masked,
}

/// A point of the picture and its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// Position before the warp; with a shot, in the frame in which pins are placed.
    pub rest: ScreenPoint,
    /// Target position; with a shot, `target - rest` is added to the position of the pinned point in the current frame.
    pub target: ScreenPoint,
    /// Prescribed rotation in radians, counter-clockwise; may exceed a full turn. `None`: free.
    pub rotation: Option<f64>,
    /// Prescribed scale, above 0; `None`: free.
    pub scale: Option<f64>,
    /// Weight, 0 to 1, on a logarithmic scale against the shape and other pins; 1 is an exact constraint.
    pub weight: f64,
    /// The region that moves with the pin; `None`: only its point.
    pub region: Option<PinRegion>,
}

/// The neighbourhood that moves with a pin, fading out smoothly to its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinRegion {
    /// Radius before the warp, in frame heights, above 0.
    pub radius: f64,
    /// How rigidly the region moves with the pin: 0 not at all, 1 as a rigid body.
    pub rigidity: f64,
    /// Stiffness of the shape at the pin, relative to its own stiffness.
    pub stiffness: f64,
}

impl Pin {
    /// Creates a pin that constrains only its point.
    #[must_use]
    pub const fn new(rest: ScreenPoint, target: ScreenPoint) -> Self {
        Self { rest, target, rotation: None, scale: None, weight: 1.0, region: None }
    }
}

impl Default for Controls {
    /// A 10 x 10 B-spline lattice with smoothness 1 and full strength, without pins.
    fn default() -> Self {
        Self {
            dims: [10, 10],
            basis: Basis::default(),
            smoothness: 1.0,
            strength: 1.0,
            moved: Moved::Picture,
            guard: Guard::Report,
            pins: Vec::new(),
        }
    }
}

impl Controls {
    /// Whether nothing moves, as far as is known without a solve; ignores a shot's own pins.
    #[cfg(any(test, feature = "ofx"))]
    #[must_use]
    pub(crate) fn is_at_rest(&self) -> bool {
        let moves = |pin: &Pin| {
            let turns = pin.rotation.is_some_and(|angle| angle != 0.0);
            pin.rest != pin.target || turns || pin.scale.is_some_and(|scale| scale != 1.0)
        };
        self.strength == 0.0 || !self.pins.iter().any(moves)
    }

    /// Rejects values that no slider may send: not finite, or out of range.
    pub(super) fn check(&self) -> Result<(), LiveError> {
        let fault = |what: String, hint: &str| Err(LiveError::Controls { what, hint: hint.to_owned() });
        if !(1.0 / MAX_SMOOTHNESS..=MAX_SMOOTHNESS).contains(&self.smoothness) {
            return fault(format!("a smoothness of {} is out of range", self.smoothness), "keep it within 0.1 to 10");
        }
        let least = self.basis.min_handles();
        if self.dims.iter().any(|count| !(least..=MAX_HANDLES).contains(count)) {
            let what = format!("a lattice of {} x {} handles is out of range", self.dims[0], self.dims[1]);
            return fault(what, "give 2 to 64 an axis, with B-splines 4 to 64");
        }
        if !self.strength.is_finite() {
            return fault(format!("strength {} is not finite", self.strength), "give 1, or 0 for no warp");
        }
        for (index, pin) in self.pins.iter().enumerate() {
            let places = [pin.rest.0, pin.target.0];
            if places.iter().any(|place| !place.is_finite() || place.abs().max_element() > FURTHEST) {
                return Err(LiveError::FarPin { pin: index, rest: pin.rest, target: pin.target });
            }
            if !has_sane_region(pin) {
                let what = format!("pin {} has a weight or a region that is out of range", index + 1);
                return fault(what, "keep weight and rigidity within 0 to 1, stiffness within 0.001 to 1000");
            }
            if pin.rotation.is_some_and(|angle| !angle.is_finite())
                || pin.scale.is_some_and(|scale| !(scale > 0.0 && scale.is_finite()))
            {
                let what = format!("pin {} has an invalid rotation or scale", index + 1);
                return fault(what, "give a finite angle, and a scale above 0");
            }
        }
        Ok(())
    }
}

/// Whether a pin's weight and region are valid for the solver.
fn has_sane_region(pin: &Pin) -> bool {
    let region = pin.region.is_none_or(|region| {
        let PinRegion { radius, rigidity, stiffness } = region;
        radius > 0.0 && radius <= FURTHEST && (0.0..=1.0).contains(&rigidity) && (1e-3..=1e3).contains(&stiffness)
    });
    region && (0.0..=1.0).contains(&pin.weight)
}
