//! First keys of a rotation or scale that was free: what the keyed frames show, as the worker found it.
//!
//! In: answers of the worker. Out: shots in which the other keyed frames keep what they show.

use super::Session;
use crate::edit::first_keys::{FreeChannel, KeyedTimes, SeenTurn, with_first_keys};
use crate::edit::track::{AutoKey, Move, key_time};
use crate::edit::worker::Question;
use crate::pipeline::PinTurn;
use crate::shot::{PinKey, Rotation, Shot};
use std::borrow::Cow;
use std::collections::BTreeSet;

/// How pins are turned in keyed frames of the document as it is.
#[derive(Clone, Debug, Default)]
pub(super) struct KeyedTurns {
    /// Returned with the answers: those about earlier documents do not count.
    id: u64,
    /// The layers and frames that were asked about.
    asked: BTreeSet<(usize, i32)>,
    /// Layers, times, pins.
    known: Vec<(usize, f64, PinTurn)>,
}

impl KeyedTurns {
    /// Forgets what was known of another document.
    pub(super) fn clear(&mut self) {
        *self = Self { id: self.id + 1, ..Self::default() };
    }
}

impl Session {
    /// Asks how the pins of a layer are turned in this frame and in keyed ones, unless that is known or this pin has keys of its
    /// rotation and scale.
    pub(super) fn want_turns(&mut self, [layer, pin]: [usize; 2]) {
        let frame = self.playhead.frame();
        let Some(own) = self.document.shot().layers.get(layer).and_then(|layer| layer.pins.get(pin)) else { return };
        let is_turned = !own.rotate_keys.is_empty() || own.keys.iter().any(|key| key.rotate_degrees.is_some());
        let is_scaled = !own.scale_keys.is_empty() || own.keys.iter().any(|key| key.scale.is_some());
        if !(is_turned && is_scaled) && self.turns.asked.insert((layer, frame)) {
            self.worker.ask(Question::KeyedTurns { id: self.turns.id, frame, layer });
        }
    }

    /// As [`Self::want_turns`], once the frame is shown as rendered: the numbers of a pin may be typed.
    pub(crate) fn want_turns_when_drawn(&mut self, at: [usize; 2]) {
        if self.is_final() && !self.is_dragging() {
            self.want_turns(at);
        }
    }

    /// Takes an answer about turns.
    pub(super) fn take_turns(&mut self, id: u64, layer: usize, turns: Vec<(f64, Vec<PinTurn>)>) {
        if id == self.turns.id {
            let of_time = |(time, pins): (f64, Vec<PinTurn>)| pins.into_iter().map(move |pin| (layer, time, pin));
            self.turns.known.extend(turns.into_iter().flat_map(of_time));
        }
    }

    /// Returns how the surroundings of a pin are turned at the time of its keys, if that is known. The last answer counts.
    fn seen_turn(&self, at: [usize; 2], time: f64) -> Option<SeenTurn> {
        let is_this = |(layer, known, pin): &&(usize, f64, PinTurn)| [*layer, pin.pin] == at && *known == time;
        let (.., PinTurn { angle, scale, .. }) = self.turns.known.iter().rev().find(is_this)?;
        Some(SeenTurn { degrees: angle.to_degrees(), scale: *scale })
    }

    /// Returns a shot in which a gesture that turns or scales a free pin finds keys that hold what keyed frames show.
    pub(super) fn ready_to_turn<'s>(&self, shot: &'s Shot, at: [usize; 2], change: Move) -> Cow<'s, Shot> {
        let channel = match change {
            Move::By(_) => return Cow::Borrowed(shot),
            Move::Turn(_) => FreeChannel::Rotation,
            Move::TurnAbout(..) => FreeChannel::Axes,
            Move::Grow(_) => FreeChannel::Scale,
        };
        let times = match self.auto_key {
            AutoKey::On => KeyedTimes::Layer(key_time(&shot.frames, &shot.layers[at[0]], self.playhead.frame())),
            AutoKey::Off => KeyedTimes::Own,
        };
        self.with_first_keys(shot, at, (channel, times))
    }

    /// Returns the document's shot with first keys of the channels that a typed key is the first to set.
    pub(super) fn ready_to_type(&self, at: [usize; 2], key: PinKey) -> Cow<'_, Shot> {
        let (shot, times) = (self.document.shot(), KeyedTimes::Layer(key.frame));
        let turned = match key.rotate_degrees {
            None => Cow::Borrowed(shot),
            Some(Rotation::InView(_)) => self.with_first_keys(shot, at, (FreeChannel::Rotation, times)),
            Some(Rotation::Axes(_)) => self.with_first_keys(shot, at, (FreeChannel::Axes, times)),
        };
        match key.scale {
            None => turned,
            Some(_) => Cow::Owned(self.with_first_keys(&turned, at, (FreeChannel::Scale, times)).into_owned()),
        }
    }

    fn with_first_keys<'s>(&self, shot: &'s Shot, at: [usize; 2], of: (FreeChannel, KeyedTimes)) -> Cow<'s, Shot> {
        let Some(pin) = with_first_keys(shot, at, of, |time| self.seen_turn(at, time)) else {
            return Cow::Borrowed(shot);
        };
        let mut ready = shot.clone();
        ready.layers[at[0]].pins[at[1]] = pin;
        Cow::Owned(ready)
    }
}
