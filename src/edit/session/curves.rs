//! Keys as curves: what is drawn of them, and what a drag does.
//!
//! In: pins, channels, places in the curve view. Out: numbers; changes of the document, one for a drag.

use super::Session;
use crate::edit::curve::{Channel, samples, with_key_moved};
use crate::shot::PinKey;

impl Session {
    /// A curve at some times: time and number; empty: the pin has none of the kind.
    #[must_use]
    pub fn curve(&self, at: [usize; 2], channel: Channel, times: &[f64]) -> Vec<[f64; 2]> {
        samples(self.shot(), at, channel, times)
    }

    /// The keys of a pin in a channel: time and number.
    #[must_use]
    pub fn curve_keys(&self, at: [usize; 2], channel: Channel) -> Vec<[f64; 2]> {
        let lines = f64::from(self.shot().size.height);
        let pin = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1]));
        let keys = pin.into_iter().flat_map(|pin| &pin.keys);
        keys.filter_map(|key| Some([key.frame, channel.of(key, lines)?])).collect()
    }

    /// Takes rotation or scale out of all keys of a pin.
    pub fn free_channel(&mut self, at: [usize; 2], channel: Channel) {
        let Some(pin) = self.document.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let free = |key: &PinKey| match channel {
            Channel::Rotation => PinKey { rotate_degrees: None, ..*key },
            Channel::Scale => PinKey { scale: None, ..*key },
            Channel::X | Channel::Y => *key,
        };
        let keys = pin.keys.iter().map(free).collect();
        self.write_keys("Free pin", &[(at, keys)], None);
    }

    /// Gives a key another time and another number in a channel; what is done in one drag is undone at once.
    pub fn move_curve_key(&mut self, (at, from): ([usize; 2], f64), channel: Channel, [time, value]: [f64; 2]) {
        let lines = f64::from(self.shot().size.height);
        let Some(pin) = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let Some(key) = pin.keys.iter().find(|key| key.frame == from) else { return };
        // Keys do not pass each other.
        let before = pin.keys.iter().rev().find(|key| key.frame < from).map_or(f64::NEG_INFINITY, |key| key.frame);
        let after = pin.keys.iter().find(|key| key.frame > from).map_or(f64::INFINITY, |key| key.frame);
        let time = if time > before && time < after { time } else { from };
        let key = channel.put(key, value, lines);
        let keys = with_key_moved(&pin.keys, from, PinKey { frame: time, ..key });
        if self.write_keys("Move key", &[(at, keys)], Some(&format!("curve {at:?} {channel:?}"))) {
            self.selection.keys = vec![(at, time)];
        }
    }
}
