//! Drags and nudges of one pin or handle: what they make of its keys.
//!
//! In: keys, a time, a movement. Out: keys with strictly increasing frames, at least one.

use super::EditError;
use super::channel_keys::{in_degrees, rotate_key_at, scale_key_at};
use super::track_keys::{TimedKey, TrackKeys, with_key};
use crate::shot::{
    ChannelKey, Ease, FrameRange, Goal, HandleKey, HandleTrack, Layer, OffsetUnit, Pin, PinKey, Rotation, Shot,
};
use crate::space::{RotatedBox, ScreenPoint, ScreenVector};
use glam::{DVec2, DVec3};

/// How moving a pin affects its keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum AutoKey {
    /// A key is set at the current time.
    #[default]
    On,
    /// All keys are moved by the same amount.
    Off,
}

/// Where a movement sets keys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) struct Keying {
    pub(in crate::edit) time: f64,
    pub(in crate::edit) auto: AutoKey,
}

/// The transformation that a gesture applies to a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::edit) enum Move {
    /// Translation of the target in frame heights.
    By(DVec2),
    /// Rotation in degrees, counter-clockwise.
    Turn(f64),
    /// Rotation about one of three axes of the scene, in degrees.
    TurnAbout(usize, f64),
    /// Scale factor.
    Grow(f64),
}

impl Move {
    /// Returns the transformation mirrored left to right.
    pub(in crate::edit) fn mirrored(self) -> Self {
        match self {
            Self::By(by) => Self::By(DVec2::new(-by.x, by.y)),
            Self::Turn(degrees) => Self::Turn(-degrees),
            // A reflection across x keeps the sense of turns about x.
            Self::TurnAbout(0, degrees) => Self::TurnAbout(0, degrees),
            Self::TurnAbout(axis, degrees) => Self::TurnAbout(axis, -degrees),
            Self::Grow(factor) => Self::Grow(factor),
        }
    }
}

/// Returns the time at which a layer's keys must be set to take effect at a frame: layers on twos sample theirs at the
/// start of each drawing.
#[must_use]
pub(in crate::edit) fn key_time(frames: &FrameRange, layer: &Layer, frame: i32) -> f64 {
    let step = i32::try_from(layer.step).unwrap_or(1).max(1);
    f64::from(frames.first + (frame - frames.first).div_euclid(step) * step)
}

/// Returns the interpolated value of a pin's keys at a time, as a key; channels that have keys of their own are left out.
#[must_use]
pub(in crate::edit) fn key_at(shot: &Shot, [layer, pin]: [usize; 2], time: f64) -> Option<PinKey> {
    let own = shot.layers.get(layer)?.pins.get(pin)?;
    if let Some(key) = own.keys.iter().find(|key| key.frame == time) {
        return Some(*key);
    }
    // Strength is excluded, as it is applied to the value of the keys.
    let target = own.keyed_target(time);
    let before = own.keys.iter().rev().find(|key| key.frame < time).or(own.keys.first());
    let rotate_degrees = target.rotation.filter(|_| own.rotate_keys.is_empty()).map(in_degrees);
    let scale = target.log_scale.filter(|_| own.scale_keys.is_empty()).map(f64::exp);
    let ease = before.map_or(Ease::Smooth, |key| key.ease);
    Some(PinKey { frame: time, goal: target.goal, rotate_degrees, scale, ease })
}

/// Returns the interpolated values of all channels of a pin at a time, as a key.
#[must_use]
pub(in crate::edit) fn pose_at(shot: &Shot, at: [usize; 2], time: f64) -> Option<PinKey> {
    let (key, pin) = (key_at(shot, at, time)?, shot.layers.get(at[0])?.pins.get(at[1])?);
    let rotation = rotate_key_at(pin, time).map(|own| own.value);
    let scale = scale_key_at(pin, time).map(|own| own.value);
    Some(PinKey { rotate_degrees: rotation.or(key.rotate_degrees), scale: scale.or(key.scale), ..key })
}

/// What a movement on the screen means in the unit of a pin, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::edit) struct PinScale {
    /// The rest box of the layer's lattice on the screen.
    pub(in crate::edit) rest_box: Option<RotatedBox>,
    /// For keys in the scene: how they change for a frame height to the right and one up.
    pub(in crate::edit) steps: Option<[DVec3; 2]>,
}

/// Returns the keys that a gesture at a time changes: those of the pin, or of the channel that it turns or scales.
///
/// # Errors
/// [`EditError::Unusable`] if the pin has keys in the scene and is not seen, or turns about the scene's axes.
pub(in crate::edit) fn moved(
    shot: &Shot,
    at: [usize; 2],
    Keying { time, auto }: Keying,
    change: Move,
    scale: PinScale,
) -> Result<TrackKeys, EditError> {
    let (layer, pin) = (&shot.layers[at[0]], &shot.layers[at[0]].pins[at[1]]);
    let strength = if layer.strength.abs() < 1e-6 { 1.0 } else { layer.strength };
    match change {
        Move::Turn(_) | Move::TurnAbout(..) if !pin.rotate_keys.is_empty() => {
            let turn = |key: &ChannelKey<Rotation>| {
                let value = turned(Some(key.value), change, strength).ok_or_else(|| in_scene(pin))?;
                Ok(ChannelKey { value, ..*key })
            };
            keyed(&pin.rotate_keys, rotate_key_at(pin, time), auto, turn).map(TrackKeys::Rotation)
        }
        Move::Grow(factor) if !pin.scale_keys.is_empty() => {
            let grow = |key: &ChannelKey<f64>| Ok(ChannelKey { value: grown(key.value, factor, strength), ..*key });
            keyed(&pin.scale_keys, scale_key_at(pin, time), auto, grow).map(TrackKeys::Scale)
        }
        _ => {
            let change = |key: &PinKey| changed(key, change, strength, (pin.unit, scale)).ok_or_else(|| in_scene(pin));
            keyed(&pin.keys, key_at(shot, at, time), auto, change).map(TrackKeys::Pin)
        }
    }
}

/// Returns keys with the changed one of this time, or, without auto key, with all changed.
fn keyed<K: TimedKey>(
    keys: &[K],
    here: Option<K>,
    auto: AutoKey,
    change: impl Fn(&K) -> Result<K, EditError>,
) -> Result<Vec<K>, EditError> {
    match (auto, here) {
        (AutoKey::Off, _) => keys.iter().map(change).collect(),
        (AutoKey::On, Some(key)) => Ok(with_key(keys, change(&key)?)),
        (AutoKey::On, None) => Ok(keys.to_vec()),
    }
}

/// Returns a rotation after a turn; `None` if it is of another kind.
fn turned(old: Option<Rotation>, change: Move, strength: f64) -> Option<Rotation> {
    match (change, old) {
        (Move::Turn(degrees), None) => Some(Rotation::InView(round(degrees / strength, 1e3))),
        (Move::Turn(degrees), Some(Rotation::InView(old))) => {
            Some(Rotation::InView(round(old + degrees / strength, 1e3)))
        }
        (Move::TurnAbout(axis, degrees), None | Some(Rotation::Axes(_))) => {
            let mut angles = if let Some(Rotation::Axes(angles)) = old { angles } else { [0.0; 3] };
            let angle = angles.get_mut(axis)?;
            *angle = round(*angle + degrees / strength, 1e3);
            Some(Rotation::Axes(angles))
        }
        _ => None,
    }
}

fn grown(old: f64, factor: f64, strength: f64) -> f64 {
    let log_scale = old.ln() + factor.ln() / strength;
    round(log_scale.exp().clamp(0.01, 100.0), 1e4)
}

/// Converts a vector of the screen to sizes of a box, along its axes.
pub(in crate::edit) fn box_sizes(rest_box: RotatedBox, vector: DVec2) -> DVec2 {
    DVec2::from_angle(-rest_box.angle).rotate(vector) / rest_box.upright.size()
}

fn in_scene(pin: &Pin) -> EditError {
    EditError::Unusable {
        what: format!("pin '{}' has keys in the scene that cannot be dragged like this", pin.name),
        hint: "go to a frame in which it is seen, or type its numbers".into(),
    }
}

fn changed(key: &PinKey, change: Move, strength: f64, (unit, scale): (OffsetUnit, PinScale)) -> Option<PinKey> {
    let mut key = *key;
    let in_unit = |by: DVec2| match (unit, scale.rest_box) {
        (OffsetUnit::Box, Some(rest_box)) => box_sizes(rest_box, by),
        _ => by,
    };
    let in_scene = |old: [f64; 3], by: DVec2| {
        let [right, up] = scale.steps?;
        let new = DVec3::from(old) + (right * by.x + up * by.y) / strength;
        Some(new.to_array().map(|x| round(x, 1e6)))
    };
    match change {
        Move::By(by) => {
            key.goal = match key.goal {
                Goal::Offset(ScreenVector(offset)) => {
                    Goal::Offset(ScreenVector(rounded(offset + in_unit(by) / strength)))
                }
                Goal::Target(ScreenPoint(target)) => Goal::Target(ScreenPoint(rounded(target + by / strength))),
                Goal::SceneOffset(offset) => Goal::SceneOffset(in_scene(offset, by)?),
                // Targets are in metres, whatever the unit of offsets is.
                Goal::SceneTarget(target) if unit == OffsetUnit::Frame => Goal::SceneTarget(in_scene(target, by)?),
                Goal::SceneTarget(_) => return None,
            }
        }
        Move::Turn(_) | Move::TurnAbout(..) => {
            key.rotate_degrees = Some(turned(key.rotate_degrees, change, strength)?);
        }
        Move::Grow(factor) => key.scale = Some(grown(key.scale.unwrap_or(1.0), factor, strength)),
    }
    Some(key)
}

/// Rounds to far below a pixel, which keeps binary noise out of the file.
fn rounded(vector: DVec2) -> DVec2 {
    DVec2::new(round(vector.x, 1e6), round(vector.y, 1e6))
}

fn round(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}

/// Returns the interpolated value of a handle's keys at a time, as a key; at rest if it has none.
#[must_use]
pub(in crate::edit) fn handle_key_at(shot: &Shot, (layer, index): (usize, [usize; 3]), time: f64) -> Option<HandleKey> {
    let owner = shot.layers.get(layer)?;
    let resting = HandleKey { frame: time, offset: [0.0; 3], ease: Ease::Smooth };
    let Some(track) = owner.handles.iter().find(|track| track.index == index) else { return Some(resting) };
    let keys = &track.keys;
    if let Some(key) = keys.iter().find(|key| key.frame == time) {
        return Some(*key);
    }
    // Strength is excluded, as it is applied to the value of the keys.
    let offset = track.keyed_offset(time);
    let ease = keys.iter().rev().find(|key| key.frame < time).map_or(Ease::Smooth, |key| key.ease);
    Some(HandleKey { frame: time, offset, ease })
}

/// Returns the keys of a handle with another key; a handle without keys rests in the first frame of the shot.
#[must_use]
pub(in crate::edit) fn with_handle_key(track: Option<&HandleTrack>, first: f64, key: HandleKey) -> Vec<HandleKey> {
    let resting = HandleKey { frame: first, offset: [0.0; 3], ease: Ease::Smooth };
    with_key(track.map_or(&[resting], |track| &track.keys), key)
}

/// Returns the keys of a handle after a drag at a time; `by` in units of the lattice box's size. A handle without keys rests in
/// the first frame of the shot.
#[must_use]
pub(in crate::edit) fn handle_moved(
    shot: &Shot,
    at: (usize, [usize; 3]),
    Keying { time, auto }: Keying,
    by: [f64; 3],
) -> Option<Vec<HandleKey>> {
    let owner = shot.layers.get(at.0)?;
    let strength = if owner.strength == 0.0 { 1.0 } else { owner.strength };
    let change = |key: &HandleKey| HandleKey {
        offset: std::array::from_fn(|axis| round(key.offset[axis] + by[axis] / strength, 1e6)),
        ..*key
    };
    let track = owner.handles.iter().find(|track| track.index == at.1);
    let first = f64::from(shot.frames.first);
    match (auto, track) {
        (AutoKey::Off, Some(track)) => Some(track.keys.iter().map(change).collect()),
        (AutoKey::Off, None) => handle_key_at(shot, at, first).map(|key| vec![change(&key)]),
        (AutoKey::On, _) => Some(with_handle_key(track, first, change(&handle_key_at(shot, at, time)?))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn shot(more: &str) -> Shot {
        let text = format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n[[layer]]\n{more}\n[[layer.pin]]\nname = 'p'\n\
             anchor = {{ screen = [0.5, 0.5], frame = 1 }}\nkeys = [ {{ frame = 1, offset = [0, 0] }}, {{ frame = 11, offset = [1, 0], rotate = 20 }} ]"
        );
        Shot::parse(&text, Path::new("a.toml")).expect("a shot")
    }

    fn pin_keys(moved: Result<TrackKeys, EditError>) -> Vec<PinKey> {
        let Ok(TrackKeys::Pin(keys)) = moved else { panic!("{moved:?}") };
        keys
    }

    fn offset(key: &PinKey) -> DVec2 {
        let Goal::Offset(offset) = key.goal else { panic!("{key:?}") };
        offset.0
    }

    #[test]
    fn a_drag_keys_this_time_and_lands_under_the_pointer() {
        let shot = shot("strength = 0.5");
        let by = Move::By(DVec2::new(0.1, 0.2));
        let keys = pin_keys(moved(&shot, [0, 0], Keying { time: 6.0, auto: AutoKey::On }, by, PinScale::default()));
        assert_eq!(keys.iter().map(|key| key.frame).collect::<Vec<_>>(), [1.0, 6.0, 11.0]);
        // Halfway along the keys; at half strength, half of the keyed value is applied.
        assert_eq!((offset(&keys[1]), keys[1].rotate_degrees), (DVec2::new(0.7, 0.4), Some(Rotation::InView(10.0))));
        let keys = pin_keys(moved(&shot, [0, 0], Keying { time: 6.0, auto: AutoKey::Off }, by, PinScale::default()));
        assert_eq!(keys.iter().map(offset).collect::<Vec<_>>(), [DVec2::new(0.2, 0.4), DVec2::new(1.2, 0.4)]);
    }

    #[test]
    fn layers_on_twos_are_keyed_where_the_drawing_began() {
        let shot = shot("step = 2");
        let layer = &shot.layers[0];
        assert_eq!([7, 8, 9].map(|frame| key_time(&shot.frames, layer, frame)), [7.0, 7.0, 9.0]);
    }

    #[test]
    fn rings_turn_about_one_axis_and_are_mirrored() {
        let mut shot = shot("");
        let own = &mut shot.layers[0].pins[0];
        own.keys = vec![PinKey { rotate_degrees: Some(Rotation::Axes([10.0, 20.0, 30.0])), ..own.keys[0] }];
        let turned = |change: Move| {
            pin_keys(moved(&shot, [0, 0], Keying { time: 1.0, auto: AutoKey::On }, change, PinScale::default()))[0]
                .rotate_degrees
        };
        assert_eq!(turned(Move::TurnAbout(1, 5.0)), Some(Rotation::Axes([10.0, 25.0, 30.0])));
        assert_eq!(turned(Move::TurnAbout(2, 5.0).mirrored()), Some(Rotation::Axes([10.0, 20.0, 25.0])));
        assert_eq!(turned(Move::TurnAbout(0, 5.0).mirrored()), Some(Rotation::Axes([15.0, 20.0, 30.0])));
    }

    #[test]
    fn keys_in_the_scene_follow_the_pointer_at_constant_depth() {
        let mut shot = shot("strength = 2.0");
        let own = &mut shot.layers[0].pins[0];
        own.keys = vec![PinKey { goal: Goal::SceneOffset([1.0, 0.0, 0.0]), ..own.keys[0] }];
        let by = Move::By(DVec2::new(0.5, 0.25));
        let steps = Some([DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 8.0)]);
        let scale = PinScale { rest_box: None, steps };
        let keys = pin_keys(moved(&shot, [0, 0], Keying { time: 1.0, auto: AutoKey::On }, by, scale));
        assert_eq!(keys[0].goal, Goal::SceneOffset([2.0, 0.0, 1.0]));
        let error = moved(&shot, [0, 0], Keying { time: 1.0, auto: AutoKey::On }, by, PinScale::default())
            .expect_err("not seen");
        assert!(error.to_string().contains("in the scene"), "{error}");
    }

    #[test]
    fn without_auto_key_all_keys_of_a_handle_move_alike() {
        let handle = "[[layer.handle]]\nindex = [1, 2]\nkeys = [ { frame = 1, offset = [0, 0] }, { frame = 9, offset = [0.5, 0] } ]";
        let shot = shot(&format!("strength = 0.5\n{handle}"));
        let moved = |index: [usize; 3], auto: AutoKey| -> Vec<(f64, f64)> {
            let keys =
                handle_moved(&shot, (0, index), Keying { time: 5.0, auto }, [0.1, 0.0, 0.0]).expect("it is there");
            keys.iter().map(|key| (key.frame, key.offset[0])).collect()
        };
        assert_eq!(moved([1, 2, 0], AutoKey::Off), [(1.0, 0.2), (9.0, 0.7)]);
        assert_eq!(moved([3, 3, 0], AutoKey::Off), [(1.0, 0.2)]);
        assert_eq!(moved([1, 2, 0], AutoKey::On).iter().map(|key| key.0).collect::<Vec<_>>(), [1.0, 5.0, 9.0]);
    }

    #[test]
    fn a_gesture_changes_the_channel_with_keys_of_its_own() {
        let mut shot = shot("");
        let own = &mut shot.layers[0].pins[0];
        own.keys.iter_mut().for_each(|key| key.rotate_degrees = None);
        let key = |frame, degrees| ChannelKey { frame, value: Rotation::InView(degrees), ease: Ease::Linear };
        own.rotate_keys = vec![key(3.0, 0.0), key(7.0, 40.0)];
        own.scale_keys = vec![ChannelKey { frame: 2.0, value: 2.0, ease: Ease::Hold }];
        let moved =
            |auto, change| moved(&shot, [0, 0], Keying { time: 5.0, auto }, change, PinScale::default()).expect("seen");
        let turned = [key(3.0, 0.0), key(5.0, 30.0), key(7.0, 40.0)];
        assert_eq!(moved(AutoKey::On, Move::Turn(10.0)), TrackKeys::Rotation(turned.to_vec()));
        assert_eq!(moved(AutoKey::Off, Move::Turn(10.0)), TrackKeys::Rotation(vec![key(3.0, 10.0), key(7.0, 50.0)]));
        let grown = ChannelKey { frame: 2.0, value: 3.0, ease: Ease::Hold };
        assert_eq!(moved(AutoKey::Off, Move::Grow(1.5)), TrackKeys::Scale(vec![grown]));
        let TrackKeys::Pin(keys) = moved(AutoKey::On, Move::By(DVec2::ONE)) else { panic!("keys of the place") };
        assert!(keys.len() == 3 && keys.iter().all(|key| key.rotate_degrees.is_none() && key.scale.is_none()));
        let pose = pose_at(&shot, [0, 0], 7.0).expect("it is there");
        assert_eq!(pose.rotate_degrees, Some(Rotation::InView(40.0)));
        assert!(pose.scale.is_some_and(|scale| (scale - 2.0).abs() < 1e-12), "{pose:?}");
    }

    #[test]
    fn values_between_keys_are_those_of_the_keys_alone() {
        let mut shot = shot(
            "strength = 0.5\nstep = 4\n[[layer.handle]]\nindex = [1, 2]\nkeys = [ { frame = 1, offset = [0, 0] }, { frame = 9, offset = [0.5, 0] } ]",
        );
        let key = key_at(&shot, [0, 0], 6.0).expect("it is there");
        let Some(Rotation::InView(angle)) = key.rotate_degrees else { panic!("{key:?}") };
        assert!((offset(&key).x - 0.5).abs() < 1e-9 && (angle - 10.0).abs() < 1e-9 && key.scale.is_none(), "{key:?}");
        let handle = handle_key_at(&shot, (0, [1, 2, 0]), 5.0).expect("it is there");
        assert!(handle.frame == 5.0 && (handle.offset[0] - 0.25).abs() < 1e-9, "{handle:?}");
        shot.layers[0].pins[0].keys.clear();
        let key = key_at(&shot, [0, 0], 6.0).expect("at rest");
        assert_eq!((offset(&key), key.rotate_degrees), (DVec2::ZERO, None));
    }
}
