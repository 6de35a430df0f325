//! Copy and paste of keys, for one pin or several.
//!
//! In: selected keys; selected pins and the current frame. Out: one document change.

use super::Session;
use crate::edit::track::{key_time, with_key};
use crate::shot::{PinKey, Shot};
use crate::spelling::pluralised;

impl Session {
    /// Copies the selected keys.
    pub fn copy_keys(&mut self) {
        if self.selection.keys.is_empty() {
            return self.say("No key is selected: click one in the timeline first.");
        }
        let shot = self.document.shot();
        let mut pins: Vec<[usize; 2]> = self.selection.keys.iter().map(|(at, _)| *at).collect();
        pins.sort_unstable();
        pins.dedup();
        self.copied = pins
            .into_iter()
            .filter_map(|at| {
                let (pin, times) = (shot.layers.get(at[0])?.pins.get(at[1])?, self.selection.times_of(at));
                let keys = pin.keys.iter().filter(|key| times.contains(&key.frame));
                Some((pin.name.clone(), keys.copied().collect::<Vec<_>>()))
            })
            .collect();
        let count: usize = self.copied.iter().map(|(_, keys)| keys.len()).sum();
        self.say(format!("Copied {}", pluralised(count, "key", "keys")));
    }

    /// Pastes the copied keys into the selected pins, the first key at the current frame. Keys of several pins go to
    /// the pins of the same names, in the selected layer if no pin is selected; pins without a match receive them in
    /// order.
    pub fn paste_keys(&mut self) {
        let first = self.copied.iter().flat_map(|(_, keys)| keys).map(|key| key.frame).min_by(f64::total_cmp);
        let Some(first) = first else { return self.say("Nothing was copied.") };
        let shot = self.document.shot();
        let chosen: Vec<[usize; 2]> = match self.selection.pins.is_empty() {
            false => self.selection.pins.iter().copied().collect(),
            true => {
                let count = shot.layers.get(self.selection.layer).map_or(0, |layer| layer.pins.len());
                (0..count).map(|pin| [self.selection.layer, pin]).collect()
            }
        };
        let is_one = self.copied.len() == 1;
        if chosen.is_empty() || is_one && self.selection.pins.is_empty() {
            return self.say("No pin is chosen: click one first.");
        }
        let mut keys = Vec::new();
        for (at, pasted) in owners(shot, &chosen, &self.copied) {
            let layer = &shot.layers[at[0]];
            let by = key_time(&shot.frames, layer, self.playhead.frame()) - first;
            let pasted = pasted.iter().map(|key| PinKey { frame: key.frame + by, ..*key });
            keys.push((at, pasted.fold(layer.pins[at[1]].keys.clone(), |keys, key| with_key(&keys, key))));
        }
        if keys.is_empty() {
            return self.say("No chosen pin has the name of one whose keys were copied.");
        }
        self.write_keys("Paste keys", &keys, None);
    }
}

/// Assigns keys to pins: the keys of a single pin go to all.
fn owners<'a>(
    shot: &Shot,
    chosen: &[[usize; 2]],
    copied: &'a [(String, Vec<PinKey>)],
) -> Vec<([usize; 2], &'a [PinKey])> {
    if let [(_, keys)] = copied {
        return chosen.iter().map(|&at| (at, &keys[..])).collect();
    }
    let named = |at: &[usize; 2]| shot.layers[at[0]].pins[at[1]].name.as_str();
    let by_name = |at: &[usize; 2]| {
        let (_, keys) = copied.iter().find(|(name, _)| name == named(at))?;
        Some((*at, &keys[..]))
    };
    let found: Vec<_> = chosen.iter().filter_map(by_name).collect();
    if found.is_empty() && chosen.len() == copied.len() {
        return chosen.iter().zip(copied).map(|(&at, (_, keys))| (at, &keys[..])).collect();
    }
    found
}
