//! Rotation and scale of a pin that have keys of their own: their values at a time, and how they leave and join the pin's keys.
//!
//! In: a pin, a time. Out: keys; none of this changes the motion.

use crate::shot::{ChannelKey, Ease, Pin, PinKey, Rotation};

/// Returns the interpolated value of a pin's own rotation keys at a time, as a key; `None` if it has none.
#[must_use]
pub(in crate::edit) fn rotate_key_at(pin: &Pin, time: f64) -> Option<ChannelKey<Rotation>> {
    own_key_at(&pin.rotate_keys, time, || pin.keyed_target(time).rotation.map(in_degrees))
}

/// Returns the interpolated value of a pin's own scale keys at a time, as a key; `None` if it has none.
#[must_use]
pub(in crate::edit) fn scale_key_at(pin: &Pin, time: f64) -> Option<ChannelKey<f64>> {
    own_key_at(&pin.scale_keys, time, || pin.keyed_target(time).log_scale.map(f64::exp))
}

fn own_key_at<V: Copy>(keys: &[ChannelKey<V>], time: f64, value: impl Fn() -> Option<V>) -> Option<ChannelKey<V>> {
    if let Some(key) = keys.iter().find(|key| key.frame == time) {
        return Some(*key);
    }
    let before = keys.iter().rev().find(|key| key.frame < time).or(keys.first())?;
    Some(ChannelKey { frame: time, value: value()?, ease: before.ease })
}

/// Converts a rotation from radians.
pub(in crate::edit) fn in_degrees(radians: Rotation) -> Rotation {
    match radians {
        Rotation::InView(angle) => Rotation::InView(angle.to_degrees()),
        Rotation::Axes(angles) => Rotation::Axes(angles.map(f64::to_degrees)),
    }
}

/// Returns the keys of a pin without its rotation, and those of the rotation alone; `None` if the rotation is free, or apart already.
#[must_use]
pub(in crate::edit) fn rotation_apart(pin: &Pin) -> Option<(Vec<PinKey>, Vec<ChannelKey<Rotation>>)> {
    // A key without a rotation among others that have one is not turned.
    let neutral = match pin.keys.iter().find_map(|key| key.rotate_degrees)? {
        Rotation::InView(_) => Rotation::InView(0.0),
        Rotation::Axes(_) => Rotation::Axes([0.0; 3]),
    };
    let own =
        |key: &PinKey| ChannelKey { frame: key.frame, value: key.rotate_degrees.unwrap_or(neutral), ease: key.ease };
    let rest = |key: &PinKey| PinKey { rotate_degrees: None, ..*key };
    Some((pin.keys.iter().map(rest).collect(), pin.keys.iter().map(own).collect()))
}

/// Returns the keys of a pin without its scale, and those of the scale alone, as [`rotation_apart`].
#[must_use]
pub(in crate::edit) fn scale_apart(pin: &Pin) -> Option<(Vec<PinKey>, Vec<ChannelKey<f64>>)> {
    pin.keys.iter().find_map(|key| key.scale)?;
    let own = |key: &PinKey| ChannelKey { frame: key.frame, value: key.scale.unwrap_or(1.0), ease: key.ease };
    let rest = |key: &PinKey| PinKey { scale: None, ..*key };
    Some((pin.keys.iter().map(rest).collect(), pin.keys.iter().map(own).collect()))
}

/// Returns the keys of a pin with its rotation among them.
///
/// # Errors
/// Why the motion would change.
pub(in crate::edit) fn rotation_joined(pin: &Pin) -> Result<Vec<PinKey>, String> {
    joined(&pin.keys, &pin.rotate_keys, |key, value| PinKey { rotate_degrees: Some(value), ..key })
}

/// Returns the keys of a pin with its scale among them.
///
/// # Errors
/// Why the motion would change.
pub(in crate::edit) fn scale_joined(pin: &Pin) -> Result<Vec<PinKey>, String> {
    joined(&pin.keys, &pin.scale_keys, |key, value| PinKey { scale: Some(value), ..key })
}

fn joined<V: Copy + PartialEq>(
    keys: &[PinKey],
    own: &[ChannelKey<V>],
    put: impl Fn(PinKey, V) -> PinKey,
) -> Result<Vec<PinKey>, String> {
    // What stands still takes the frames of what moves.
    if let [only] = own {
        return Ok(keys.iter().map(|key| put(*key, only.value)).collect());
    }
    if let [only] = keys {
        let with = |key: &ChannelKey<V>| put(PinKey { frame: key.frame, ease: key.ease, ..*only }, key.value);
        return Ok(own.iter().map(with).collect());
    }
    if let Some(key) = own.iter().find(|key| keys.iter().all(|other| other.frame != key.frame)) {
        return Err(format!("it has a key in frame {}, where the other values have none", key.frame));
    }
    if let Some(key) = keys.iter().find(|key| own.iter().all(|other| other.frame != key.frame)) {
        return Err(format!("it has no key in frame {}, where the other values have one", key.frame));
    }
    let values = |key: &PinKey| PinKey { frame: 0.0, ease: Ease::Linear, ..*key };
    let with = |(index, key): (usize, &PinKey)| {
        let stands = own.get(index + 1).is_none_or(|next| next.value == own[index].value);
        let others_stand = keys.get(index + 1).is_some_and(|next| values(next) == values(key));
        let ease = match (stands || own[index].ease == key.ease, others_stand) {
            (true, _) => key.ease,
            (false, true) => own[index].ease,
            (false, false) => return Err(format!("its ease from frame {} on is another one", key.frame)),
        };
        Ok(put(PinKey { ease, ..*key }, own[index].value))
    };
    keys.iter().enumerate().map(with).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::Shot;
    use std::path::Path;

    const KEYS: &str = "keys = [{ frame = 1, offset = [0, 0], scale = 2, ease = 'smooth' }, \
                        { frame = 5, offset = [0.3, 0.1], rotate = 400, ease = { bezier = [0.3, 0, 0.4, 1.4] } }, \
                        { frame = 9, offset = [0.3, 0.2], rotate = -20, scale = 0.7, ease = 'hold' }, { frame = 14, rotate = 5 }]";

    fn shot(keys: &str) -> Shot {
        let text = format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\nstrength = 0.8\n[[layer]]\n[[layer.pin]]\nname = 'p'\n\
             anchor = {{ screen = [0.5, 0.5], frame = 1 }}\n{keys}"
        );
        Shot::parse(&text, Path::new("a.toml")).expect("a shot")
    }

    /// A hundred times from before the first to after the last frame, the same in every run.
    fn times() -> impl Iterator<Item = f64> {
        let next =
            |state: &u64| Some(state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407));
        std::iter::successors(Some(7_u64), next)
            .skip(1)
            .take(100)
            .map(|state| -3.0 + 30.0 * (state >> 11) as f64 / (1_u64 << 53) as f64)
    }

    #[test]
    fn a_channel_keyed_separately_and_joined_again_moves_as_before() {
        let before = shot(KEYS);
        let mut apart = before.clone();
        let pin = &mut apart.layers[0].pins[0];
        (pin.keys, pin.rotate_keys) = rotation_apart(pin).expect("turned");
        (pin.keys, pin.scale_keys) = scale_apart(pin).expect("scaled");
        assert!(pin.keys.iter().all(|key| key.rotate_degrees.is_none() && key.scale.is_none()));
        assert!(rotation_apart(pin).is_none() && scale_apart(pin).is_none());
        let mut joined = apart.clone();
        let pin = &mut joined.layers[0].pins[0];
        (pin.keys, pin.rotate_keys) = (rotation_joined(pin).expect("of the same frames"), Vec::new());
        (pin.keys, pin.scale_keys) = (scale_joined(pin).expect("of the same frames"), Vec::new());
        for time in times() {
            assert_eq!(apart.pin_targets(0, time), before.pin_targets(0, time), "{time}");
            assert_eq!(joined.pin_targets(0, time), before.pin_targets(0, time), "{time}");
            assert_eq!(apart.pin_path(0, time), before.pin_path(0, time), "{time}");
        }
    }

    #[test]
    fn angles_about_three_axes_are_keyed_separately() {
        let mut shot = shot(KEYS);
        let pin = &mut shot.layers[0].pins[0];
        for key in &mut pin.keys {
            key.rotate_degrees = key.rotate_degrees.map(|_| Rotation::Axes([key.frame, -3.0, 400.0]));
        }
        let (_, own) = rotation_apart(pin).expect("turned");
        assert_eq!((own[0].value, own[2].value), (Rotation::Axes([0.0; 3]), Rotation::Axes([9.0, -3.0, 400.0])));
    }

    #[test]
    fn a_channel_is_joined_only_where_no_motion_changes() {
        let why = |keys: &str| rotation_joined(&shot(keys).layers[0].pins[0]).expect_err(keys);
        let place = "keys = [{ frame = 1, offset = [0, 0] }, { frame = 9, offset = [1, 0] }]\n";
        let turned = |keys: &str| format!("{place}rotate_keys = [{keys}]");
        let told = why(&turned("{ frame = 1, value = 0 }, { frame = 5, value = 9 }, { frame = 9, value = 3 }"));
        assert!(told.contains("a key in frame 5"), "{told}");
        let told = why(&turned("{ frame = 9, value = 0 }, { frame = 9.5, value = 9 }"));
        assert!(told.contains("a key in frame 9.5"), "{told}");
        let long = place.replace(" }]", " }, { frame = 12, offset = [0, 0] }]");
        let told = why(&format!("{long}rotate_keys = [{{ frame = 1, value = 0 }}, {{ frame = 9, value = 9 }}]"));
        assert!(told.contains("no key in frame 12"), "{told}");
        let told = why(&turned("{ frame = 1, value = 0, ease = 'smooth' }, { frame = 9, value = 9 }"));
        assert!(told.contains("ease from frame 1"), "{told}");
        // What stands still has no ease of its own.
        for keys in [
            turned("{ frame = 1, value = 7, ease = 'smooth' }, { frame = 9, value = 7 }"),
            turned("{ frame = 3, value = 7 }"),
            "keys = [{ frame = 2, offset = [1, 0] }]\nrotate_keys = [{ frame = 1, value = 0, ease = 'smooth' }, { frame = 9, value = 9 }]".into(),
            "keys = [{ frame = 1, offset = [1, 0] }, { frame = 9, offset = [1, 0] }]\n\
             rotate_keys = [{ frame = 1, value = 0, ease = 'smooth' }, { frame = 9, value = 9 }]".into(),
        ] {
            let (before, mut after) = (shot(&keys), shot(&keys));
            let pin = &mut after.layers[0].pins[0];
            (pin.keys, pin.rotate_keys) = (rotation_joined(pin).expect(&keys), Vec::new());
            for time in times() {
                let [was, is] = [&before, &after].map(|shot| {
                    let target = shot.pin_targets(0, time).pins[0];
                    let Some(Rotation::InView(angle)) = target.rotation else { unreachable!("{target:?}") };
                    (target.goal, angle)
                });
                assert!((is.1 - was.1).abs() < 1e-12, "{keys}, {time}: {is:?} {was:?}");
                let [from, to] = [was.0, is.0].map(|goal| {
                    let crate::shot::Goal::Offset(offset) = goal else { unreachable!("{goal:?}") };
                    offset.0
                });
                assert!((to - from).length() < 1e-12, "{keys}, {time}: {is:?} {was:?}");
            }
        }
    }

    #[test]
    fn values_between_own_keys_are_read_as_keys() {
        let shot = shot(
            "rotate_keys = [{ frame = 1, value = 0, ease = 'hold' }, { frame = 3, value = 10 }, { frame = 7, value = 30 }]",
        );
        let pin = &shot.layers[0].pins[0];
        assert_eq!(rotate_key_at(pin, 3.0), Some(pin.rotate_keys[1]));
        let between = rotate_key_at(pin, 5.0).expect("keyed");
        let Rotation::InView(angle) = between.value else { unreachable!("{between:?}") };
        assert!((angle - 20.0).abs() < 1e-9 && between.ease == Ease::Linear, "{between:?}");
        assert_eq!(rotate_key_at(pin, 2.0).map(|key| key.ease), Some(Ease::Hold));
        assert_eq!(scale_key_at(pin, 5.0), None);
    }
}
