//! The curve view's data, and the effect of drags in it.
//!
//! In: pins and handles, channels, positions in the curve view. Out: values; one document change per drag.

use super::Session;
use crate::edit::curve::{Channel, CurveAxis, Tangent, TangentEnd, has_channel, samples};
use crate::edit::track_keys::{Track, TrackKeys};
use crate::shot::PinKey;

impl Session {
    /// Samples a curve at some times as (time, value); empty if the pin or handle does not use the channel.
    #[must_use]
    pub(crate) fn curve(&self, track: impl Into<Track>, channel: Channel, times: &[f64]) -> Vec<[f64; 2]> {
        samples(self.shot(), track.into(), channel, times)
    }

    /// Returns the keys of a pin or handle in a channel as (time, value).
    #[must_use]
    pub(crate) fn curve_keys(&self, track: impl Into<Track>, channel: Channel) -> Vec<[f64; 2]> {
        let track = track.into();
        let keys = track.keys(self.shot()).filter(|_| has_channel(self.shot(), track, channel));
        keys.map_or_else(Vec::new, |keys| keys.values(CurveAxis::of(self.shot(), track, channel)))
    }

    /// Returns the tangents of the selected keys of a pin or handle.
    #[must_use]
    pub(crate) fn tangents(&self, track: impl Into<Track>, channel: Channel) -> Vec<Tangent> {
        let track = track.into();
        let keys = track.keys(self.shot()).filter(|_| has_channel(self.shot(), track, channel));
        let (times, axis) = (self.selection.times_of(track), CurveAxis::of(self.shot(), track, channel));
        keys.map_or_else(Vec::new, |keys| keys.tangents(&times, axis))
    }

    /// Moves the end of a tangent to (time, value).
    pub(crate) fn bend_curve(&mut self, track: impl Into<Track>, tangent: TangentEnd, channel: Channel, to: [f64; 2]) {
        let track = track.into();
        let axis = CurveAxis::of(self.shot(), track, channel);
        let bent = track.keys(self.shot()).and_then(|keys| keys.bent(tangent, axis, to));
        let Some(keys) = bent else { return };
        self.write_keys("Bend curve", &[(track, keys)], Some(&format!("bend {track:?} {tangent:?}")));
    }

    /// Removes rotation or scale from all keys of a pin, with its own keys.
    pub(crate) fn free_channel(&mut self, at: [usize; 2], channel: Channel) {
        let Some(pin) = Track::Pin(at).own_pin(self.document.shot()) else { return };
        let keys = match channel {
            Channel::Scale if !pin.scale_keys.is_empty() => (Track::Scale(at), TrackKeys::Scale(Vec::new())),
            _ if channel.is_rotation() && !pin.rotate_keys.is_empty() => {
                (Track::Rotation(at), TrackKeys::Rotation(Vec::new()))
            }
            _ => {
                let free = |key: &PinKey| match channel {
                    Channel::Scale => PinKey { scale: None, ..*key },
                    _ if channel.is_rotation() => PinKey { rotate_degrees: None, ..*key },
                    _ => *key,
                };
                (Track::Pin(at), TrackKeys::Pin(pin.keys.iter().map(free).collect()))
            }
        };
        self.write_keys("Free pin", &[keys], None);
    }

    /// Moves a key to another time and value in a channel; keys cannot pass each other. One drag is one undo step.
    pub(crate) fn move_curve_key(&mut self, (track, from): (impl Into<Track>, f64), channel: Channel, to: [f64; 2]) {
        let track = track.into();
        let axis = CurveAxis::of(self.shot(), track, channel);
        let moved = track.keys(self.shot()).and_then(|keys| keys.moved(from, axis, to));
        let Some((keys, time)) = moved else { return };
        if self.write_keys("Move key", &[(track, keys)], Some(&format!("curve {track:?} {channel:?}"))) {
            self.selection.keys = vec![(track, time)];
        }
    }
}
