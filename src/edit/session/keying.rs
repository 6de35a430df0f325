//! Editing of keys in the timeline: select, move, copy, ease, delete, type.
//!
//! In: user commands. Out: one document change each.

use super::Session;
use crate::edit::channel_keys::{rotate_key_at, scale_key_at};
use crate::edit::track::{handle_key_at, key_at, key_time, pose_at, with_handle_key};
use crate::edit::track_keys::{KeyEdit, Track, TrackKeys, axes_of, with_key};
use crate::shot::edit::{PinName, Setting, put_handle, put_keys, put_rotate_keys, put_scale_keys};
use crate::shot::{ChannelKey, Ease, PinKey, Shot};

/// Named eases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EasePreset {
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
    pub(crate) const fn ease(self) -> Ease {
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
    /// Sets keys on the selected pins and handles from their state at the current frame.
    pub(crate) fn insert_keys(&mut self) {
        let tracks = self.selection.tracks(self.document.shot()).into_iter();
        let keys: Vec<_> = tracks.filter_map(|track| self.keyed_here(track)).collect();
        if keys.is_empty() {
            return self.say("No pin is selected: click one first.");
        }
        self.write_keys("Insert key", &keys, None);
    }

    /// Returns the keys of a pin or handle with one at the current frame, which changes nothing there.
    fn keyed_here(&self, track: Track) -> Option<(Track, TrackKeys)> {
        let shot = self.document.shot();
        let layer = shot.layers.get(track.layer())?;
        let time = key_time(&shot.frames, layer, self.playhead.frame());
        let keys = match track {
            Track::Pin(at) => TrackKeys::Pin(with_key(&track.own_pin(shot)?.keys, key_at(shot, at, time)?)),
            Track::Rotation(_) => {
                let pin = track.own_pin(shot)?;
                TrackKeys::Rotation(with_key(&pin.rotate_keys, rotate_key_at(pin, time)?))
            }
            Track::Scale(_) => {
                let pin = track.own_pin(shot)?;
                TrackKeys::Scale(with_key(&pin.scale_keys, scale_key_at(pin, time)?))
            }
            Track::Handle(at) => {
                let own = layer.handles.iter().find(|handle| handle.index == at.1);
                TrackKeys::Handle(with_handle_key(own, f64::from(shot.frames.first), handle_key_at(shot, at, time)?))
            }
        };
        Some((track, keys))
    }

    /// Sets a key of a pin from typed values. Of a pin whose rotation or scale has keys of its own, only what differs is set.
    pub(crate) fn put_key(&mut self, at: [usize; 2], key: PinKey) {
        let ready = self.ready_to_type(at, key);
        let held = pose_at(&ready, at, key.frame);
        let key = PinKey {
            rotate_degrees: key.rotate_degrees.or(held.and_then(|held| held.rotate_degrees)),
            scale: key.scale.or(held.and_then(|held| held.scale)),
            ..key
        };
        let mut keys = typed(&ready, at, key);
        // What holds other frames comes with the first key of a channel.
        for track in Track::of_pin(&ready, at) {
            let is_typed = keys.iter().any(|(other, _)| *other == track);
            let first =
                track.keys(&ready).filter(|own| !is_typed && track.keys(self.document.shot()).as_ref() != Some(own));
            keys.extend(first.map(|own| (track, own)));
        }
        if !keys.is_empty() {
            self.write_keys("Type key", &keys, Some(&format!("type {at:?}")));
        }
    }

    /// Returns the interpolated values of a pin at the current frame, as a key.
    #[must_use]
    pub(crate) fn key_here(&self, at: [usize; 2]) -> Option<PinKey> {
        let shot = self.shot();
        pose_at(shot, at, key_time(&shot.frames, shot.layers.get(at[0])?, self.playhead.frame()))
    }

    /// Returns whether a pin has a key at the current frame, in any channel.
    #[must_use]
    pub(crate) fn has_key_here(&self, at: [usize; 2]) -> bool {
        let pin = Track::Pin(at).own_pin(self.shot());
        pin.zip(self.key_here(at)).is_some_and(|(pin, key)| pin.key_frames().any(|frame| frame == key.frame))
    }

    /// Selects a key; with `adds`, toggles it and keeps the other keys selected.
    pub(crate) fn choose_key(&mut self, track: impl Into<Track>, time: f64, adds: bool) {
        let track = track.into();
        let is_chosen = self.selection.has_key(track, time);
        if !adds && !is_chosen {
            self.selection.clear();
        }
        if adds && is_chosen {
            self.selection.keys.retain(|key| *key != (track, time));
        } else if !is_chosen {
            self.selection.add(track);
            self.selection.keys.push((track, time));
        }
    }

    /// Changes the selected keys of all pins and handles at once.
    pub(super) fn change_keys(
        &mut self,
        label: &str,
        series: Option<&str>,
        edit: impl Fn(&TrackKeys, &[f64]) -> TrackKeys,
    ) -> bool {
        let shot = self.document.shot();
        let changed = |track: Track| Some((track, edit(&track.keys(shot)?, &self.selection.times_of(track))));
        let keys: Vec<_> = self.selection.keyed().into_iter().filter_map(changed).collect();
        !keys.is_empty() && self.write_keys(label, &keys, series)
    }

    /// Writes the keys of pins, channels and handles.
    pub(super) fn write_keys(&mut self, label: &str, keys: &[(Track, TrackKeys)], series: Option<&str>) -> bool {
        let follows = |(track, _): &(Track, TrackKeys)| self.follows(track.pin()?);
        if let Some(message) = keys.iter().find_map(follows) {
            self.say(message);
            self.let_go();
            return false;
        }
        let mut text = Ok(self.document.text().to_owned());
        for (track, keys) in keys {
            let Some(owner) = self.document.shot().layers.get(track.layer()) else { continue };
            let pin = track.own_pin(self.document.shot());
            let at = pin.map(|pin| PinName { layer: &owner.name, pin: &pin.name });
            text = match (track, keys, at) {
                (Track::Pin(_), TrackKeys::Pin(keys), Some(at)) => text.and_then(|text| put_keys(&text, at, keys)),
                (Track::Rotation(_), TrackKeys::Rotation(keys), Some(at)) => {
                    text.and_then(|text| put_rotate_keys(&text, at, keys))
                }
                (Track::Scale(_), TrackKeys::Scale(keys), Some(at)) => {
                    text.and_then(|text| put_scale_keys(&text, at, keys))
                }
                (Track::Handle((_, index)), TrackKeys::Handle(keys), _) => {
                    text.and_then(|text| put_handle(&text, &owner.name, axes_of(owner.space, index), keys))
                }
                _ => continue,
            };
        }
        self.change(label, text, series)
    }

    /// Deletes the selected keys; the last key of a pin or handle is kept.
    pub(crate) fn delete_keys(&mut self) {
        if self.selection.keys.is_empty() {
            return self.say("No key is selected: click one in the timeline first.");
        }
        self.change_keys("Delete keys", None, |keys, times| keys.edited(KeyEdit::Remove, times));
    }

    /// Moves the selected keys by a number of frames.
    pub(crate) fn shift_keys(&mut self, by: i32) {
        if by == 0 {
            return;
        }
        let by = f64::from(by);
        let moved: Vec<_> = self.selection.keys.iter().map(|(track, time)| (*track, time + by)).collect();
        if self.change_keys("Move keys", None, |keys, times| keys.edited(KeyEdit::Shift(by), times)) {
            self.selection.keys = moved;
        }
    }

    /// Returns the eases of the selected keys, or of all keys of the selected pins and handles if no key is selected, each once.
    #[must_use]
    pub(crate) fn chosen_eases(&self) -> Vec<Ease> {
        let (shot, keys) = (self.shot(), &self.selection.keys);
        let is_chosen = |track: Track, time: f64| keys.is_empty() || keys.contains(&(track, time));
        let tracks = self.selection.tracks(shot).into_iter();
        let own = tracks.flat_map(|track| track.times(shot).into_iter().map(move |(time, ease)| (track, time, ease)));
        let mut found = Vec::new();
        for (_, _, ease) in own.filter(|&(track, time, _)| is_chosen(track, time)) {
            if !found.contains(&ease) {
                found.push(ease);
            }
        }
        found
    }

    /// Sets the ease of the selected keys, or of all keys of the selected pins and handles if no key is selected.
    pub(crate) fn ease_keys(&mut self, preset: EasePreset) {
        if self.selection.keys.is_empty() {
            let shot = self.document.shot();
            let times = |track: Track| track.times(shot).into_iter().map(move |(time, _)| (track, time));
            self.selection.keys = self.selection.tracks(shot).into_iter().flat_map(times).collect();
        }
        if self.selection.keys.is_empty() {
            return self.say("No key is selected: click one in the timeline, or a pin, first.");
        }
        let label = format!("{} keys", preset.name());
        self.change_keys(&label, None, |keys, times| keys.edited(KeyEdit::Ease(preset.ease()), times));
    }

    /// Returns the selected pins and handles, or all of the selected layer if none is selected.
    #[must_use]
    pub(crate) fn tracks_of_interest(&self) -> Vec<Track> {
        let chosen = self.selection.tracks(self.shot());
        if chosen.is_empty() { self.tracks() } else { chosen }
    }

    /// Returns the pins of the selected layer, each with its channels that have keys of their own, then its handles that have keys.
    #[must_use]
    pub(crate) fn tracks(&self) -> Vec<Track> {
        let layer = self.selection.layer;
        let Some(owner) = self.shot().layers.get(layer) else { return Vec::new() };
        let pins = (0..owner.pins.len()).flat_map(|pin| Track::of_pin(self.shot(), [layer, pin]));
        pins.chain(owner.handles.iter().map(|own| Track::Handle((layer, own.index)))).collect()
    }

    /// Goes to the next or previous key of the selected pins and handles, or of the layer's if none is selected.
    pub(crate) fn go_to_key(&mut self, forward: bool) {
        let (shot, here) = (self.document.shot(), f64::from(self.playhead.frame()));
        let times = self.tracks_of_interest().into_iter().flat_map(|track| track.times(shot)).map(|(time, _)| time);
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
}

/// Returns the keys that typed values change.
fn typed(shot: &Shot, at: [usize; 2], key: PinKey) -> Vec<(Track, TrackKeys)> {
    let (Some(pin), mut rest, mut found) = (Track::Pin(at).own_pin(shot), key, Vec::new()) else { return Vec::new() };
    if let Some(own) = rotate_key_at(pin, key.frame) {
        let value = rest.rotate_degrees.take().unwrap_or(own.value);
        if value != own.value {
            let keys = with_key(&pin.rotate_keys, ChannelKey { value, ..own });
            found.push((Track::Rotation(at), TrackKeys::Rotation(keys)));
        }
    }
    if let Some(own) = scale_key_at(pin, key.frame) {
        let value = rest.scale.take().unwrap_or(own.value);
        if value != own.value {
            let keys = with_key(&pin.scale_keys, ChannelKey { value, ..own });
            found.push((Track::Scale(at), TrackKeys::Scale(keys)));
        }
    }
    if found.is_empty() || key_at(shot, at, key.frame) != Some(rest) {
        found.push((Track::Pin(at), TrackKeys::Pin(with_key(&pin.keys, rest))));
    }
    found
}
