//! The keys of one pin or handle, and timeline edits of them that are the same for both.
//!
//! In: keys, a change. Out: keys with strictly increasing frames, at least one.

use crate::shot::{Ease, HandleKey, LayerSpace, PinKey, Shot};

/// What has keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Track {
    /// A pin: indices of layer and pin.
    Pin([usize; 2]),
    /// A handle: index of the layer, coordinates in its lattice.
    Handle((usize, [usize; 3])),
}

impl From<[usize; 2]> for Track {
    fn from(pin: [usize; 2]) -> Self {
        Self::Pin(pin)
    }
}

impl From<(usize, [usize; 3])> for Track {
    fn from(handle: (usize, [usize; 3])) -> Self {
        Self::Handle(handle)
    }
}

impl Track {
    /// Returns the index of the layer.
    #[must_use]
    pub(crate) const fn layer(self) -> usize {
        match self {
            Self::Pin([layer, _]) | Self::Handle((layer, _)) => layer,
        }
    }

    /// Returns the display name; empty if there is no such pin or handle.
    #[must_use]
    pub(crate) fn name(self, shot: &Shot) -> String {
        let layer = shot.layers.get(self.layer());
        match self {
            Self::Pin([_, pin]) => {
                layer.and_then(|layer| layer.pins.get(pin)).map_or_else(String::new, |pin| pin.name.clone())
            }
            Self::Handle((_, index)) => {
                let axes = layer.map_or(&index[..], |layer| axes_of(layer.space, &index));
                format!("handle {}", axes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// Returns the keys; `None` if there is no such pin, or a handle that was never moved.
    #[must_use]
    pub(in crate::edit) fn keys(self, shot: &Shot) -> Option<TrackKeys> {
        let layer = shot.layers.get(self.layer())?;
        match self {
            Self::Pin([_, pin]) => Some(TrackKeys::Pin(layer.pins.get(pin)?.keys.clone())),
            Self::Handle((_, index)) => {
                let track = layer.handles.iter().find(|track| track.index == index)?;
                Some(TrackKeys::Handle(track.keys.clone()))
            }
        }
    }

    /// Returns the times and eases of the keys.
    #[must_use]
    pub(crate) fn times(self, shot: &Shot) -> Vec<(f64, Ease)> {
        let Some(layer) = shot.layers.get(self.layer()) else { return Vec::new() };
        match self {
            Self::Pin([_, pin]) => layer.pins.get(pin).map_or_else(Vec::new, |pin| times(&pin.keys)),
            Self::Handle((_, index)) => {
                let track = layer.handles.iter().find(|track| track.index == index);
                track.map_or_else(Vec::new, |track| times(&track.keys))
            }
        }
    }
}

fn times<K: TimedKey>(keys: &[K]) -> Vec<(f64, Ease)> {
    keys.iter().map(|key| (key.time(), key.ease())).collect()
}

/// Returns the coordinates of a handle that its lattice has.
pub(in crate::edit) fn axes_of(space: LayerSpace, index: &[usize; 3]) -> &[usize] {
    match space {
        LayerSpace::Screen { .. } => &index[..2],
        LayerSpace::World { .. } => index,
    }
}

/// A key of a pin or a handle.
pub(in crate::edit) trait TimedKey: Copy {
    /// Its time.
    fn time(&self) -> f64;
    /// Its ease.
    fn ease(&self) -> Ease;
    /// The same key at another time.
    fn at(self, time: f64) -> Self;
    /// The same key with another ease.
    fn with_ease(self, ease: Ease) -> Self;
}

macro_rules! timed_keys {
    ($($key:ty),*) => {$(
        impl TimedKey for $key {
            fn time(&self) -> f64 {
                self.frame
            }

            fn ease(&self) -> Ease {
                self.ease
            }

            fn at(self, frame: f64) -> Self {
                Self { frame, ..self }
            }

            fn with_ease(self, ease: Ease) -> Self {
                Self { ease, ..self }
            }
        }
    )*};
}

timed_keys!(PinKey, HandleKey);

/// The keys of a pin or a handle.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::edit) enum TrackKeys {
    Pin(Vec<PinKey>),
    Handle(Vec<HandleKey>),
}

impl TrackKeys {
    /// Returns the times and eases.
    #[must_use]
    pub(in crate::edit) fn times(&self) -> Vec<(f64, Ease)> {
        match self {
            Self::Pin(keys) => times(keys),
            Self::Handle(keys) => times(keys),
        }
    }

    /// Returns the keys after a change of those at some times.
    #[must_use]
    pub(in crate::edit) fn edited(&self, edit: KeyEdit, times: &[f64]) -> Self {
        match self {
            Self::Pin(keys) => Self::Pin(edit.apply(keys, times)),
            Self::Handle(keys) => Self::Handle(edit.apply(keys, times)),
        }
    }

    /// Returns the keys at some times only.
    #[must_use]
    pub(in crate::edit) fn only(&self, times: &[f64]) -> Self {
        fn of<K: TimedKey>(keys: &[K], times: &[f64]) -> Vec<K> {
            keys.iter().filter(|key| times.contains(&key.time())).copied().collect()
        }
        match self {
            Self::Pin(keys) => Self::Pin(of(keys, times)),
            Self::Handle(keys) => Self::Handle(of(keys, times)),
        }
    }

    /// Returns the keys with others of the same kind, moved by a number of frames; they replace those at the same times.
    #[must_use]
    pub(in crate::edit) fn with(&self, added: &Self, by: f64) -> Option<Self> {
        fn of<K: TimedKey>(keys: &[K], added: &[K], by: f64) -> Vec<K> {
            added.iter().fold(keys.to_vec(), |keys, key| with_key(&keys, key.at(key.time() + by)))
        }
        match (self, added) {
            (Self::Pin(keys), Self::Pin(added)) => Some(Self::Pin(of(keys, added, by))),
            (Self::Handle(keys), Self::Handle(added)) => Some(Self::Handle(of(keys, added, by))),
            _ => None,
        }
    }
}

/// A change of chosen keys, the same for pins and handles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) enum KeyEdit {
    /// They are removed; the last key of a pin or handle is kept.
    Remove,
    /// They move by a number of frames; keys that they land on are removed.
    Shift(f64),
    /// They get an ease.
    Ease(Ease),
}

impl KeyEdit {
    /// Returns the keys after the change of those at some times.
    #[must_use]
    pub(in crate::edit) fn apply<K: TimedKey>(self, keys: &[K], times: &[f64]) -> Vec<K> {
        let is_chosen = |key: &&K| times.contains(&key.time());
        match self {
            Self::Remove => {
                let kept: Vec<K> = keys.iter().filter(|key| !is_chosen(key)).copied().collect();
                if kept.is_empty() { keys.first().copied().into_iter().collect() } else { kept }
            }
            Self::Shift(by) => {
                let rest: Vec<K> = keys.iter().filter(|key| !is_chosen(key)).copied().collect();
                let moved = keys.iter().filter(is_chosen).map(|key| key.at(key.time() + by));
                moved.fold(rest, |keys, key| with_key(&keys, key))
            }
            Self::Ease(ease) => {
                keys.iter().map(|key| if is_chosen(&key) { key.with_ease(ease) } else { *key }).collect()
            }
        }
    }
}

/// Inserts a key, replacing one at the same time.
#[must_use]
pub(in crate::edit) fn with_key<K: TimedKey>(keys: &[K], key: K) -> Vec<K> {
    let mut keys: Vec<K> = keys.iter().filter(|other| other.time() != key.time()).copied().collect();
    let place = keys.partition_point(|other| other.time() < key.time());
    keys.insert(place, key);
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> Vec<HandleKey> {
        [1.0, 11.0].map(|frame| HandleKey { frame, offset: [0.1 * frame, 0.0, 0.0], ease: Ease::Linear }).to_vec()
    }

    #[test]
    fn keys_are_moved_eased_and_removed_in_order() {
        let times = |keys: &[HandleKey]| keys.iter().map(|key| key.frame).collect::<Vec<_>>();
        assert_eq!(times(&KeyEdit::Shift(20.0).apply(&keys(), &[1.0])), [11.0, 21.0]);
        let shifted = KeyEdit::Shift(10.0).apply(&keys(), &[1.0]);
        assert_eq!(times(&shifted), [11.0], "it takes the place of what it lands on");
        assert_eq!(shifted[0].offset, keys()[0].offset);
        assert_eq!(times(&KeyEdit::Remove.apply(&keys(), &[11.0])), [1.0]);
        assert_eq!(times(&KeyEdit::Remove.apply(&keys(), &[1.0, 11.0])), [1.0]);
        let eased = KeyEdit::Ease(Ease::Hold).apply(&keys(), &[1.0]);
        assert_eq!([eased[0].ease, eased[1].ease], [Ease::Hold, Ease::Linear]);
    }

    #[test]
    fn pasted_keys_keep_their_distances_and_their_kind() {
        let own = TrackKeys::Handle(keys());
        let pasted = own.with(&own.only(&[11.0]), 5.0).expect("of one kind");
        assert_eq!(pasted.times().iter().map(|key| key.0).collect::<Vec<_>>(), [1.0, 11.0, 16.0]);
        assert_eq!(own.with(&TrackKeys::Pin(Vec::new()), 0.0), None);
    }
}
