//! Clicks and strokes that the pen has left, but that wait for answers of the worker: quick hands are ahead of it.
//!
//! In: gestures that another press overtakes, answers. Out: the pins and strokes that they become.

use super::Session;
use super::gesture::{Click, Gesture, Painting};
use crate::edit::worker::FoundPoint;
use std::collections::VecDeque;

/// What was done with the pen before its last press, and is not in the document yet.
#[derive(Clone, Debug, Default)]
pub(super) struct Overtaken {
    /// Clicks without an answer.
    clicks: Vec<Click>,
    /// Clicks on surfaces, with what was found.
    found: VecDeque<(Click, FoundPoint)>,
    /// Strokes with questions that are open.
    strokes: Vec<Painting>,
}

impl Overtaken {
    /// Returns the stroke with this id.
    pub(super) fn stroke_mut(&mut self, id: u64) -> Option<&mut Painting> {
        self.strokes.iter_mut().find(|painting| painting.id == id)
    }

    /// Takes out a stroke whose questions are all answered.
    pub(super) fn take_answered_stroke(&mut self) -> Option<Painting> {
        let place = self.strokes.iter().position(|painting| painting.waiting == 0)?;
        Some(self.strokes.remove(place))
    }
}

impl Session {
    /// Sets the gesture aside if the pen is up and it waits for answers alone, as the pen is pressed again.
    pub(super) fn set_gesture_aside(&mut self) {
        if let Gesture::Placing { click, is_up: true, .. } = self.gesture {
            self.overtaken.clicks.push(click);
            self.gesture = Gesture::Idle;
        } else if let Gesture::Paint(painting) = &self.gesture
            && painting.is_up
        {
            self.overtaken.strokes.push(painting.clone());
            self.gesture = Gesture::Idle;
        }
    }

    /// Takes the answer about a click that was overtaken. Returns whether it was one.
    pub(super) fn picked_before(&mut self, id: u64, found: Option<&FoundPoint>) -> bool {
        let Some(place) = self.overtaken.clicks.iter().position(|click| click.id == id) else { return false };
        let click = self.overtaken.clicks.remove(place);
        self.overtaken.found.extend(found.map(|found| (click, found.clone())));
        self.place_overtaken();
        true
    }

    /// Places the pins of clicks that were overtaken, unless the pen drags: a new pin would end that. What is selected stays.
    pub(super) fn place_overtaken(&mut self) {
        while matches!(self.gesture, Gesture::Idle | Gesture::Placing { .. })
            && let Some((click, found)) = self.overtaken.found.pop_front()
        {
            let selected = self.selection.clone();
            if let Some(layer) = found.point.layer
                && self.place(layer, &found, click)
                && !selected.pins.is_empty()
            {
                self.selection = selected;
            }
        }
    }

    /// Takes back the last click that waits for an answer. Returns whether there was one.
    pub(super) fn take_back_click(&mut self) -> bool {
        if matches!(self.gesture, Gesture::Placing { .. }) {
            self.gesture = Gesture::Idle;
            return true;
        }
        self.overtaken.clicks.pop().is_some() || self.overtaken.found.pop_back().is_some()
    }
}
