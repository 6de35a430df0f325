//! The rings around a selected pin, which turn it: one in the view, or one per axis of the scene.
//!
//! In: the marks of the frame, the pen. Out: rings to draw; the gesture of the ring under the pen.

use super::gesture::Gesture;
use super::{Ring, Session};
use crate::edit::AxisRing;
use crate::pipeline::PinMark;
use crate::shot::Shot;
use crate::space::ScreenPoint;
use std::sync::Arc;

impl Session {
    /// Returns the target of the single selected pin.
    #[must_use]
    pub(crate) fn ring_center(&self) -> Option<ScreenPoint> {
        self.ringed_pin().map(|mark| mark.target)
    }

    /// Returns the rings that turn the selected pin about x, y and z; `None` if it turns in the view.
    #[must_use]
    pub(crate) fn axis_rings(&self) -> Option<[AxisRing; 3]> {
        Some(self.ringed_pin()?.turn_axes?.map(AxisRing::about))
    }

    fn ringed_pin(&self) -> Option<&PinMark> {
        let [layer, pin] = self.selection.single_pin().filter(|_| self.shown.shows_pins())?;
        self.marks_of(layer)?.pins.iter().find(|mark| mark.pin == pin)
    }

    /// Returns the gesture of the ring under the pen; of rings that cross there, that of the nearest one on the near side.
    pub(super) fn turn_at(&self, at: ScreenPoint, ring: Ring, base: &Arc<Shot>) -> Option<Gesture> {
        let (center, base) = (self.ring_center()?, Arc::clone(base));
        let away = (at - center).0;
        let Some(rings) = self.axis_rings() else {
            let is_near = (away.length() - ring.radius).abs() <= ring.reach;
            return is_near.then_some(Gesture::Turn { center, from: at, turned: 0.0, base });
        };
        let far = rings.map(|axis_ring| axis_ring.distance(away / ring.radius));
        let hit = (0..3).filter(|&axis| far[axis].0 * ring.radius <= ring.reach);
        let axis = hit.min_by(|&a, &b| far[b].1.cmp(&far[a].1).then(far[a].0.total_cmp(&far[b].0)))?;
        let (radius, turned) = (ring.radius, 0.0);
        Some(Gesture::TurnAbout { center, radius, axis, ring: rings[axis], from: at, turned, base })
    }
}
