//! Keys of a pin as curves over time.
//!
//! In: keys, a channel. Out: numbers for people (pixels, degrees, factors), and keys with other numbers.

use super::track::{key_at, with_key, without_keys};
use crate::shot::{Goal, PinKey, Rotation, Shot};
use crate::space::{ScreenPoint, ScreenVector};
use glam::DVec2;

/// A number that keys of a pin hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channel {
    /// To the right, pixels.
    X,
    /// Up, pixels.
    Y,
    /// Degrees, counter-clockwise.
    Rotation,
    /// A factor.
    Scale,
}

impl Channel {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::X, Self::Y, Self::Rotation, Self::Scale];

    /// For people.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x, px",
            Self::Y => "y, px",
            Self::Rotation => "rotation, \u{b0}",
            Self::Scale => "scale",
        }
    }

    /// The number in a key; `None`: it holds none of the kind, or one of the scene. `lines` of the frame.
    #[must_use]
    pub fn of(self, key: &PinKey, lines: f64) -> Option<f64> {
        let place = match key.goal {
            Goal::Offset(offset) => Some(offset.0),
            Goal::Target(target) => Some(target.0),
            Goal::SceneOffset(_) | Goal::SceneTarget(_) => None,
        };
        match (self, key.rotate_degrees) {
            (Self::X, _) => Some(place?.x * lines),
            (Self::Y, _) => Some(place?.y * lines),
            (Self::Rotation, Some(Rotation::InView(angle))) => Some(angle),
            (Self::Rotation, _) => None,
            (Self::Scale, _) => key.scale,
        }
    }

    /// The key with another number; numbers that cannot be are brought to the nearest that can.
    #[must_use]
    pub fn put(self, key: &PinKey, value: f64, lines: f64) -> PinKey {
        let mut key = *key;
        let height = (value / lines * 1e6).round() / 1e6;
        let moved = |old: DVec2| match self {
            Self::X => DVec2::new(height, old.y),
            _ => DVec2::new(old.x, height),
        };
        match (self, key.goal) {
            (Self::Rotation, _) => key.rotate_degrees = Some(Rotation::InView((value * 1e3).round() / 1e3)),
            (Self::Scale, _) => key.scale = Some((value.clamp(0.01, 100.0) * 1e4).round() / 1e4),
            (_, Goal::Offset(offset)) => key.goal = Goal::Offset(ScreenVector(moved(offset.0))),
            (_, Goal::Target(target)) => key.goal = Goal::Target(ScreenPoint(moved(target.0))),
            (_, Goal::SceneOffset(_) | Goal::SceneTarget(_)) => {}
        }
        key
    }
}

/// The curve of a channel at some times; empty: the pin has none of the kind.
#[must_use]
pub(in crate::edit) fn samples(shot: &Shot, at: [usize; 2], channel: Channel, times: &[f64]) -> Vec<[f64; 2]> {
    let lines = f64::from(shot.size.height);
    let value = |&time: &f64| Some([time, channel.of(&key_at(shot, at, time)?, lines)?]);
    times.iter().filter_map(value).collect()
}

/// Keys with that at one time in place of that at another.
#[must_use]
pub(in crate::edit) fn with_key_moved(keys: &[PinKey], from: f64, key: PinKey) -> Vec<PinKey> {
    let rest = if keys.len() > 1 { without_keys(keys, &[from]) } else { Vec::new() };
    with_key(&rest, key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::Ease;

    fn key(frame: f64, x: f64) -> PinKey {
        let goal = Goal::Offset(ScreenVector::new(x, 0.25));
        PinKey { frame, goal, rotate_degrees: None, scale: None, ease: Ease::Linear }
    }

    #[test]
    fn numbers_are_read_as_they_are_written() {
        for (channel, value) in
            [(Channel::X, -120.0), (Channel::Y, 12.5), (Channel::Rotation, 370.0), (Channel::Scale, 1.5)]
        {
            let put = channel.put(&key(3.0, 0.5), value, 100.0);
            assert!((channel.of(&put, 100.0).expect("written") - value).abs() < 1e-4, "{channel:?}");
        }
        assert_eq!(
            (Channel::Y.of(&key(1.0, 0.5), 100.0), Channel::Scale.of(&key(1.0, 0.5), 100.0)),
            (Some(25.0), None)
        );
        assert_eq!(Channel::Scale.put(&key(1.0, 0.0), -3.0, 100.0).scale, Some(0.01));
    }

    #[test]
    fn a_key_that_is_moved_keeps_the_order_and_takes_the_place_of_another() {
        let keys = [key(1.0, 0.1), key(5.0, 0.5), key(9.0, 0.9)];
        let moved = with_key_moved(&keys, 5.0, key(9.0, 0.5));
        assert_eq!(moved, [key(1.0, 0.1), key(9.0, 0.5)]);
        assert_eq!(with_key_moved(&keys[..1], 1.0, key(4.0, 0.1)), [key(4.0, 0.1)]);
    }
}
