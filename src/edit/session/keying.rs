//! Editing of keys in the timeline: select, move, copy, ease, delete, type.
//!
//! In: user commands. Out: one document change each.

use super::handles::axes_of;
use super::{Purpose, Session};
use crate::edit::track::{KeyEdit, key_at, key_time, with_key};
use crate::shot::edit::{PinName, Setting, put_handle, put_keys};
use crate::shot::{Ease, PinKey};
use std::collections::BTreeSet;

/// Named eases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EasePreset {
    /// Holds the value until the next key.
    Hold,
    /// Linear interpolation.
    Linear,
    /// Ease in and out.
    Smooth,
    /// Decelerates: fast, then slow.
    Out,
    /// Accelerates: slow, then fast.
    In,
    /// Overshoots the next key and returns.
    Overshoot,
}

impl EasePreset {
    /// All presets.
    pub(crate) const ALL: [Self; 6] = [Self::Hold, Self::Linear, Self::Smooth, Self::In, Self::Out, Self::Overshoot];

    /// Returns the ease as in a shot.
    #[must_use]
    pub const fn ease(self) -> Ease {
        match self {
            Self::Hold => Ease::Hold,
            Self::Linear => Ease::Linear,
            Self::Smooth => Ease::Smooth,
            Self::Out => Ease::Bezier([0.0, 0.0, 0.2, 1.0]),
            Self::In => Ease::Bezier([0.8, 0.0, 1.0, 1.0]),
            Self::Overshoot => Ease::Bezier([0.3, 0.0, 0.4, 1.4]),
        }
    }

    /// Returns the display name.
    #[must_use]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Hold => "Hold",
            Self::Linear => "Linear",
            Self::Smooth => "Smooth",
            Self::Out => "Ease out",
            Self::In => "Ease in",
            Self::Overshoot => "Overshoot",
        }
    }

    /// Returns the preset of an ease; `None` for a custom curve.
    #[must_use]
    pub(crate) fn of(ease: Ease) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.ease() == ease)
    }
}

impl Session {
    /// Sets keys on the selected pins from their state at the current frame.
    pub fn insert_keys(&mut self) {
        let (shot, frame) = (self.document.shot(), self.playhead.frame());
        let key = |&at: &[usize; 2]| {
            let layer = shot.layers.get(at[0])?;
            let key = key_at(shot, at, key_time(&shot.frames, layer, frame))?;
            Some((at, with_key(&layer.pins.get(at[1])?.keys, key)))
        };
        let keys: Vec<_> = self.selection.pins.iter().filter_map(key).collect();
        if keys.is_empty() {
            return self.say("No pin is selected: click one first.");
        }
        self.write_keys("Insert key", &keys, None);
    }

    /// Sets a key of a pin from typed values.
    pub fn put_key(&mut self, at: [usize; 2], key: PinKey) {
        let Some(pin) = self.document.shot().layers.get(at[0]).and_then(|layer| layer.pins.get(at[1])) else { return };
        let keys = with_key(&pin.keys, key);
        self.write_keys("Type key", &[(at, keys)], Some(&format!("type {at:?}")));
    }

    /// Returns the interpolated key of a pin at the current frame.
    #[must_use]
    pub(crate) fn key_here(&self, at: [usize; 2]) -> Option<PinKey> {
        let shot = self.shot();
        key_at(shot, at, key_time(&shot.frames, shot.layers.get(at[0])?, self.playhead.frame()))
    }

    /// Returns whether a pin has a key at the current frame.
    #[must_use]
    pub(crate) fn has_key_here(&self, at: [usize; 2]) -> bool {
        let shot = self.shot();
        let pin = shot.layers.get(at[0]).and_then(|layer| layer.pins.get(at[1]));
        let key = self.key_here(at);
        pin.zip(key).is_some_and(|(pin, key)| pin.keys.iter().any(|other| other.frame == key.frame))
    }

    /// Selects a key; with `adds`, toggles it and keeps the other keys selected.
    pub fn choose_key(&mut self, at: [usize; 2], time: f64, adds: bool) {
        let is_chosen = self.selection.has_key(at, time);
        if !adds && !is_chosen {
            self.selection.only_pin(at);
        }
        if adds && is_chosen {
            self.selection.keys.retain(|key| *key != (at, time));
        } else if !is_chosen {
            self.selection.pins.insert(at);
            self.selection.keys.push((at, time));
        }
    }

    /// Selects a key of a handle; with `adds`, toggles it and keeps the other keys selected.
    pub fn choose_handle_key(&mut self, at: (usize, [usize; 3]), time: f64, adds: bool) {
        let is_chosen = self.selection.handle_keys.contains(&(at, time));
        if !adds && !is_chosen {
            self.selection.clear();
            self.selection.layer = at.0;
        }
        if adds && is_chosen {
            self.selection.handle_keys.retain(|key| *key != (at, time));
        } else if !is_chosen {
            self.selection.handles.insert(at);
            self.selection.handle_keys.push((at, time));
        }
    }

    /// Changes the selected keys of all pins and handles at once.
    fn change_keys(&mut self, label: &str, edit: KeyEdit) -> bool {
        if !self.selection.has_keys() {
            return false;
        }
        let shot = self.document.shot();
        let pins: BTreeSet<[usize; 2]> = self.selection.keys.iter().map(|(at, _)| *at).collect();
        let handles: BTreeSet<(usize, [usize; 3])> = self.selection.handle_keys.iter().map(|(at, _)| *at).collect();
        if let Some(message) = pins.iter().find_map(|&at| self.follows(at)) {
            self.say(message);
            return false;
        }
        let mut text = Ok(self.document.text().to_owned());
        for at in pins {
            let Some(owner) = shot.layers.get(at[0]) else { continue };
            let Some(pin) = owner.pins.get(at[1]) else { continue };
            let keys = edit.apply(&pin.keys, &self.selection.times_of(at));
            let name = PinName { layer: &owner.name, pin: &pin.name };
            text = text.and_then(|text| put_keys(&text, name, &keys));
        }
        for at in handles {
            let Some(owner) = shot.layers.get(at.0) else { continue };
            let Some(track) = owner.handles.iter().find(|track| track.index == at.1) else { continue };
            let keys = edit.apply(&track.keys, &self.selection.times_of_handle(at));
            text = text.and_then(|text| put_handle(&text, &owner.name, axes_of(owner.space, &at.1), &keys));
        }
        self.change(label, text, None)
    }

    /// Deletes the selected keys; the last key of a pin or handle is kept.
    pub fn delete_keys(&mut self) {
        self.change_keys("Delete keys", KeyEdit::Remove);
    }

    /// Moves the selected keys by a number of frames.
    pub fn shift_keys(&mut self, by: i32) {
        if by == 0 {
            return;
        }
        let by = f64::from(by);
        let pins: Vec<_> = self.selection.keys.iter().map(|(at, time)| (*at, time + by)).collect();
        let handles: Vec<_> = self.selection.handle_keys.iter().map(|(at, time)| (*at, time + by)).collect();
        if self.change_keys("Move keys", KeyEdit::Shift(by)) {
            (self.selection.keys, self.selection.handle_keys) = (pins, handles);
        }
    }

    /// Sets the ease of the selected keys, or of all keys of the selected pins and handles if no key is selected.
    pub fn ease_keys(&mut self, preset: EasePreset) {
        if !self.selection.has_keys() {
            let shot = self.document.shot();
            let of = |at: [usize; 2]| shot.layers[at[0]].pins[at[1]].keys.iter().map(move |key| (at, key.frame));
            let of_handle = |at: (usize, [usize; 3])| {
                let tracks = shot.layers[at.0].handles.iter().filter(move |track| track.index == at.1);
                tracks.flat_map(move |track| track.keys.iter().map(move |key| (at, key.frame)))
            };
            let keys: Vec<_> = self.selection.pins.iter().copied().flat_map(of).collect();
            let handle_keys: Vec<_> = self.selection.handles.iter().copied().flat_map(of_handle).collect();
            (self.selection.keys, self.selection.handle_keys) = (keys, handle_keys);
        }
        self.change_keys(&format!("{} keys", preset.name()), KeyEdit::Ease(preset.ease()));
    }

    /// Goes to the next or previous key of the selected pins, or of the layer's if no pin is selected.
    pub(crate) fn go_to_key(&mut self, forward: bool) {
        let (shot, here) = (self.document.shot(), f64::from(self.playhead.frame()));
        let layer = self.selection.layer;
        let is_wanted = |at: [usize; 2]| match self.selection.pins.is_empty() {
            true => at[0] == layer,
            false => self.selection.pins.contains(&at),
        };
        let times = shot.layers.iter().enumerate().flat_map(|(layer, owner)| {
            let pins = owner.pins.iter().enumerate().filter(move |(pin, _)| is_wanted([layer, *pin]));
            pins.flat_map(|(_, pin)| pin.keys.iter().map(|key| key.frame))
        });
        let next = match forward {
            true => times.filter(|time| *time > here).min_by(f64::total_cmp),
            false => times.filter(|time| *time < here).max_by(f64::total_cmp),
        };
        if let Some(time) = next {
            self.go(time.round() as i32);
        }
    }

    /// Sets for how many frames each drawing is held.
    pub(crate) fn set_exposure(&mut self, step: u32) {
        let setting = if step == 1 { Setting::Default } else { Setting::Whole(i64::from(step)) };
        self.set_layer("Change exposure", &["step"], &setting, None);
    }

    /// Goes to the frame with the worst value of a figure among those solved.
    pub(crate) fn go_to_worst(&mut self, figure: impl Fn(&crate::pipeline::FrameReport) -> Option<f64>) {
        let known = self.solves.values().filter_map(|solve| Some((figure(&solve.report)?, solve.frame)));
        if let Some((_, frame)) = known.max_by(|a, b| a.0.total_cmp(&b.0)) {
            self.playhead.go(frame);
            self.frame_changed(Purpose::Look);
        }
    }
}
