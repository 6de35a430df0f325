//! Copy and paste of keys, for one pin or handle or several.
//!
//! In: selected keys; selected pins and handles, and the current frame. Out: one document change.

use super::Session;
use crate::edit::track::{key_time, with_handle_key};
use crate::edit::track_keys::{Track, TrackKeys};
use crate::shot::{ChannelKey, HandleKey, PinKey, Shot};
use crate::spelling::pluralised;

/// The copied keys of one pin or handle, or of a channel with keys of its own.
#[derive(Clone, Debug)]
pub(super) struct Copied {
    track: Track,
    /// The display name of the track.
    name: String,
    keys: TrackKeys,
}

impl Copied {
    /// Returns whether its keys fit a pin, channel or handle.
    const fn fits(&self, track: Track) -> bool {
        matches!(
            (self.track, track),
            (Track::Pin(_), Track::Pin(_))
                | (Track::Rotation(_), Track::Rotation(_))
                | (Track::Scale(_), Track::Scale(_))
                | (Track::Handle(_), Track::Handle(_))
        )
    }

    /// Returns whether it is of the same pin or handle.
    fn is_beside(&self, other: &Self) -> bool {
        self.track == other.track || self.track.pin().is_some() && self.track.pin() == other.track.pin()
    }
}

impl Session {
    /// Copies the selected keys; if there are none, those of the selected pins and handles in the current frame.
    pub(crate) fn copy_keys(&mut self) {
        let shot = self.document.shot();
        let frame = self.playhead.frame();
        let copy = |(track, times): (Track, Vec<f64>)| {
            let keys = track.keys(shot)?.only(&times);
            (!keys.times().is_empty()).then(|| Copied { track, name: track.name(shot), keys })
        };
        let selected = self.selection.keyed().into_iter().map(|track| (track, self.selection.times_of(track)));
        let mut copied: Vec<Copied> = selected.filter_map(copy).collect();
        if copied.is_empty() {
            let in_frame = |track: Track| (track, vec![key_time(&shot.frames, &shot.layers[track.layer()], frame)]);
            copied = self.selection.tracks(shot).into_iter().map(in_frame).filter_map(copy).collect();
        }
        if copied.is_empty() {
            return self
                .say("No key is selected: click one in the timeline, or select pins that have keys in this frame.");
        }
        self.copied = copied;
        let count: usize = self.copied.iter().map(|copied| copied.keys.times().len()).sum();
        self.say(format!("Copied {}", pluralised(count, "key", "keys")));
    }

    /// Pastes the copied keys into the selected pins and handles, the first key at the current frame. Keys of several
    /// go to those of the same names, in the selected layer if none is selected; those without a match receive them
    /// in order.
    pub(crate) fn paste_keys(&mut self) {
        let times = self.copied.iter().flat_map(|copied| copied.keys.times());
        let Some(first) = times.map(|(time, _)| time).min_by(f64::total_cmp) else {
            return self.say("Nothing was copied.");
        };
        let chosen = self.selection.tracks(self.document.shot());
        let is_of_one = self.copied.windows(2).all(|pair| pair[0].is_beside(&pair[1]));
        let receivers = match (chosen.is_empty(), is_of_one) {
            (true, true) => Vec::new(),
            (true, _) => self.receivers(),
            (false, _) => chosen,
        };
        if receivers.is_empty() {
            return self.say("No pin or handle is selected: click one first.");
        }
        let shot = self.document.shot();
        let pairs = owners(shot, &receivers, &self.copied);
        let is_pasted = |copied: &Copied| pairs.iter().any(|(_, pasted)| std::ptr::eq(*pasted, copied));
        // A channel goes with its pin, or nothing does.
        let is_lost = |copied: &&Copied| {
            let is_wanted = || self.copied.iter().any(|other| other.is_beside(copied) && is_pasted(other));
            !is_pasted(copied) && (is_wanted() || !receivers.iter().any(|track| copied.fits(*track)))
        };
        let lost = self.copied.iter().filter(is_lost).find_map(|copied| copied.track.channel_name());
        if let Some(channel) = lost {
            return self
                .say(format!("No selected pin has keys of its {channel} alone: key its {channel} separately first."));
        }
        let paste = |(track, copied): (Track, &Copied)| {
            let layer = shot.layers.get(track.layer())?;
            let by = key_time(&shot.frames, layer, self.playhead.frame()) - first;
            Some(pasted(shot, track, (&copied.keys, by)))
        };
        let keys: Vec<_> = pairs.iter().copied().filter_map(paste).flatten().collect();
        if keys.is_empty() {
            return self.say("No selected pin or handle has the name of one whose keys were copied.");
        }
        self.write_keys("Paste keys", &keys, None);
    }

    /// Returns what can receive keys without being selected: all of the layer, with handles that rest.
    fn receivers(&self) -> Vec<Track> {
        let layer = self.selection.layer;
        let Some(owner) = self.document.shot().layers.get(layer) else { return Vec::new() };
        let has = |index: &[usize; 3]| (0..3).all(|axis| index[axis] < owner.space.dims()[axis]);
        let copied = self.copied.iter().filter_map(|copied| match copied.track {
            Track::Handle((_, index)) if has(&index) => Some(Track::Handle((layer, index))),
            _ => None,
        });
        let pins = (0..owner.pins.len()).flat_map(|pin| Track::of_pin(self.document.shot(), [layer, pin]));
        pins.chain(copied).collect()
    }
}

/// Returns the keys of a pin or handle with those that are pasted; a handle without keys rests in the first frame. Rotations and scales
/// go to the keys that a pin has of them alone.
fn pasted(shot: &Shot, track: Track, (added, by): (&TrackKeys, f64)) -> Vec<(Track, TrackKeys)> {
    let first = f64::from(shot.frames.first);
    let own = track.keys(shot).or_else(|| {
        let TrackKeys::Handle(keys) = added else { return None };
        let resting: Option<&HandleKey> = keys.first();
        resting.map(|key| TrackKeys::Handle(with_handle_key(None, first, HandleKey { frame: key.frame + by, ..*key })))
    });
    let parts = match (track.pin(), added) {
        (Some(at), TrackKeys::Pin(keys)) => parted(shot, at, keys),
        _ => vec![(track, added.clone())],
    };
    let with = |(part, added): (Track, TrackKeys)| {
        let own = if part == track { own.clone() } else { part.keys(shot) };
        Some((part, own?.with(&added, by)?))
    };
    parts.into_iter().filter_map(with).collect()
}

/// Divides keys among a pin and its channels that have keys of their own.
fn parted(shot: &Shot, at: [usize; 2], keys: &[PinKey]) -> Vec<(Track, TrackKeys)> {
    let (mut rest, mut parts) = (keys.to_vec(), Vec::new());
    let tracks = Track::of_pin(shot, at);
    if tracks.contains(&Track::Rotation(at)) {
        let own = |key: &PinKey| Some(ChannelKey { frame: key.frame, value: key.rotate_degrees?, ease: key.ease });
        parts.push((Track::Rotation(at), TrackKeys::Rotation(rest.iter().filter_map(own).collect())));
        rest.iter_mut().for_each(|key| key.rotate_degrees = None);
    }
    if tracks.contains(&Track::Scale(at)) {
        let own = |key: &PinKey| Some(ChannelKey { frame: key.frame, value: key.scale?, ease: key.ease });
        parts.push((Track::Scale(at), TrackKeys::Scale(rest.iter().filter_map(own).collect())));
        rest.iter_mut().for_each(|key| key.scale = None);
    }
    parts.push((Track::Pin(at), TrackKeys::Pin(rest)));
    parts
}

/// Assigns keys to pins, channels and handles: those of a single pin or handle go to all of its kind.
fn owners<'a>(shot: &Shot, receivers: &[Track], copied: &'a [Copied]) -> Vec<(Track, &'a Copied)> {
    let of_kind = |&track: &Track| Some((track, copied.iter().find(|copied| copied.fits(track))?));
    if copied.windows(2).all(|pair| pair[0].is_beside(&pair[1])) {
        return receivers.iter().filter_map(of_kind).collect();
    }
    let by_name = |&track: &Track| {
        let name = track.name(shot);
        Some((track, copied.iter().find(|copied| copied.fits(track) && copied.name == name)?))
    };
    let found: Vec<_> = receivers.iter().filter_map(by_name).collect();
    if found.is_empty() && receivers.len() == copied.len() {
        let pairs = receivers.iter().copied().zip(copied);
        return pairs.filter(|(track, copied)| copied.fits(*track)).collect();
    }
    found
}
