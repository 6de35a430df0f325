//! Curves of the keys of a pin or handle, whichever they are of.
//!
//! In: keys, a channel. Out: values, tangents, and keys with changed values.

use super::curve::{Channel, CurveKey, Tangent, bent, tangents, with_key_moved};
use super::track_keys::{KeyEdit, TrackKeys, changed_keys, with_keys};

impl TrackKeys {
    /// Returns the values of the keys in a channel as (time, value).
    #[must_use]
    pub(in crate::edit) fn values(&self, channel: Channel, scale: f64) -> Vec<[f64; 2]> {
        fn of<K: CurveKey>(keys: &[K], channel: Channel, scale: f64) -> Vec<[f64; 2]> {
            keys.iter().filter_map(|key| Some([key.time(), key.value(channel, scale)?])).collect()
        }
        with_keys!(self, keys => of(keys, channel, scale))
    }

    /// Returns the keys with those at some times changed by an amount in a channel.
    #[must_use]
    pub(in crate::edit) fn raised(&self, times: &[f64], channel: Channel, (by, scale): (f64, f64)) -> Self {
        fn of<K: CurveKey>(keys: &[K], times: &[f64], channel: Channel, (by, scale): (f64, f64)) -> Vec<K> {
            let raised = |key: &K| Some(key.with_value(channel, key.value(channel, scale)? + by, scale));
            let change = |key: &K| raised(key).filter(|_| times.contains(&key.time())).unwrap_or(*key);
            keys.iter().map(change).collect()
        }
        changed_keys!(self, keys => of(keys, times, channel, (by, scale)))
    }

    /// Returns the tangents at the keys of some times.
    #[must_use]
    pub(in crate::edit) fn tangents(&self, times: &[f64], channel: Channel, scale: f64) -> Vec<Tangent> {
        with_keys!(self, keys => tangents(keys, times, channel, scale))
    }

    /// Returns the keys after a tangent's end is moved to (time, value), as [`bent`].
    #[must_use]
    pub(in crate::edit) fn bent(&self, tangent: (f64, usize), channel: Channel, to: ([f64; 2], f64)) -> Option<Self> {
        let ease = with_keys!(self, keys => bent(keys, tangent, channel, to));
        Some(self.edited(KeyEdit::Ease(ease?), &[tangent.0]))
    }

    /// Returns the keys after one is moved to another time and value, and its time, as [`with_key_moved`].
    #[must_use]
    pub(in crate::edit) fn moved(&self, from: f64, channel: Channel, to: ([f64; 2], f64)) -> Option<(Self, f64)> {
        let landed;
        let moved = changed_keys!(self, keys => {
            let (keys, time) = with_key_moved(keys, from, channel, to)?;
            landed = time;
            keys
        });
        Some((moved, landed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::{Ease, HandleKey};

    #[test]
    fn values_of_handles_are_in_per_cent_of_the_box() {
        let key = HandleKey { frame: 2.0, offset: [0.125, -0.5, 0.0], ease: Ease::Linear };
        assert_eq!((key.value(Channel::X, 54.0), key.value(Channel::Scale, 54.0)), (Some(12.5), None));
        let keys = TrackKeys::Handle(vec![key]).raised(&[2.0], Channel::Y, (10.0, 54.0));
        assert_eq!(keys.values(Channel::Y, 54.0), [[2.0, -40.0]]);
        assert_eq!(keys.values(Channel::X, 54.0), [[2.0, 12.5]]);
    }
}
