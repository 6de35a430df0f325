//! The keys of one pin or handle, or of a channel that has keys of its own, and timeline edits of them that are the same for all.
//!
//! In: keys, a change. Out: keys with strictly increasing frames, at least one.

use crate::shot::{ChannelKey, Ease, HandleKey, LayerSpace, Pin, PinKey, Rotation, Shot};

/// What has keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Track {
    /// A pin, without the channels that have keys of their own: indices of layer and pin.
    Pin([usize; 2]),
    /// The rotation of a pin, if it has keys of its own.
    Rotation([usize; 2]),
    /// The scale of a pin, if it has keys of its own.
    Scale([usize; 2]),
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
    /// Returns what has keys of a pin: itself, then the channels with keys of their own.
    #[must_use]
    pub(in crate::edit) fn of_pin(shot: &Shot, at: [usize; 2]) -> Vec<Self> {
        let all = [Self::Pin(at), Self::Rotation(at), Self::Scale(at)];
        all.into_iter().filter(|track| *track == Self::Pin(at) || !track.times(shot).is_empty()).collect()
    }

    /// Returns the index of the layer.
    #[must_use]
    pub(crate) const fn layer(self) -> usize {
        match self {
            Self::Pin([layer, _]) | Self::Rotation([layer, _]) | Self::Scale([layer, _]) | Self::Handle((layer, _)) => {
                layer
            }
        }
    }

    /// Returns the indices of layer and pin; `None` for handles.
    #[must_use]
    pub(crate) const fn pin(self) -> Option<[usize; 2]> {
        match self {
            Self::Pin(at) | Self::Rotation(at) | Self::Scale(at) => Some(at),
            Self::Handle(_) => None,
        }
    }

    /// Returns the name of the channel that has keys of its own.
    #[must_use]
    pub(crate) const fn channel_name(self) -> Option<&'static str> {
        match self {
            Self::Rotation(_) => Some("rotation"),
            Self::Scale(_) => Some("scale"),
            Self::Pin(_) | Self::Handle(_) => None,
        }
    }

    /// Returns the display name; empty if there is no such pin or handle.
    #[must_use]
    pub(crate) fn name(self, shot: &Shot) -> String {
        if let Self::Handle((layer, index)) = self {
            let axes = shot.layers.get(layer).map_or(&index[..], |layer| axes_of(layer.space, &index));
            return format!("handle {}", axes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "));
        }
        let pin = self.own_pin(shot).map_or("", |pin| pin.name.as_str());
        self.channel_name().map_or_else(|| pin.to_owned(), |channel| format!("{pin} {channel}"))
    }

    /// Returns the pin; `None` if there is none.
    #[must_use]
    pub(in crate::edit) fn own_pin(self, shot: &Shot) -> Option<&Pin> {
        let [layer, pin] = self.pin()?;
        shot.layers.get(layer)?.pins.get(pin)
    }

    /// Returns the keys; `None` if there is no such pin, a handle that was never moved, or a channel without keys of its own.
    #[must_use]
    pub(in crate::edit) fn keys(self, shot: &Shot) -> Option<TrackKeys> {
        let pin = self.own_pin(shot);
        let keys = match self {
            Self::Pin(_) => TrackKeys::Pin(pin?.keys.clone()),
            Self::Rotation(_) => {
                TrackKeys::Rotation(pin.filter(|pin| !pin.rotate_keys.is_empty())?.rotate_keys.clone())
            }
            Self::Scale(_) => TrackKeys::Scale(pin.filter(|pin| !pin.scale_keys.is_empty())?.scale_keys.clone()),
            Self::Handle((layer, index)) => {
                let track = shot.layers.get(layer)?.handles.iter().find(|track| track.index == index)?;
                TrackKeys::Handle(track.keys.clone())
            }
        };
        Some(keys)
    }

    /// Returns the times and eases of the keys.
    #[must_use]
    pub(crate) fn times(self, shot: &Shot) -> Vec<(f64, Ease)> {
        let pin = self.own_pin(shot);
        match self {
            Self::Pin(_) => pin.map_or_else(Vec::new, |pin| times(&pin.keys)),
            Self::Rotation(_) => pin.map_or_else(Vec::new, |pin| times(&pin.rotate_keys)),
            Self::Scale(_) => pin.map_or_else(Vec::new, |pin| times(&pin.scale_keys)),
            Self::Handle((layer, index)) => {
                let handles = shot.layers.get(layer).map_or(&[][..], |layer| &layer.handles);
                handles.iter().find(|track| track.index == index).map_or_else(Vec::new, |track| times(&track.keys))
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

/// A key of a pin, of a channel or of a handle.
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

timed_keys!(PinKey, ChannelKey<Rotation>, ChannelKey<f64>, HandleKey);

/// The keys of a [`Track`].
#[derive(Clone, Debug, PartialEq)]
pub(in crate::edit) enum TrackKeys {
    Pin(Vec<PinKey>),
    Rotation(Vec<ChannelKey<Rotation>>),
    Scale(Vec<ChannelKey<f64>>),
    Handle(Vec<HandleKey>),
}

/// Evaluates an expression with keys of whichever kind.
macro_rules! with_keys {
    ($own:expr, $keys:ident => $result:expr) => {
        match $own {
            TrackKeys::Pin($keys) => $result,
            TrackKeys::Rotation($keys) => $result,
            TrackKeys::Scale($keys) => $result,
            TrackKeys::Handle($keys) => $result,
        }
    };
}

/// Evaluates an expression with keys of whichever kind, which returns keys of the same kind.
macro_rules! changed_keys {
    ($own:expr, $keys:ident => $result:expr) => {
        match $own {
            TrackKeys::Pin($keys) => TrackKeys::Pin($result),
            TrackKeys::Rotation($keys) => TrackKeys::Rotation($result),
            TrackKeys::Scale($keys) => TrackKeys::Scale($result),
            TrackKeys::Handle($keys) => TrackKeys::Handle($result),
        }
    };
}

pub(in crate::edit) use {changed_keys, with_keys};

impl TrackKeys {
    /// Returns the times and eases.
    #[must_use]
    pub(in crate::edit) fn times(&self) -> Vec<(f64, Ease)> {
        with_keys!(self, keys => times(keys))
    }

    /// Replaces the keys of a pin by these; those of handles change nothing.
    pub(in crate::edit) fn put_into(self, pin: &mut Pin) {
        match self {
            Self::Pin(keys) => pin.keys = keys,
            Self::Rotation(keys) => pin.rotate_keys = keys,
            Self::Scale(keys) => pin.scale_keys = keys,
            Self::Handle(_) => {}
        }
    }

    /// Returns the keys after a change of those at some times.
    #[must_use]
    pub(in crate::edit) fn edited(&self, edit: KeyEdit, times: &[f64]) -> Self {
        changed_keys!(self, keys => edit.apply(keys, times))
    }

    /// Returns the keys at some times only.
    #[must_use]
    pub(in crate::edit) fn only(&self, times: &[f64]) -> Self {
        fn of<K: TimedKey>(keys: &[K], times: &[f64]) -> Vec<K> {
            keys.iter().filter(|key| times.contains(&key.time())).copied().collect()
        }
        changed_keys!(self, keys => of(keys, times))
    }

    /// Returns the keys with others of the same kind, moved by a number of frames; they replace those at the same times.
    #[must_use]
    pub(in crate::edit) fn with(&self, added: &Self, by: f64) -> Option<Self> {
        fn of<K: TimedKey>(keys: &[K], added: &[K], by: f64) -> Vec<K> {
            added.iter().fold(keys.to_vec(), |keys, key| with_key(&keys, key.at(key.time() + by)))
        }
        match (self, added) {
            (Self::Pin(keys), Self::Pin(added)) => Some(Self::Pin(of(keys, added, by))),
            (Self::Rotation(keys), Self::Rotation(added)) => Some(Self::Rotation(of(keys, added, by))),
            (Self::Scale(keys), Self::Scale(added)) => Some(Self::Scale(of(keys, added, by))),
            (Self::Handle(keys), Self::Handle(added)) => Some(Self::Handle(of(keys, added, by))),
            _ => None,
        }
    }
}

/// A change of chosen keys, the same for pins, channels and handles.
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
