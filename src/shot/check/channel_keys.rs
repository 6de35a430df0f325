//! Validates `rotate_keys` and `scale_keys` of pins.
//!
//! In: raw pins. Out: [`ChannelKey`]s; faults where `keys` hold the same channel.

use super::Check;
use super::place::PinKind;
use crate::shot::raw::RawPin;
use crate::shot::{ChannelKey, Rotation};

impl Check<'_> {
    /// Returns the keys of a pin's rotation.
    pub(super) fn rotate_keys(&mut self, raw: &RawPin, pin: &str, kind: &PinKind) -> Vec<ChannelKey<Rotation>> {
        let list = format!("{pin}.rotate_keys");
        self.increasing(raw.rotate_keys.iter().map(|key| key.frame), &list);
        let mut keys = Vec::with_capacity(raw.rotate_keys.len());
        for (index, raw_key) in raw.rotate_keys.iter().enumerate() {
            let key = format!("{list}[{index}]");
            self.ease(raw_key.ease, &key);
            let value = self.rotation(raw_key.value, &format!("{key}.value"), kind);
            keys.push(ChannelKey { frame: raw_key.frame, value, ease: raw_key.ease });
        }
        if !keys.is_empty() {
            self.not_in_keys(pin, "rotate", raw.keys.iter().map(|key| key.rotate.is_some()));
        }
        keys
    }

    /// Returns the keys of a pin's scale.
    pub(super) fn scale_keys(&mut self, raw: &RawPin, pin: &str) -> Vec<ChannelKey<f64>> {
        let list = format!("{pin}.scale_keys");
        self.increasing(raw.scale_keys.iter().map(|key| key.frame), &list);
        let mut keys = Vec::with_capacity(raw.scale_keys.len());
        for (index, raw_key) in raw.scale_keys.iter().enumerate() {
            self.ease(raw_key.ease, &format!("{list}[{index}]"));
            keys.push(ChannelKey { frame: raw_key.frame, value: raw_key.value, ease: raw_key.ease });
        }
        if !keys.is_empty() {
            self.not_in_keys(pin, "scale", raw.keys.iter().map(|key| key.scale.is_some()));
        }
        keys
    }

    /// Reports the `keys` that hold a channel that has keys of its own.
    fn not_in_keys(&mut self, pin: &str, channel: &str, is_held: impl Iterator<Item = bool>) {
        for (index, _) in is_held.enumerate().filter(|(_, is_held)| *is_held) {
            let what = format!("the pin has `{channel}_keys`, which are all keys of this channel");
            let hint = format!("move it there as {{ frame = .., value = .. }}, or remove `{channel}_keys`");
            self.fault(&format!("{pin}.keys[{index}].{channel}"), what, hint);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::shot::{ChannelKey, Ease, Rotation, Shot, ShotError};
    use std::path::Path;

    fn parse(keys: &str, more: &str) -> Result<Shot, ShotError> {
        let text = format!(
            "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n[[layer]]\n[[layer.pin]]\nname = 'p'\n\
             anchor = {{ screen = [0.5, 0.5], frame = 1 }}\n{keys}\n{more}"
        );
        Shot::parse(&text, Path::new("a.toml"))
    }

    #[test]
    fn rotation_and_scale_have_keys_of_their_own_and_are_mirrored() {
        let keys = "rotate_keys = [{ frame = 2.5, value = 20, ease = 'hold' }, { frame = 4, value = -30.5 }]\n\
                    scale_keys = [{ frame = 3, value = 2, ease = { bezier = [0.2, 0, 0.8, 1] } }]";
        let shot = parse(keys, "[[layer.pin]]\nname = 'q'\nmirror = 'p'").expect("a shot");
        let [pin, other] = shot.layers[0].pins.as_slice() else { unreachable!("two pins") };
        let rotation = |frame, degrees, ease| ChannelKey { frame, value: Rotation::InView(degrees), ease };
        assert_eq!(pin.rotate_keys, [rotation(2.5, 20.0, Ease::Hold), rotation(4.0, -30.5, Ease::Linear)]);
        let ease = Ease::Bezier([0.2, 0.0, 0.8, 1.0]);
        assert_eq!(pin.scale_keys, [ChannelKey { frame: 3.0, value: 2.0, ease }]);
        assert_eq!(pin.keys.len(), 1, "it holds its place");
        assert_eq!((&other.rotate_keys, &other.scale_keys), (&pin.rotate_keys, &pin.scale_keys));
    }

    #[test]
    fn faults_name_their_line_and_a_remedy() {
        let world = "lattice = { space = 'world', dims = [4, 4, 4] }\n";
        let cases = [
            (
                "keys = [{ frame = 1, rotate = 5 }]\nrotate_keys = [{ frame = 1, value = 5 }]",
                ["a.toml:7: layer[0].pin[0].keys[0].rotate: ", "remove `rotate_keys`"],
            ),
            (
                "scale_keys = [{ frame = 1, value = 2 }]\nkeys = [{ frame = 1 }, { frame = 2, scale = 2 }]",
                ["a.toml:8: layer[0].pin[0].keys[1].scale: ", "move it there"],
            ),
            (
                "rotate_keys = [{ frame = 3, value = 5 }, { frame = 3, value = 6 }]",
                ["a.toml:7: layer[0].pin[0].rotate_keys[1].frame: ", "in the order of their frames"],
            ),
            (
                "scale_keys = [{ frame = 3, value = 5 }, { frame = 2, value = 6 }]",
                ["layer[0].pin[0].scale_keys[1].frame: ", "does not come after"],
            ),
            ("rotate_keys = [{ frame = 3, value = [1, 2, 3] }]", ["rotate_keys[0].value: ", "on the screen"]),
            (
                "rotate_keys = [{ frame = 3, value = 1, ease = { bezier = [2, 0, 0, 0] } }]",
                ["rotate_keys[0].ease.bezier: ", "x1 and x2"],
            ),
            ("scale_keys = [{ frame = 3, value = 0 }]", ["scale_keys[0].value: ", "from 0.001 to 1000"]),
            ("rotate_keys = [{ frame = 3 }]", ["rotate_keys[0].value: ", "is missing"]),
        ];
        for (keys, parts) in cases {
            let error = parse(keys, "").expect_err(keys).to_string();
            assert!(parts.iter().all(|part| error.contains(part)), "{keys}: {error}");
        }
        let mirrored = "[[layer.pin]]\nname = 'q'\nmirror = 'p'\nrotate_keys = [{ frame = 1, value = 2 }]";
        let error = parse("", mirrored).expect_err("mirrored").to_string();
        assert!(error.contains("pin[1].rotate_keys: a mirrored pin takes this"), "{error}");
        // In the scene one angle or three are allowed, but not both.
        let in_scene = |values: [&str; 2]| {
            let text = format!(
                "scene = 'a.glb'\nframes = {{ first = 1, last = 24 }}\n[[layer]]\n{world}[[layer.pin]]\n\
                 anchor = {{ screen = [0.5, 0.5], frame = 1 }}\n\
                 rotate_keys = [{{ frame = 1, value = {} }}, {{ frame = 2, value = {} }}]",
                values[0], values[1]
            );
            Shot::parse(&text, Path::new("a.toml"))
        };
        assert!(in_scene(["1", "2"]).is_ok() && in_scene(["[1, 2, 3]", "[3, 2, 1]"]).is_ok());
        let error = in_scene(["1", "[3, 2, 1]"]).expect_err("of two kinds").to_string();
        assert!(error.contains("rotate_keys[1].value: ") && error.contains("number of angles"), "{error}");
    }
}
