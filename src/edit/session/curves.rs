//! The curve view's data, and the effect of drags in it.
//!
//! In: pins, channels, positions in the curve view. Out: values; one document change per drag.

use super::Session;
use crate::edit::curve::{Channel, Tangent, bent, samples, tangents, with_key_moved};
use crate::shot::PinKey;

impl Session {
    /// Samples a curve at some times as (time, value); empty if the pin does not use the channel.
    #[must_use]
    pub fn curve(&self, at: [usize; 2], channel: Channel, times: &[f64]) -> Vec<[f64; 2]> {
        samples(self.shot(), at, channel, times)
    }

    /// Returns the keys of a pin in a channel as (time, value).
    #[must_use]
    pub fn curve_keys(&self, at: [usize; 2], channel: Channel) -> Vec<[f64; 2]> {
        let lines = f64::from(self.shot().size.height);
        let pin = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1]));
        let keys = pin.into_iter().flat_map(|pin| &pin.keys);
        keys.filter_map(|key| Some([key.frame, channel.of(key, lines)?])).collect()
    }

    /// Returns the tangents of a pin's selected keys.
    #[must_use]
    pub fn tangents(&self, at: [usize; 2], channel: Channel) -> Vec<Tangent> {
        let lines = f64::from(self.shot().size.height);
        let pin = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1]));
        pin.map_or_else(Vec::new, |pin| tangents(&pin.keys, &self.selection.times_of(at), channel, lines))
    }

    /// Moves the end of a tangent to (time, value).
    pub fn bend_curve(&mut self, at: [usize; 2], tangent: (f64, usize), channel: Channel, to: [f64; 2]) {
        let lines = f64::from(self.shot().size.height);
        let Some(pin) = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let Some(ease) = bent(&pin.keys, tangent, channel, (to, lines)) else { return };
        let change = |key: &PinKey| if key.frame == tangent.0 { PinKey { ease, ..*key } } else { *key };
        let keys = pin.keys.iter().map(change).collect();
        self.write_keys("Bend curve", &[(at, keys)], Some(&format!("bend {at:?} {tangent:?}")));
    }

    /// Removes rotation or scale from all keys of a pin.
    pub fn free_channel(&mut self, at: [usize; 2], channel: Channel) {
        let Some(pin) = self.document.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let free = |key: &PinKey| match channel {
            Channel::Rotation => PinKey { rotate_degrees: None, ..*key },
            Channel::Scale => PinKey { scale: None, ..*key },
            Channel::X | Channel::Y | Channel::Z => *key,
        };
        let keys = pin.keys.iter().map(free).collect();
        self.write_keys("Free pin", &[(at, keys)], None);
    }

    /// Moves a key to another time and value in a channel; one drag is one undo step.
    pub fn move_curve_key(&mut self, (at, from): ([usize; 2], f64), channel: Channel, [time, value]: [f64; 2]) {
        let lines = f64::from(self.shot().size.height);
        let Some(pin) = self.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let Some(key) = pin.keys.iter().find(|key| key.frame == from) else { return };
        // Keys cannot pass each other.
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
