//! Curves of the keys of a pin or handle, whichever they are of.
//!
//! In: keys, a channel. Out: values, tangents, and keys with changed values.

use super::curve::{CurveAxis, CurveKey, Tangent, TangentEnd, bent, tangents, with_key_moved};
use super::track_keys::{KeyEdit, TrackKeys, changed_keys, with_keys};

impl TrackKeys {
    /// Returns the values of the keys in a channel as (time, value).
    #[must_use]
    pub(in crate::edit) fn values(&self, axis: CurveAxis) -> Vec<[f64; 2]> {
        fn of<K: CurveKey>(keys: &[K], axis: CurveAxis) -> Vec<[f64; 2]> {
            keys.iter().filter_map(|key| Some([key.time(), key.value(axis)?])).collect()
        }
        with_keys!(self, keys => of(keys, axis))
    }

    /// Returns the keys with those at some times changed by an amount in a channel.
    #[must_use]
    pub(in crate::edit) fn raised(&self, times: &[f64], axis: CurveAxis, by: f64) -> Self {
        fn of<K: CurveKey>(keys: &[K], times: &[f64], axis: CurveAxis, by: f64) -> Vec<K> {
            let raised = |key: &K| Some(key.with_value(axis, key.value(axis)? + by));
            let change = |key: &K| raised(key).filter(|_| times.contains(&key.time())).unwrap_or(*key);
            keys.iter().map(change).collect()
        }
        changed_keys!(self, keys => of(keys, times, axis, by))
    }

    /// Returns the tangents at the keys of some times.
    #[must_use]
    pub(in crate::edit) fn tangents(&self, times: &[f64], axis: CurveAxis) -> Vec<Tangent> {
        with_keys!(self, keys => tangents(keys, times, axis))
    }

    /// Returns the keys after a tangent's end is moved to (time, value), as [`bent`].
    #[must_use]
    pub(in crate::edit) fn bent(&self, tangent: TangentEnd, axis: CurveAxis, to: [f64; 2]) -> Option<Self> {
        let ease = with_keys!(self, keys => bent(keys, tangent, axis, to));
        Some(self.edited(KeyEdit::Ease(ease?), &[tangent.key]))
    }

    /// Returns the keys after one is moved to another time and value, and its time, as [`with_key_moved`].
    #[must_use]
    pub(in crate::edit) fn moved(&self, from: f64, axis: CurveAxis, to: [f64; 2]) -> Option<(Self, f64)> {
        let landed;
        let moved = changed_keys!(self, keys => {
            let (keys, time) = with_key_moved(keys, from, axis, to)?;
            landed = time;
            keys
        });
        Some((moved, landed))
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::Channel;
    use super::*;
    use crate::shot::{Ease, HandleKey};

    #[test]
    fn values_of_handles_are_in_per_cent_of_the_box() {
        let key = HandleKey { frame: 2.0, offset: [0.125, -0.5, 0.0], ease: Ease::Linear };
        let [x, y, scale] = [Channel::X, Channel::Y, Channel::Scale].map(|channel| CurveAxis { channel, scale: 54.0 });
        assert_eq!((key.value(x), key.value(scale)), (Some(12.5), None));
        let keys = TrackKeys::Handle(vec![key]).raised(&[2.0], y, 10.0);
        assert_eq!(keys.values(y), [[2.0, -40.0]]);
        assert_eq!(keys.values(x), [[2.0, 12.5]]);
    }
}
