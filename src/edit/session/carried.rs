//! Pins under the pen: while they are dragged, their marks follow it at once, however long the solve takes.
//!
//! In: the drag in progress, the marks that are shown. Out: marks in which the dragged pins lie under the pen.

use super::Session;
use super::gesture::{Carried, Gesture};
use crate::pipeline::PinMark;
use crate::shot::Shot;
use crate::space::{ScreenPoint, ScreenVector};
use glam::DVec2;
use std::sync::Arc;

impl Session {
    /// Returns a drag of the selection that begins at a point.
    pub(super) fn drag_from(&self, from: ScreenPoint, base: Arc<Shot>) -> Gesture {
        let marks = self.marks();
        let seen = marks.iter().flat_map(|marks| marks.pins.iter().map(|pin| ([marks.layer, pin.pin], pin.target)));
        let pins = seen.filter(|(at, _)| self.selection.pins.contains(at)).collect();
        let carried = Carried { frame: self.playhead.frame(), pins, by: DVec2::ZERO };
        Gesture::Drag { from, base, has_moved: false, carried }
    }

    /// Starts dragging the pin that was just placed at a point.
    pub(super) fn drag_placed(&mut self, from: ScreenPoint) {
        let base = Arc::new(self.document.shot().clone());
        self.gesture = self.drag_from(from, base);
        if let (Gesture::Drag { carried, .. }, Some(placed)) = (&mut self.gesture, self.selection.single_pin()) {
            carried.pins = vec![(placed, from)];
        }
    }

    /// Moves the marks of the dragged pins to the pen.
    pub(super) fn carry_pins(&mut self) {
        let Gesture::Drag { carried, has_moved: true, .. } = &self.gesture else { return };
        let here = self.playhead.frame();
        let fits = |frame: i32| frame == here && frame == carried.frame;
        let Some(solve) = self.current_solve.as_mut().filter(|solve| fits(solve.frame)) else { return };
        let solve = Arc::make_mut(solve);
        for &([layer, pin], from) in &carried.pins {
            let Some(marks) = solve.marks.iter_mut().find(|marks| marks.layer == layer) else { continue };
            let target = from + ScreenVector(carried.by);
            match marks.pins.iter_mut().find(|mark| mark.pin == pin) {
                Some(mark) => mark.target = target,
                None => marks.pins.push(placed(pin, from, target)),
            }
        }
    }

    /// Puts the marks of the dragged pins back to where they were when the drag began.
    pub(super) fn put_carried_back(&mut self) {
        if let Gesture::Drag { carried, .. } = &mut self.gesture {
            carried.by = DVec2::ZERO;
            self.carry_pins();
        }
    }
}

/// Returns the mark of a pin that no solve knows yet.
const fn placed(pin: usize, rest: ScreenPoint, target: ScreenPoint) -> PinMark {
    PinMark { pin, rest, target, rim: Vec::new(), steps: None, metres_per_height: None, turn_axes: None }
}

#[cfg(test)]
mod tests {
    use super::super::{Held, Ring};
    use super::*;
    use crate::edit::worker::{Reply, SolvedFrame};
    use crate::pipeline::{FrameReport, LayerMarks};

    const SHOT: &str = "scene = 'a.glb'\nframes = { first = 1, last = 24 }\n[[layer]]\nname = 'all'\n[[layer.pin]]\nname = 'a'\n\
                        anchor = { screen = [0.5, 0.5], frame = 1 }\n";

    fn solved(session: &mut Session, target: ScreenPoint) {
        let marks = LayerMarks { pins: vec![placed(0, target, target)], ..LayerMarks::default() };
        let (frame, revision, report) = (1, session.revision, FrameReport::default());
        let solved = SolvedFrame { frame, revision, marks: vec![marks], report, is_final: false };
        session.take(Reply::Solved(Arc::new(solved)));
    }

    #[test]
    fn a_dragged_pin_is_under_the_pen_before_anything_is_solved() {
        let mut session = Session::of_text(SHOT);
        let (from, by) = (ScreenPoint::new(0.5, 0.5), ScreenVector(DVec2::new(0.1, 0.2)));
        solved(&mut session, from);
        let target = |session: &Session| session.marks()[0].pins[0].target;
        session.press(from, (0.01, Ring { radius: 9.0, reach: 0.0 }), Held::default());
        session.motion(from + by);
        assert_eq!(target(&session), from + by, "no reply was read since");
        // A solve of an earlier moment of the drag does not pull it back.
        solved(&mut session, from + ScreenVector(DVec2::new(0.05, 0.1)));
        assert_eq!(target(&session), from + by);
        session.cancel();
        assert_eq!(target(&session), from, "a drag that is given up leaves it where it was");
    }
}
