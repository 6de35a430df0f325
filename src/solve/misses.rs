//! Why a pin is off its target.
//!
//! In: a finished solve. Out: one entry a pin that misses, with the reason as an enum and in words.

use super::constraints::{Constraints, Holder};
use super::{PinHold, PointPin, Settings};
use serde::Serialize;

/// A miss below this part of the box diagonal is none: a fiftieth of a pixel where the box fills 1080 lines.
const LEAST: f64 = 1e-5;

/// A pin that is not where it was put.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PinMiss {
    /// Index of the pin.
    pub pin: usize,
    /// Distance from its target, in units of the space.
    pub distance: f64,
    /// Why.
    pub reason: MissReason,
}

/// Why a pin is off its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum MissReason {
    /// Another pin or moved handle contradicts it: it goes between them (least squares).
    Conflict(Holder),
    /// It lies outside the box, where the nearest box point stands for it, and another holds that point.
    Outside(Holder),
    /// It alone asks for more than the handles around it can do: its place and its rotation and scale.
    Overloaded,
    /// It fades out: its weight is below 1.
    Fading,
    /// Pins are soft in these settings: the shape pulls it back.
    Soft,
    /// It was walked back along its path, because the lattice would fold.
    Guard,
    /// The iteration ended before it arrived.
    Unconverged,
}

impl MissReason {
    /// The reason in words that go on after "the pin is off its target: "; `name_of` names a pin by its index.
    #[must_use]
    pub fn words(&self, name_of: impl Fn(usize) -> String) -> String {
        let holder = |holder: &Holder| match *holder {
            Holder::Pin(pin) => format!("pin {}", name_of(pin)),
            Holder::Handle(entry) => format!("moved handle {entry}"),
        };
        match self {
            Self::Conflict(rival) => {
                let rival = holder(rival);
                format!(
                    "it and {rival} ask for more than the lattice can do between them (least squares); move them \
                         apart, remove one, or use more handles"
                )
            }
            Self::Outside(rival) => {
                let rival = holder(rival);
                format!(
                    "it lies outside the lattice box, where it and {rival} hold the same border point; enlarge the \
                         box or remove one"
                )
            }
            Self::Overloaded => {
                "its place and its rotation and scale together are more than its cell of the lattice can do; \
                                 use more handles, or let it hold its place alone"
                    .into()
            }
            Self::Fading => "it fades out near the camera".into(),
            Self::Soft => "pins are soft in these settings; use hard pins or a larger weight".into(),
            Self::Guard => "it was walked back so that nothing folds".into(),
            Self::Unconverged => "the solve ended before it arrived; allow more iterations".into(),
        }
    }
}

/// What a reason is told from.
pub(crate) struct Evidence<'a, const D: usize> {
    pub(crate) pins: &'a [PointPin<D>],
    pub(crate) settings: &'a Settings,
    pub(crate) constraints: &'a Constraints,
    /// Corners of the box.
    pub(crate) bounds: [[f64; D]; 2],
    /// The box diagonal.
    pub(crate) diagonal: f64,
}

/// The pins that miss; `errors`: distances of all pins from their targets.
pub(crate) fn misses<const D: usize>(evidence: &Evidence<D>, errors: &[f64]) -> Vec<PinMiss> {
    let far = errors.iter().enumerate().filter(|(_, error)| **error > LEAST * evidence.diagonal);
    far.map(|(pin, &distance)| PinMiss { pin, distance, reason: evidence.reason(pin) }).collect()
}

impl<const D: usize> Evidence<'_, D> {
    fn reason(&self, index: usize) -> MissReason {
        let pin = &self.pins[index];
        let [lo, hi] = self.bounds;
        let is_outside = (0..D).any(|axis| !(lo[axis]..=hi[axis]).contains(&pin.at[axis]));
        match self.constraints.rival(index) {
            Some(Holder::Pin(rival)) if rival == index => MissReason::Overloaded,
            Some(rival) if is_outside => MissReason::Outside(rival),
            Some(rival) => MissReason::Conflict(rival),
            None if pin.weight < 1.0 => MissReason::Fading,
            None if self.settings.pin_hold == PinHold::Soft => MissReason::Soft,
            None => MissReason::Unconverged,
        }
    }
}
