//! Editing of keys step by step, as the keyboard does: to the next key, a frame later, a little higher.
//!
//! In: a pin or handle, a direction. Out: selected keys; one document change per run of steps.

use super::Session;
use crate::edit::curve::Channel;
use crate::edit::track_keys::{KeyEdit, Track};
use crate::shot::{Goal, OffsetUnit};

/// How a step changes the selected keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeyStep {
    /// Only the next key is selected.
    #[default]
    Only,
    /// The next key is selected in addition.
    Add,
}

impl Session {
    /// Selects the next key of a pin or handle, or the previous one: from the one selected last, else from the current
    /// frame.
    pub fn step_key(&mut self, track: impl Into<Track>, forward: bool, step: KeyStep) {
        let track = track.into();
        let here = f64::from(self.playhead.frame());
        let current = self.selection.keys.iter().rev().find(|(other, _)| *other == track).map(|(_, time)| *time);
        let times = track.times(self.shot()).into_iter().map(|(time, _)| time);
        let from = current.unwrap_or(here);
        // The key of the current frame itself is the first one.
        let is_next = |time: &f64| if current.is_none() { true } else { *time != from };
        let next = match forward {
            true => times.filter(|time| *time >= from).filter(is_next).min_by(f64::total_cmp),
            false => times.filter(|time| *time <= from).filter(is_next).max_by(f64::total_cmp),
        };
        let Some(time) = next else { return };
        if step == KeyStep::Only {
            self.selection.clear();
        }
        self.selection.keys.retain(|key| *key != (track, time));
        self.choose_key(track, time, true);
        self.say(format!("Key of {}, frame {time}", track.name(self.document.shot())));
    }

    /// Moves the selected keys by a number of frames; they do not land on others. Consecutive moves are one undo step.
    pub fn nudge_keys(&mut self, by: i32) {
        let by = f64::from(by);
        let shot = self.document.shot();
        let lands = |(track, time): &(Track, f64)| {
            let is_other = |(other, _): &(f64, _)| *other == time + by && !self.selection.has_key(*track, *other);
            track.times(shot).iter().any(is_other)
        };
        if self.selection.keys.iter().any(lands) {
            return self.say("Another key is there: delete it first.");
        }
        let tracks: Vec<Track> = self.selection.keyed().into_iter().collect();
        let moved: Vec<_> = self.selection.keys.iter().map(|(track, time)| (*track, time + by)).collect();
        let series = format!("nudge keys {tracks:?}");
        if self.change_keys("Move keys", Some(&series), |keys, times| keys.edited(KeyEdit::Shift(by), times)) {
            self.selection.keys = moved;
        }
    }

    /// Raises the selected keys in a channel by a number of its smallest steps. Consecutive changes are one undo step.
    pub fn raise_keys(&mut self, channel: Channel, steps: f64) {
        let Some(&(track, _)) = self.selection.keys.last() else { return self.say("No key is selected.") };
        let (by, lines) = (steps * self.value_step(track, channel), self.lines());
        let tracks: Vec<Track> = self.selection.keyed().into_iter().collect();
        let series = format!("raise keys {tracks:?} {channel:?}");
        self.change_keys("Change keys", Some(&series), |keys, times| keys.raised(times, channel, (by, lines)));
    }

    /// Returns the smallest step of a channel: a pixel, a degree, a hundredth of a scene's unit or factor, a thousandth
    /// of the lattice's box.
    fn value_step(&self, track: Track, channel: Channel) -> f64 {
        let keys = match track {
            Track::Handle(_) => return 0.1,
            Track::Pin([layer, pin]) => self.shot().layers.get(layer).and_then(|layer| layer.pins.get(pin)),
        };
        let is_on_screen = keys.is_some_and(|pin| {
            let goal = pin.keys.first().map(|key| key.goal);
            pin.unit == OffsetUnit::Frame && matches!(goal, Some(Goal::Offset(_) | Goal::Target(_)))
        });
        match channel {
            Channel::Scale => 0.01,
            Channel::Rotation => 1.0,
            Channel::X | Channel::Y | Channel::Z if is_on_screen => 1.0,
            Channel::X | Channel::Y | Channel::Z => 0.01,
        }
    }
}
