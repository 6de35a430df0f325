//! The keys of a pin, a channel or a handle as animation curves.
//!
//! In: keys, a channel. Out: values in display units (pixels, degrees, factors, per cent), and keys with changed values.

use super::channel_keys::{rotate_key_at, scale_key_at};
use super::track::{handle_key_at, key_at};
use super::track_keys::{KeyEdit, TimedKey, Track, with_key};
use crate::shot::{ChannelKey, Ease, Goal, HandleKey, LayerSpace, OffsetUnit, Pin, PinKey, Rotation, Shot};
use crate::space::{ScreenPoint, ScreenVector};
use glam::DVec2;

/// An animated value of a pin or handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Channel {
    /// The target's x: rightwards, in pixels; of keys in the scene, in their own unit; of handles, and of pins whose
    /// unit is the box, in per cent of the lattice's box.
    X,
    /// The target's y: upwards, in the units of x.
    Y,
    /// The target's z, of keys in the scene and of handles there.
    Z,
    /// Rotation in degrees, counter-clockwise.
    Rotation,
    /// Rotation about the x axis of the scene, in degrees.
    RotationX,
    /// Rotation about the y axis, as turned by that of x.
    RotationY,
    /// Rotation about the z axis, as turned by those of x and y.
    RotationZ,
    /// Scale factor.
    Scale,
}

/// A channel in the units in which its curve is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) struct CurveAxis {
    pub(in crate::edit) channel: Channel,
    /// Display units per unit of a position on the screen: the height of the frame in pixels, or a hundred for sizes of the lattice's
    /// box.
    pub(in crate::edit) scale: f64,
}

impl CurveAxis {
    /// Returns the axis of a channel of a pin or handle.
    #[must_use]
    pub(in crate::edit) fn of(shot: &Shot, track: Track, channel: Channel) -> Self {
        let is_in_parts = track.pin().is_none() || track.own_pin(shot).is_some_and(is_in_boxes);
        Self { channel, scale: if is_in_parts { 100.0 } else { f64::from(shot.size.height) } }
    }

    /// Returns a pin key's value; `None` if it has none.
    #[must_use]
    fn of_pin(self, key: &PinKey) -> Option<f64> {
        let place = match key.goal {
            Goal::Offset(ScreenVector(place)) | Goal::Target(ScreenPoint(place)) => {
                [Some(place.x * self.scale), Some(place.y * self.scale), None]
            }
            Goal::SceneOffset(place) | Goal::SceneTarget(place) => place.map(Some),
        };
        match self.channel.axis() {
            Some(axis) => place[axis],
            None if self.channel == Channel::Scale => key.scale,
            None => self.channel.of_rotation(key.rotate_degrees?),
        }
    }

    /// Returns the pin's key with another value, clamped to the valid range.
    #[must_use]
    fn put_pin(self, key: &PinKey, value: f64) -> PinKey {
        let mut key = *key;
        if let Some(axis) = self.channel.axis() {
            key.goal = placed(key.goal, axis, (value, self.scale));
        } else if self.channel == Channel::Scale {
            key.scale = Some(rounded_scale(value));
        } else {
            key.rotate_degrees = self.channel.put_rotation(key.rotate_degrees, value);
        }
        key
    }
}

impl Channel {
    /// Returns the display name.
    #[must_use]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Rotation => "rotation",
            Self::RotationX => "rotation x",
            Self::RotationY => "rotation y",
            Self::RotationZ => "rotation z",
            Self::Scale => "scale",
        }
    }

    /// Returns the coordinate of a position that it is.
    const fn axis(self) -> Option<usize> {
        match self {
            Self::X => Some(0),
            Self::Y => Some(1),
            Self::Z => Some(2),
            _ => None,
        }
    }

    /// Returns the axis of the scene about which it turns.
    const fn turn_axis(self) -> Option<usize> {
        match self {
            Self::RotationX => Some(0),
            Self::RotationY => Some(1),
            Self::RotationZ => Some(2),
            _ => None,
        }
    }

    /// Returns whether it is a rotation, of any kind.
    pub(in crate::edit) const fn is_rotation(self) -> bool {
        matches!(self, Self::Rotation) || self.turn_axis().is_some()
    }

    /// Returns a rotation's value; `None` if it is of another kind.
    fn of_rotation(self, rotation: Rotation) -> Option<f64> {
        match rotation {
            Rotation::InView(angle) => (self == Self::Rotation).then_some(angle),
            Rotation::Axes(angles) => Some(angles[self.turn_axis()?]),
        }
    }

    /// Returns a rotation with another value; `None` if this is no rotation.
    fn put_rotation(self, old: Option<Rotation>, value: f64) -> Option<Rotation> {
        let value = rounded(value, 1e3);
        let Some(axis) = self.turn_axis() else { return (self == Self::Rotation).then_some(Rotation::InView(value)) };
        let mut angles = if let Some(Rotation::Axes(angles)) = old { angles } else { [0.0; 3] };
        angles[axis] = value;
        Some(Rotation::Axes(angles))
    }
}

/// Returns a scale in the valid range.
fn rounded_scale(value: f64) -> f64 {
    rounded(value.clamp(0.01, 100.0), 1e4)
}

/// Returns a goal with another coordinate.
fn placed(goal: Goal, axis: usize, (value, scale): (f64, f64)) -> Goal {
    let on_screen = |mut old: DVec2| {
        if axis < 2 {
            old[axis] = rounded(value / scale, 1e6);
        }
        old
    };
    let in_scene = |mut old: [f64; 3]| {
        old[axis] = rounded(value, 1e6);
        old
    };
    match goal {
        Goal::Offset(offset) => Goal::Offset(ScreenVector(on_screen(offset.0))),
        Goal::Target(target) => Goal::Target(ScreenPoint(on_screen(target.0))),
        Goal::SceneOffset(offset) => Goal::SceneOffset(in_scene(offset)),
        Goal::SceneTarget(target) => Goal::SceneTarget(in_scene(target)),
    }
}

fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}

/// Returns whether the offsets of a pin on the screen are in sizes of the lattice's box.
pub(in crate::edit) fn is_in_boxes(pin: &Pin) -> bool {
    pin.unit == OffsetUnit::Box && pin.keys.first().is_some_and(|key| matches!(key.goal, Goal::Offset(_)))
}

/// A key whose values are shown as curves.
pub(in crate::edit) trait CurveKey: TimedKey {
    /// Returns its value on an axis; `None` if it has none.
    fn value(&self, axis: CurveAxis) -> Option<f64>;
    /// Returns it with another value, clamped to the valid range.
    fn with_value(&self, axis: CurveAxis, value: f64) -> Self;
}

impl CurveKey for PinKey {
    fn value(&self, axis: CurveAxis) -> Option<f64> {
        axis.of_pin(self)
    }

    fn with_value(&self, axis: CurveAxis, value: f64) -> Self {
        axis.put_pin(self, value)
    }
}

impl CurveKey for ChannelKey<Rotation> {
    fn value(&self, axis: CurveAxis) -> Option<f64> {
        axis.channel.of_rotation(self.value)
    }

    fn with_value(&self, axis: CurveAxis, value: f64) -> Self {
        axis.channel.put_rotation(Some(self.value), value).map_or(*self, |value| Self { value, ..*self })
    }
}

impl CurveKey for ChannelKey<f64> {
    fn value(&self, axis: CurveAxis) -> Option<f64> {
        (axis.channel == Channel::Scale).then_some(self.value)
    }

    fn with_value(&self, axis: CurveAxis, value: f64) -> Self {
        if axis.channel == Channel::Scale { Self { value: rounded_scale(value), ..*self } } else { *self }
    }
}

impl CurveKey for HandleKey {
    fn value(&self, axis: CurveAxis) -> Option<f64> {
        Some(100.0 * self.offset[axis.channel.axis()?])
    }

    fn with_value(&self, axis: CurveAxis, value: f64) -> Self {
        let mut key = *self;
        if let Some(axis) = axis.channel.axis() {
            key.offset[axis] = (value * 1e4).round() / 1e6;
        }
        key
    }
}

/// Samples a channel's curve at some times as (time, value); empty if the pin or handle does not use the channel.
#[must_use]
pub(in crate::edit) fn samples(shot: &Shot, track: Track, channel: Channel, times: &[f64]) -> Vec<[f64; 2]> {
    if !has_channel(shot, track, channel) {
        return Vec::new();
    }
    let axis = CurveAxis::of(shot, track, channel);
    let value = |time: f64| match track {
        Track::Pin(at) => key_at(shot, at, time)?.value(axis),
        Track::Rotation(_) => rotate_key_at(track.own_pin(shot)?, time)?.value(axis),
        Track::Scale(_) => scale_key_at(track.own_pin(shot)?, time)?.value(axis),
        Track::Handle(at) => handle_key_at(shot, at, time)?.value(axis),
    };
    let values: Vec<Option<f64>> = times.iter().map(|&time| value(time)).collect();
    if values.iter().all(Option::is_none) {
        return Vec::new();
    }
    // Keys without a rotation or scale count as not turned and not scaled between those that have one.
    let neutral = if channel == Channel::Scale { 1.0 } else { 0.0 };
    times.iter().zip(values).map(|(&time, value)| [time, value.unwrap_or(neutral)]).collect()
}

/// Returns whether a pin or handle has keys that can have values in a channel.
#[must_use]
pub(in crate::edit) fn has_channel(shot: &Shot, track: Track, channel: Channel) -> bool {
    let Some(owner) = shot.layers.get(track.layer()) else { return false };
    let holds = |pin: &Pin| match track {
        Track::Rotation(_) => channel.is_rotation() && !pin.rotate_keys.is_empty(),
        Track::Scale(_) => channel == Channel::Scale && !pin.scale_keys.is_empty(),
        _ if channel.is_rotation() => pin.rotate_keys.is_empty(),
        _ => channel != Channel::Scale || pin.scale_keys.is_empty(),
    };
    match (track, owner.space) {
        (Track::Handle(_), LayerSpace::Screen { .. }) if channel == Channel::Z => false,
        (Track::Handle((_, index)), _) => owner.handles.iter().any(|handle| handle.index == index),
        _ => track.own_pin(shot).is_some_and(holds),
    }
}

/// The free end of a Bézier handle of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TangentEnd {
    /// Time of the key that holds the ease.
    pub key: f64,
    /// 0: the outgoing handle of that key; 1: the incoming handle of the next key.
    pub control: usize,
}

/// One Bézier handle of a curve at a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tangent {
    pub end: TangentEnd,
    /// Time and value of the key that it is attached to.
    pub(crate) from: [f64; 2],
    /// Its own time and value.
    pub(crate) to: [f64; 2],
}

/// Returns the tangents on an axis at the keys of some times.
#[must_use]
pub(in crate::edit) fn tangents<K: CurveKey>(keys: &[K], times: &[f64], axis: CurveAxis) -> Vec<Tangent> {
    let mut found = Vec::new();
    for pair in keys.windows(2) {
        let ends = [0, 1].map(|end| Some([pair[end].time(), pair[end].value(axis)?]));
        let ([Some(start), Some(end)], Some(controls)) = (ends, controls(pair[0].ease())) else { continue };
        for control in [0, 1].into_iter().filter(|&control| times.contains(&pair[control].time())) {
            let part = |d: usize| start[d] + controls[2 * control + d] * (end[d] - start[d]);
            let handle = TangentEnd { key: start[0], control };
            found.push(Tangent { end: handle, from: [start, end][control], to: [part(0), part(1)] });
        }
    }
    found
}

/// Returns the ease of a key after a tangent's end is moved to (time, value); `None` if the key holds or is the last.
#[must_use]
pub(in crate::edit) fn bent<K: CurveKey>(
    keys: &[K],
    TangentEnd { key, control }: TangentEnd,
    axis: CurveAxis,
    [time, value]: [f64; 2],
) -> Option<Ease> {
    let pair = keys.windows(2).find(|pair| pair[0].time() == key)?;
    let mut controls = controls(pair[0].ease())?;
    let (start, end) = (pair[0].value(axis)?, pair[1].value(axis)?);
    let round = |value: f64| (value * 1e3).round() / 1e3;
    controls[2 * control] = round(((time - pair[0].time()) / (pair[1].time() - pair[0].time())).clamp(0.0, 1.0));
    // Between equal values the tangents are always flat.
    if (end - start).abs() > 1e-6 {
        controls[2 * control + 1] = round(((value - start) / (end - start)).clamp(-10.0, 10.0));
    }
    Some(Ease::Bezier(controls))
}

/// Returns the inner Bézier control points of an ease, x1, y1, x2, y2; `None` if it holds.
const fn controls(ease: Ease) -> Option<[f64; 4]> {
    match ease {
        Ease::Hold => None,
        Ease::Linear => Some([1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]),
        Ease::Smooth => Some([1.0 / 3.0, 0.0, 2.0 / 3.0, 1.0]),
        Ease::Bezier(controls) => Some(controls),
    }
}

/// Returns the keys with the key at time `from` at another time, where it does not pass others, and with another value.
#[must_use]
pub(in crate::edit) fn with_key_moved<K: CurveKey>(
    keys: &[K],
    from: f64,
    axis: CurveAxis,
    [time, value]: [f64; 2],
) -> Option<(Vec<K>, f64)> {
    let place = keys.iter().position(|key| key.time() == from)?;
    let before = place.checked_sub(1).map_or(f64::NEG_INFINITY, |place| keys[place].time());
    let after = keys.get(place + 1).map_or(f64::INFINITY, TimedKey::time);
    let time = if time > before && time < after { time } else { from };
    let rest = if keys.len() > 1 { KeyEdit::Remove.apply(keys, &[from]) } else { Vec::new() };
    Some((with_key(&rest, keys[place].with_value(axis, value).at(time)), time))
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: CurveAxis = axis(Channel::X);

    const fn axis(channel: Channel) -> CurveAxis {
        CurveAxis { channel, scale: 100.0 }
    }

    fn key(frame: f64, x: f64) -> PinKey {
        let goal = Goal::Offset(ScreenVector::new(x, 0.25));
        PinKey { frame, goal, rotate_degrees: None, scale: None, ease: Ease::Linear }
    }

    #[test]
    fn numbers_are_read_as_they_are_written() {
        for (channel, value) in
            [(Channel::X, -120.0), (Channel::Y, 12.5), (Channel::Rotation, 370.0), (Channel::Scale, 1.5)]
        {
            let put = axis(channel).put_pin(&key(3.0, 0.5), value);
            assert!((axis(channel).of_pin(&put).expect("written") - value).abs() < 1e-4, "{channel:?}");
        }
        assert_eq!(
            (axis(Channel::Y).of_pin(&key(1.0, 0.5)), axis(Channel::Scale).of_pin(&key(1.0, 0.5))),
            (Some(25.0), None)
        );
        assert_eq!(axis(Channel::Scale).put_pin(&key(1.0, 0.0), -3.0).scale, Some(0.01));
        let turned = PinKey { rotate_degrees: Some(Rotation::Axes([10.0, 20.0, 30.0])), ..key(1.0, 0.0) };
        let put = axis(Channel::RotationY).put_pin(&turned, -75.0);
        assert_eq!(put.rotate_degrees, Some(Rotation::Axes([10.0, -75.0, 30.0])));
        assert_eq!((axis(Channel::RotationY).of_pin(&put), axis(Channel::Rotation).of_pin(&put)), (Some(-75.0), None));
        assert_eq!(axis(Channel::RotationX).of_pin(&key(1.0, 0.0)), None);
    }

    #[test]
    fn a_key_that_is_moved_does_not_pass_another() {
        let keys = [key(1.0, 0.1), key(5.0, 0.5), key(9.0, 0.9)];
        let moved = |to: [f64; 2]| with_key_moved(&keys, 5.0, X, to).expect("it is there");
        assert_eq!(moved([7.0, 20.0]), (vec![keys[0], key(7.0, 0.2), keys[2]], 7.0));
        assert_eq!(moved([9.0, 20.0]), (vec![keys[0], key(5.0, 0.2), keys[2]], 5.0));
        let alone = with_key_moved(&keys[..1], 1.0, X, [4.0, 10.0]);
        assert_eq!(alone, Some((vec![key(4.0, 0.1)], 4.0)));
    }

    #[test]
    fn a_tangent_s_end_is_where_it_was_put() {
        let keys = [key(1.0, 0.0), key(5.0, 1.0), key(9.0, 1.0)];
        let ends = tangents(&keys, &[1.0, 5.0], X);
        assert_eq!(
            ends.iter().map(|end| (end.end.key, end.end.control)).collect::<Vec<_>>(),
            [(1.0, 0), (1.0, 1), (5.0, 0)]
        );
        let ease = bent(&keys, TangentEnd { key: 1.0, control: 0 }, X, [3.0, -25.0]).expect("it bends");
        let mut bent_keys = keys;
        bent_keys[0].ease = ease;
        let end = tangents(&bent_keys, &[1.0], X)[0];
        assert_eq!((end.from, end.to), ([1.0, 0.0], [3.0, -25.0]));
        // Segments between equal values keep flat tangents; held ones have none.
        let flat = bent(&keys, TangentEnd { key: 5.0, control: 0 }, X, [6.0, 900.0]).expect("it bends");
        assert_eq!(
            flat,
            Ease::Bezier([0.25, 0.333_333_333_333_333_3, 0.666_666_666_666_666_6, 0.666_666_666_666_666_6])
        );
        bent_keys[0].ease = Ease::Hold;
        assert!(bent(&bent_keys, TangentEnd { key: 1.0, control: 0 }, X, [3.0, 0.0]).is_none());
        assert!(bent(&keys, TangentEnd { key: 9.0, control: 0 }, X, [9.5, 0.0]).is_none());
    }
}
