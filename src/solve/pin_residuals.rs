//! Pins that miss their targets, with the reasons.
//!
//! In: a finished solve. Out: one entry per pin that misses its target, with the reason as an enum and in words.

use super::constraints::{ConstraintOwner, Constraints};
use super::problem::PointPin;
use super::settings::{PinHold, Settings};
use super::yielding::YieldingPair;
use serde::Serialize;

/// Residuals below this fraction of the box diagonal are ignored: a fiftieth of a pixel where the box fills 1080 lines.
pub(super) const MIN_RESIDUAL: f64 = 1e-5;

/// A pin that misses its target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PinResidual {
    /// Index of the pin.
    pub pin: usize,
    /// Distance from the target, in units of the space.
    pub distance: f64,
    /// Reason of the residual.
    pub reason: ResidualReason,
}

/// Reason why a pin misses its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ResidualReason {
    /// Another pin or moved handle contradicts it; the solution is a compromise (least squares).
    Conflict(ConstraintOwner),
    /// The pin lies outside the box, so that the nearest point of the box is held instead, which another pin or handle also holds.
    Outside(ConstraintOwner),
    /// Position, rotation and scale of the pin together over-constrain the handles around it.
    Overloaded,
    /// The pin and another one, less than a span of the lattice apart, demand more stretch than the settings allow, so both give
    /// way.
    Yielding(ConstraintOwner),
    /// The pin is fading out: its weight is below 1.
    Fading,
    /// The settings make pins soft, and the shape pulls the pin back.
    Soft,
    /// The pin gave way to the barrier, because the lattice would fold.
    Guard,
    /// The iteration ended before the pin reached its target.
    Unconverged,
}

impl ResidualReason {
    /// Returns the reason in words, to follow "the pin is off its target: ". `name_of` returns the name of a pin for its index.
    #[must_use]
    pub(crate) fn words(&self, name_of: impl Fn(usize) -> String) -> String {
        let holder = |holder: &ConstraintOwner| match *holder {
            ConstraintOwner::Pin(pin) => format!("pin {}", name_of(pin)),
            ConstraintOwner::Handle(entry) => format!("moved handle {entry}"),
        };
        match self {
            Self::Conflict(rival) => {
                let rival = holder(rival);
                format!(
                    "it and {rival} over-constrain the lattice, which meets both as well as it can (least squares); move them \
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
            Self::Overloaded => "its position, rotation and scale together over-constrain its cell of the lattice; \
                                 use more handles, or let it hold its position alone"
                .into(),
            Self::Yielding(rival) => {
                let rival = holder(rival);
                format!(
                    "it and {rival} are less than a span of the lattice apart and ask for more stretch between them than \
                     max_stretch allows, so both give way; move them apart, bring their targets nearer, or use more handles"
                )
            }
            Self::Fading => "its weight is below 1, or it is fading out near the camera".into(),
            Self::Soft => "pins are soft in these settings; use hard pins or a larger weight".into(),
            Self::Guard => "it gives way where the lattice would fold; move it less, move the pins near it along, or use more handles".into(),
            Self::Unconverged => "the solve ended before it reached its target; allow more iterations".into(),
        }
    }
}

/// Data from which the reasons are derived.
pub(crate) struct Evidence<'a, const D: usize> {
    pub(crate) pins: &'a [PointPin<D>],
    pub(crate) settings: &'a Settings,
    pub(crate) constraints: &'a Constraints,
    /// Pairs of pins that give way.
    pub(crate) yielding: &'a [YieldingPair],
    /// Whether some pins gave way to the barrier.
    pub(crate) is_held_back: bool,
    /// Lower and upper corner of the box.
    pub(crate) bounds: [[f64; D]; 2],
    /// Diagonal of the box.
    pub(crate) diagonal: f64,
}

/// Lists the pins that miss their targets; `errors` holds the distance of each pin from its target.
pub(crate) fn residuals<const D: usize>(evidence: &Evidence<D>, errors: &[f64]) -> Vec<PinResidual> {
    let far = errors.iter().enumerate().filter(|(_, error)| **error > MIN_RESIDUAL * evidence.diagonal);
    far.map(|(pin, &distance)| PinResidual { pin, distance, reason: evidence.reason(pin) }).collect()
}

impl<const D: usize> Evidence<'_, D> {
    /// Returns the other pin of the most compliant pair that contains a pin.
    fn yields_to(&self, index: usize) -> Option<usize> {
        let own = self.yielding.iter().filter(|pair| pair.pins.contains(&index));
        let most = own.reduce(|most, pair| if pair.compliance > most.compliance { pair } else { most })?;
        Some(if most.pins[0] == index { most.pins[1] } else { most.pins[0] })
    }

    fn reason(&self, index: usize) -> ResidualReason {
        let pin = &self.pins[index];
        let [lo, hi] = self.bounds;
        let is_outside = (0..D).any(|axis| !(lo[axis]..=hi[axis]).contains(&pin.at[axis]));
        match self.constraints.rival(index) {
            Some(ConstraintOwner::Pin(rival)) if rival == index => ResidualReason::Overloaded,
            Some(rival) if is_outside => ResidualReason::Outside(rival),
            Some(rival) => ResidualReason::Conflict(rival),
            None if let Some(rival) = self.yields_to(index) => ResidualReason::Yielding(ConstraintOwner::Pin(rival)),
            None if pin.weight < 1.0 => ResidualReason::Fading,
            None if self.is_held_back => ResidualReason::Guard,
            None if self.settings.pin_hold == PinHold::Soft => ResidualReason::Soft,
            None => ResidualReason::Unconverged,
        }
    }
}
