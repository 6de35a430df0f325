//! Copy and paste of keys, for one pin or handle or several.
//!
//! In: selected keys; selected pins and handles, and the current frame. Out: one document change.

use super::Session;
use crate::edit::track::{key_time, with_handle_key};
use crate::edit::track_keys::{Track, TrackKeys};
use crate::shot::{HandleKey, Shot};
use crate::spelling::pluralised;

/// The copied keys of one pin or handle.
#[derive(Clone, Debug)]
pub(super) struct Copied {
    track: Track,
    /// The name of the pin, or the coordinates of the handle.
    name: String,
    keys: TrackKeys,
}

impl Copied {
    /// Returns whether its keys fit a pin or handle.
    const fn fits(&self, track: Track) -> bool {
        matches!((self.track, track), (Track::Pin(_), Track::Pin(_)) | (Track::Handle(_), Track::Handle(_)))
    }
}

impl Session {
    /// Copies the selected keys.
    pub fn copy_keys(&mut self) {
        if self.selection.keys.is_empty() {
            return self.say("No key is selected: click one in the timeline first.");
        }
        let shot = self.document.shot();
        let copy = |track: Track| {
            let keys = track.keys(shot)?.only(&self.selection.times_of(track));
            Some(Copied { track, name: track.name(shot), keys })
        };
        self.copied = self.selection.keyed().into_iter().filter_map(copy).collect();
        let count: usize = self.copied.iter().map(|copied| copied.keys.times().len()).sum();
        self.say(format!("Copied {}", pluralised(count, "key", "keys")));
    }

    /// Pastes the copied keys into the selected pins and handles, the first key at the current frame. Keys of several
    /// go to those of the same names, in the selected layer if none is selected; those without a match receive them
    /// in order.
    pub fn paste_keys(&mut self) {
        let times = self.copied.iter().flat_map(|copied| copied.keys.times());
        let Some(first) = times.map(|(time, _)| time).min_by(f64::total_cmp) else {
            return self.say("Nothing was copied.");
        };
        let chosen = self.selection.tracks();
        let receivers = match (chosen.is_empty(), self.copied.len()) {
            (true, 1) => Vec::new(),
            (true, _) => self.receivers(),
            (false, _) => chosen,
        };
        if receivers.is_empty() {
            return self.say("No pin or handle is chosen: click one first.");
        }
        let shot = self.document.shot();
        let paste = |(track, copied): (Track, &Copied)| {
            let layer = shot.layers.get(track.layer())?;
            let by = key_time(&shot.frames, layer, self.playhead.frame()) - first;
            Some((track, pasted(shot, track, (&copied.keys, by))?))
        };
        let keys: Vec<_> = owners(shot, &receivers, &self.copied).into_iter().filter_map(paste).collect();
        if keys.is_empty() {
            return self.say("No chosen pin or handle has the name of one whose keys were copied.");
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
        (0..owner.pins.len()).map(|pin| Track::Pin([layer, pin])).chain(copied).collect()
    }
}

/// Returns the keys of a pin or handle with those that are pasted; a handle without keys rests in the first frame.
fn pasted(shot: &Shot, track: Track, (added, by): (&TrackKeys, f64)) -> Option<TrackKeys> {
    let first = f64::from(shot.frames.first);
    let own = track.keys(shot).or_else(|| {
        let TrackKeys::Handle(keys) = added else { return None };
        let resting: Option<&HandleKey> = keys.first();
        resting.map(|key| TrackKeys::Handle(with_handle_key(None, first, HandleKey { frame: key.frame + by, ..*key })))
    });
    own?.with(added, by)
}

/// Assigns keys to pins and handles: those of a single one go to all of its kind.
fn owners<'a>(shot: &Shot, receivers: &[Track], copied: &'a [Copied]) -> Vec<(Track, &'a Copied)> {
    if let [only] = copied {
        return receivers.iter().filter(|track| only.fits(**track)).map(|&track| (track, only)).collect();
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
