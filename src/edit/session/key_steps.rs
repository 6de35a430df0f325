//! Editing of keys step by step, as the keyboard does: to the next key, a frame later, a little higher.
//!
//! In: a pin or handle, a direction. Out: selected keys; one document change per run of steps.

use super::Session;
use crate::edit::curve::{Channel, CurveAxis, is_in_boxes};
use crate::edit::track_keys::{KeyEdit, Track};
use crate::shot::{Goal, OffsetUnit};

/// How a step changes the selected keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum KeyStep {
    /// Only the next key is selected.
    #[default]
    Only,
    /// The next key is selected in addition.
    Add,
}

impl Session {
    /// Selects the next key of a pin or handle, or the previous one: from the one selected last, else from the current
    /// frame.
    pub(crate) fn step_key(&mut self, track: impl Into<Track>, forward: bool, step: KeyStep) {
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
    pub(crate) fn nudge_keys(&mut self, by: i32) {
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
    pub(crate) fn raise_keys(&mut self, channel: Channel, steps: f64) {
        let Some(&(track, _)) = self.selection.keys.last() else { return self.say("No key is selected.") };
        let by = steps * self.unit_of(track, channel).step();
        let tracks: Vec<Track> = self.selection.keyed().into_iter().collect();
        let series = format!("raise keys {tracks:?} {channel:?}");
        let axis = CurveAxis::of(self.shot(), track, channel);
        self.change_keys("Change keys", Some(&series), |keys, times| keys.raised(times, axis, by));
    }

    /// Returns the unit in which a channel of a pin or handle is shown.
    #[must_use]
    pub(crate) fn unit_of(&self, track: Track, channel: Channel) -> CurveUnit {
        if track.pin().is_none() {
            return CurveUnit::Percent;
        }
        let pin = track.own_pin(self.shot());
        let key = pin.and_then(|pin| Some((pin.unit, pin.keys.first()?.goal)));
        match (channel, key) {
            (Channel::Scale, _) => CurveUnit::Factor,
            _ if channel.is_rotation() => CurveUnit::Degrees,
            _ if pin.is_some_and(is_in_boxes) => CurveUnit::Percent,
            (_, Some((_, Goal::SceneTarget(_)) | (OffsetUnit::Frame, Goal::SceneOffset(_)))) => CurveUnit::Metres,
            (_, Some((OffsetUnit::Box, Goal::SceneOffset(_)))) => CurveUnit::Boxes,
            _ => CurveUnit::Pixels,
        }
    }
}

/// The unit of a curve's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CurveUnit {
    /// Pixels of the frame.
    Pixels,
    /// Metres of the scene.
    Metres,
    /// Sizes of the lattice's box.
    Boxes,
    /// Hundredths of the size of the lattice's box.
    Percent,
    Degrees,
    Factor,
}

impl CurveUnit {
    /// Returns the amount by which a press of an arrow key changes a value.
    pub(crate) const fn step(self) -> f64 {
        match self {
            Self::Pixels | Self::Degrees => 1.0,
            Self::Percent => 0.1,
            Self::Metres | Self::Boxes | Self::Factor => 0.01,
        }
    }

    /// Returns the display name; empty for factors.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Pixels => "px",
            Self::Metres => "m",
            Self::Boxes => "of the box",
            Self::Percent => "% of the box",
            Self::Degrees => "\u{b0}",
            Self::Factor => "",
        }
    }
}
