//! The unit of a pin's region, and what a length on the screen is in it.
//!
//! In: a pin, the marks of the frame. Out: units, and factors.

use super::Session;
use crate::shot::{LayerSpace, OffsetUnit};

/// The unit of the radius of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RadiusUnit {
    /// Frame heights, shown as pixels.
    FrameHeights,
    /// Metres of the scene.
    Metres,
    /// Diagonals of the lattice's box, shown as per cent.
    Diagonals,
}

impl RadiusUnit {
    /// Returns the suffix of displayed numbers, and the display units in one of these. `lines`: frame height in pixels.
    pub(crate) const fn display(self, lines: f64) -> (&'static str, f64) {
        match self {
            Self::FrameHeights => (" px", lines),
            Self::Metres => (" m", 1.0),
            Self::Diagonals => (" %", 100.0),
        }
    }
}

impl Session {
    /// Returns the unit of the region of a pin.
    #[must_use]
    pub(crate) fn radius_unit(&self, [layer, pin]: [usize; 2]) -> RadiusUnit {
        let layer = self.shot().layers.get(layer);
        let unit = layer.and_then(|layer| layer.pins.get(pin)).map(|pin| pin.unit);
        match (unit, layer.map(|layer| layer.space)) {
            (Some(OffsetUnit::Box), _) => RadiusUnit::Diagonals,
            (_, Some(LayerSpace::World { .. })) => RadiusUnit::Metres,
            _ => RadiusUnit::FrameHeights,
        }
    }

    /// Returns what a frame height is in the unit of a pin's region, where the pin is; `None` if that is not known.
    #[must_use]
    pub(crate) fn radius_per_height(&self, at: [usize; 2]) -> Option<f64> {
        let scale = self.scale_of(at);
        match self.radius_unit(at) {
            RadiusUnit::FrameHeights => Some(1.0),
            RadiusUnit::Metres => scale.steps.map(|[right, _]| right.length()),
            RadiusUnit::Diagonals => scale.rest_box.map(|rest_box| rest_box.upright.size().length().recip()),
        }
    }
}
