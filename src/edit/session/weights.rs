//! How firmly pins hold their points: hard, or soft with a weight.
//!
//! In: user commands. Out: one document change each.

use super::Session;
use crate::shot::Pin;
use crate::shot::edit::{PinName, Setting, put_pin_setting};
use std::collections::BTreeSet;

/// Weight of a soft pin that had none before.
const USUAL_SOFT: f64 = 0.5;

impl Session {
    /// Sets the weight of a pin, and of its counterpart: 1 holds the point exactly, less lets it yield.
    pub(crate) fn set_weight(&mut self, at: [usize; 2], weight: f64) {
        let weight = (weight.clamp(0.0, 1.0) * 1e3).round() / 1e3;
        self.remember_soft(at);
        // A pin that follows another one has the weight of that one unless it says otherwise.
        let follows = self.own_pin(at).is_some_and(|pin| pin.mirror.is_some());
        let setting = setting(weight, follows);
        self.set_with_counterpart(at, "weight", |text, at| put_pin_setting(text, at, "weight", &setting));
    }

    /// Makes the selected pins hard or soft; all take the new state of the first.
    pub(crate) fn toggle_hard(&mut self) {
        let first = self.selection.pins.first().and_then(|&at| self.own_pin(at));
        match first.map(is_hard) {
            Some(is_hard) => self.set_hard(!is_hard),
            None => self.say("No pin is selected: click one first."),
        }
    }

    /// Makes the selected pins, and their counterparts, hold their points exactly, or yield with the weight that each had when it
    /// was soft last.
    pub(crate) fn set_hard(&mut self, to_hard: bool) {
        let chosen: BTreeSet<[usize; 2]> =
            self.selection.pins.iter().flat_map(|&at| self.with_counterpart(at)).collect();
        let changed = chosen.into_iter().filter(|&at| self.own_pin(at).is_some_and(|pin| is_hard(pin) != to_hard));
        let changed: Vec<[usize; 2]> = changed.collect();
        let mut text = Ok(self.document.text().to_owned());
        for &at in &changed {
            self.remember_soft(at);
            let Some(names) = self.names_of(at) else { continue };
            let weight = if to_hard { 1.0 } else { self.soft.get(&names).copied().unwrap_or(USUAL_SOFT) };
            let setting = setting(weight, self.own_pin(at).is_some_and(|pin| pin.mirror.is_some()));
            let at = PinName { layer: &names.0, pin: &names.1 };
            text = text.and_then(|text| put_pin_setting(&text, at, "weight", &setting));
        }
        let label = match (changed.len(), to_hard) {
            (1, true) => "Harden pin",
            (1, false) => "Soften pin",
            (_, true) => "Harden pins",
            (_, false) => "Soften pins",
        };
        self.change(label, text, None);
    }

    /// Returns whether the selected pins are hard; `None` if some are and others are not, or none is selected.
    #[must_use]
    pub(crate) fn are_hard(&self) -> Option<bool> {
        let mut all = self.selection.pins.iter().filter_map(|&at| self.own_pin(at)).map(is_hard);
        let first = all.next()?;
        all.all(|other| other == first).then_some(first)
    }

    /// Remembers the weight of a soft pin, for when it becomes hard and soft again.
    fn remember_soft(&mut self, at: [usize; 2]) {
        let weight = self.own_pin(at).filter(|pin| !is_hard(pin)).map(|pin| pin.weight);
        if let Some((names, weight)) = self.names_of(at).zip(weight) {
            self.soft.insert(names, weight);
        }
    }

    fn own_pin(&self, [layer, pin]: [usize; 2]) -> Option<&Pin> {
        self.document.shot().layers.get(layer)?.pins.get(pin)
    }
}

fn is_hard(pin: &Pin) -> bool {
    pin.weight >= 1.0
}

/// Returns a weight as in the file; `follows`: whether the pin follows another one, whose weight is its default.
fn setting(weight: f64, follows: bool) -> Setting {
    if weight == 1.0 && !follows { Setting::Default } else { Setting::Number(weight) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "scene = 'a.glb'
frames = { first = 1, last = 24 }
[[layer]]
name = 'a'
[[layer.pin]]
name = 'left hand'
weight = 0.25
anchor = { screen = [0.5, 0.5], frame = 1 }
[[layer.pin]]
name = 'right hand'
anchor = { screen = [0.2, 0.5], frame = 1 }
[[layer.pin]]
name = 'r'
mirror = 'left hand'
";

    fn weights(session: &Session) -> Vec<f64> {
        session.document().shot().layers[0].pins.iter().map(|pin| pin.weight).collect()
    }

    #[test]
    fn pins_become_hard_and_soft_again_with_the_weights_they_had() {
        let mut session = Session::of_text(TEXT);
        session.toggle_hard();
        assert!(session.message().is_some_and(|told| told.contains("No pin")));
        session.selection.pins.extend([[0, 0], [0, 1]]);
        assert_eq!((weights(&session), session.are_hard()), (vec![0.25, 1.0, 0.25], None));
        session.toggle_hard();
        assert_eq!((weights(&session), session.are_hard()), (vec![1.0, 1.0, 1.0], Some(true)));
        assert!(!session.document().text().contains("weight"), "1 is the default");
        session.set_hard(true);
        session.toggle_hard();
        assert_eq!((weights(&session), session.are_hard()), (vec![0.25, 0.5, 0.25], Some(false)));
        assert_eq!(session.document().history().labels().collect::<Vec<_>>(), ["Harden pin", "Soften pins"]);
        session.undo();
        session.undo();
        assert_eq!(session.document().text(), TEXT);
        session.selection.only_pin([0, 2]);
        session.toggle_hard();
        assert_eq!(weights(&session), [0.25, 1.0, 1.0], "it no longer follows the weight of the other");
        session.undo();
        // With the slider, too.
        session.selection.only_pin([0, 0]);
        session.set_weight([0, 0], 0.75);
        session.set_weight([0, 0], 1.0);
        session.toggle_hard();
        assert_eq!(weights(&session)[0], 0.75);
    }

    #[test]
    fn the_pin_on_the_other_side_becomes_as_hard() {
        let mut session = Session::of_text(TEXT);
        session.mirrors = true;
        session.selection.only_pin([0, 1]);
        session.toggle_hard();
        assert_eq!(weights(&session)[..2], [0.25, 0.5], "one is soft already");
        session.toggle_hard();
        assert_eq!(weights(&session), [1.0; 3]);
    }
}
