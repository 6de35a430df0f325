//! The first keys of a channel that was free: all keyed frames of the layer keep what they show.
//!
//! Once a pin has a rotation or scale in one key, the solver holds both in every frame, as a file cannot free them for a while. So the
//! first key comes with keys in all other keyed frames, which hold what is seen there.
//!
//! In: a pin, what its surroundings show. Out: the pin with those keys.

use super::keyed_frames::keyed_frames;
use super::track::key_at;
use super::track_keys::with_key;
use crate::shot::{ChannelKey, Ease, Pin, PinKey, Rotation, Shot};

/// A channel of a pin that the solver leaves free until it has a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::edit) enum FreeChannel {
    /// The rotation in the view.
    Rotation,
    /// The rotation about three axes of the scene.
    Axes,
    /// The scale.
    Scale,
}

/// How the surroundings of a pin are turned and scaled in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) struct SeenTurn {
    /// Rotation in degrees, counter-clockwise.
    pub(in crate::edit) degrees: f64,
    /// Scale factor.
    pub(in crate::edit) scale: f64,
}

impl SeenTurn {
    /// Neither turned nor scaled.
    pub(in crate::edit) const REST: Self = Self { degrees: 0.0, scale: 1.0 };
}

/// Rotations below this count as none, degrees.
const TURNED: f64 = 0.5;

/// Scales as near to 1 as this count as 1.
const SCALED: f64 = 0.01;

/// Where the first keys of a channel are set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) enum KeyedTimes {
    /// In all keyed frames of the layer, and at this time.
    Layer(f64),
    /// At the pin's own keys alone.
    Own,
}

/// Returns the pin with first keys of a channel that hold what is seen in those frames; `None` if it is not free. `seen`: what is
/// seen at a time, as far as it is known; unknown frames count as at rest. If the other channel is free, too, it is keyed where that is
/// needed to keep what is seen.
#[must_use]
pub(in crate::edit) fn with_first_keys(
    shot: &Shot,
    at: [usize; 2],
    (channel, times): (FreeChannel, KeyedTimes),
    seen: impl Fn(f64) -> Option<SeenTurn>,
) -> Option<Pin> {
    let layer = shot.layers.get(at[0])?;
    let own = layer.pins.get(at[1])?;
    let is_turned = !own.rotate_keys.is_empty() || own.keys.iter().any(|key| key.rotate_degrees.is_some());
    let is_scaled = !own.scale_keys.is_empty() || own.keys.iter().any(|key| key.scale.is_some());
    let is_free = match channel {
        FreeChannel::Rotation | FreeChannel::Axes => !is_turned,
        FreeChannel::Scale => !is_scaled,
    };
    if !is_free {
        return None;
    }
    let (now, mut eased) = match times {
        KeyedTimes::Layer(now) => (Some(now), keyed_frames(layer)),
        KeyedTimes::Own => (None, own.keys.iter().map(|key| (key.frame, key.ease)).collect()),
    };
    if let Some(now) = now.filter(|now| eased.iter().all(|(time, _)| time != now)) {
        let place = eased.partition_point(|(time, _)| *time < now);
        let ease = eased[..place].last().map_or(Ease::Smooth, |(_, ease)| *ease);
        eased.insert(place, (now, ease));
    }
    let seen_turns: Vec<SeenTurn> = eased.iter().map(|(time, _)| seen(*time).unwrap_or(SeenTurn::REST)).collect();
    let from = now.and_then(|now| eased.iter().position(|(time, _)| *time == now)).unwrap_or(0);
    let degrees = unwound(&seen_turns, from);
    let strength = if layer.strength.abs() < 1e-6 { 1.0 } else { layer.strength };
    let angle = |index: usize| match channel {
        FreeChannel::Axes => Rotation::Axes([0.0; 3]),
        FreeChannel::Rotation | FreeChannel::Scale => Rotation::InView(rounded(degrees[index] / strength, 1e3)),
    };
    let scale = |index: usize| rounded((seen_turns[index].scale.ln() / strength).exp(), 1e4);
    let sets_rotation = channel != FreeChannel::Scale || !is_turned && degrees.iter().any(|angle| angle.abs() > TURNED);
    let scales = seen_turns.iter().map(|turn| turn.scale);
    let sets_scale = match channel {
        FreeChannel::Scale => true,
        FreeChannel::Rotation => !is_scaled && { scales }.any(|scale| (scale - 1.0).abs() > SCALED),
        FreeChannel::Axes => false,
    };
    let mut pin = own.clone();
    let is_own = |time: f64| own.keys.iter().any(|key| key.frame == time) || Some(time) == now;
    if eased.iter().all(|(time, _)| is_own(*time)) {
        for (index, (time, _)) in eased.iter().enumerate() {
            let key = key_at(shot, at, *time)?;
            let rotate_degrees = if sets_rotation { Some(angle(index)) } else { key.rotate_degrees };
            let scale = if sets_scale { Some(scale(index)) } else { key.scale };
            pin.keys = with_key(&pin.keys, PinKey { rotate_degrees, scale, ..key });
        }
        return Some(pin);
    }
    // Keys of the pin in frames where others alone have some would change its way there.
    let all = eased.iter().enumerate();
    if sets_rotation {
        let key = |(index, &(frame, ease))| ChannelKey { frame, value: angle(index), ease };
        pin.rotate_keys = all.clone().map(key).collect();
    }
    if sets_scale {
        pin.scale_keys = all.map(|(index, &(frame, ease))| ChannelKey { frame, value: scale(index), ease }).collect();
    }
    Some(pin)
}

/// Returns the angles in degrees, each within half a turn of its neighbour towards the one at `from`.
fn unwound(seen_turns: &[SeenTurn], from: usize) -> Vec<f64> {
    let mut degrees: Vec<f64> = seen_turns.iter().map(|turn| turn.degrees).collect();
    let near = |angle: f64, other: f64| angle + 360.0 * ((other - angle) / 360.0).round();
    for index in (0..from).rev() {
        degrees[index] = near(degrees[index], degrees[index + 1]);
    }
    for index in from + 1..degrees.len() {
        degrees[index] = near(degrees[index], degrees[index - 1]);
    }
    degrees
}

/// Rounds; a sum with 0 is not -0.
fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn shot(layer: &str) -> Shot {
        let text = format!("scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n[[layer]]\n{layer}");
        Shot::parse(&text, Path::new("a.toml")).expect("a shot")
    }

    const PIN: &str = "[[layer.pin]]\nanchor = { screen = [0.5, 0.5], frame = 1 }\n\
                       keys = [{ frame = 1, offset = [0, 0] }, { frame = 14, offset = [0.2, 0] }]\n";

    /// At frame 1 turned by -170 degrees, at 14 by 170, at rest elsewhere.
    fn seen(time: f64) -> Option<SeenTurn> {
        let degrees = if time == 1.0 { -170.0 } else { 170.0 };
        Some(SeenTurn { degrees, scale: 1.0 }).filter(|_| time == 1.0 || time == 14.0)
    }

    fn angles(keys: impl Iterator<Item = (f64, Option<Rotation>)>) -> Vec<(f64, f64)> {
        let angle = |(time, rotation): (f64, Option<Rotation>)| match rotation {
            Some(Rotation::InView(angle)) => (time, angle),
            other => panic!("{other:?}"),
        };
        keys.map(angle).collect()
    }

    #[test]
    fn the_first_rotation_holds_what_other_keyed_frames_show() {
        let shot = shot(PIN);
        let first = |channel, times| with_first_keys(&shot, [0, 0], (channel, times), seen);
        let pin = first(FreeChannel::Rotation, KeyedTimes::Layer(6.0)).expect("it is free");
        let of = |pin: &Pin| angles(pin.keys.iter().map(|key| (key.frame, key.rotate_degrees)));
        assert_eq!(of(&pin), [(1.0, -170.0), (6.0, 0.0), (14.0, 170.0)]);
        assert!(pin.keys.iter().all(|key| key.scale.is_none()) && pin.rotate_keys.is_empty());
        // From one keyed frame to the next the shorter way around.
        assert_eq!(of(&first(FreeChannel::Rotation, KeyedTimes::Own).expect("free")), [(1.0, -170.0), (14.0, -190.0)]);
        // The solver holds the rotation, too, once it holds the scale.
        let pin = first(FreeChannel::Scale, KeyedTimes::Layer(6.0)).expect("it is free");
        assert_eq!(of(&pin).len(), 3);
        assert!(pin.keys.iter().all(|key| key.scale == Some(1.0)));
        let pin = first(FreeChannel::Axes, KeyedTimes::Layer(6.0)).expect("it is free");
        assert!(pin.keys.iter().all(|key| key.rotate_degrees == Some(Rotation::Axes([0.0; 3]))));
    }

    #[test]
    fn a_channel_that_is_keyed_gets_no_first_keys() {
        let shot = shot(&PIN.replacen("[0, 0]", "[0, 0], rotate = 5", 1));
        let first = |channel| with_first_keys(&shot, [0, 0], (channel, KeyedTimes::Layer(6.0)), seen);
        assert!(first(FreeChannel::Rotation).is_none() && first(FreeChannel::Axes).is_none());
        let scaled = first(FreeChannel::Scale).expect("it is free");
        assert_eq!(scaled.keys[0].rotate_degrees, Some(Rotation::InView(5.0)), "the rotation stays");
    }

    #[test]
    fn the_way_of_a_pin_does_not_change_where_others_alone_are_keyed() {
        let other = PIN.replacen("frame = 14", "frame = 20", 1);
        let shot = shot(&format!("strength = 0.5\n{PIN}{other}"));
        let channel = (FreeChannel::Rotation, KeyedTimes::Layer(6.0));
        let pin = with_first_keys(&shot, [0, 0], channel, seen).expect("it is free");
        assert_eq!(pin.keys, shot.layers[0].pins[0].keys);
        let own = angles(pin.rotate_keys.iter().map(|key| (key.frame, Some(key.value))));
        assert_eq!(own, [(1.0, -340.0), (6.0, 0.0), (14.0, 340.0), (20.0, 0.0)]);
    }
}
