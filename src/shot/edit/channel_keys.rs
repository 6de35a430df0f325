//! Edits the keys that rotation or scale of a pin has of its own in the text of a shot.
//!
//! In: a text, a pin, keys. Out: the new text. Keys whose frames are kept preserve their comments and entry order.

use super::block::{Digits, numbers};
use super::layer::{put_ease, tables_array};
use super::pin::{PinName, edit_pin, frame, put_key_tables};
use crate::shot::{ChannelKey, Rotation, ShotError};
use toml_edit::{InlineTable, Item, TableLike, Value};

/// Sets the keys of a pin's rotation; without any, its `keys` hold the rotation.
///
/// # Errors
/// As [`put_keys`](super::put_keys).
pub(crate) fn put_rotate_keys(text: &str, at: PinName, keys: &[ChannelKey<Rotation>]) -> Result<String, ShotError> {
    put(text, at, ("rotate_keys", keys), |rotation| match rotation {
        Rotation::InView(angle) => angle.into(),
        Rotation::Axes(angles) => numbers(&angles, Digits::All),
    })
}

/// Sets the keys of a pin's scale; without any, its `keys` hold the scale.
///
/// # Errors
/// As [`put_keys`](super::put_keys).
pub(crate) fn put_scale_keys(text: &str, at: PinName, keys: &[ChannelKey<f64>]) -> Result<String, ShotError> {
    put(text, at, ("scale_keys", keys), Value::from)
}

fn put<V: Copy>(
    text: &str,
    at: PinName,
    (list, keys): (&str, &[ChannelKey<V>]),
    write: impl Fn(V) -> Value,
) -> Result<String, ShotError> {
    edit_pin(text, at, |pin| {
        if keys.is_empty() {
            pin.remove(list);
            return;
        }
        let table = |key: &ChannelKey<V>| {
            let mut table = InlineTable::new();
            table.insert("frame", frame(key.frame));
            table.insert("value", write(key.value));
            put_ease(&mut table, key.ease);
            table
        };
        if pin.contains_key(list) {
            let tables: Vec<_> = keys.iter().map(|key| (key.frame, table(key))).collect();
            return put_key_tables(pin, list, &tables);
        }
        let indent = indent_of_keys(pin).unwrap_or_default();
        let tables = tables_array(keys.iter().map(table).collect(), indent.len() + list.len() + " = [ ".len());
        pin.insert(list, Item::Value(tables.into()));
        if let Some(mut key) = pin.key_mut(list) {
            key.leaf_decor_mut().set_prefix(indent);
        }
    })
}

/// Returns the white space before the first key of a table.
fn indent_of_keys(table: &dyn TableLike) -> Option<String> {
    let (first, _) = table.iter().next()?;
    let prefix = table.key(first)?.leaf_decor().prefix()?.as_str()?;
    let indent = prefix.rsplit('\n').next().unwrap_or_default();
    indent.trim().is_empty().then(|| indent.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shot::Ease;

    const PIN: PinName<'static> = PinName { layer: "a", pin: "p" };

    #[test]
    fn keys_of_a_channel_are_added_changed_and_removed_alone() {
        let text = "[[layer]]\nname = 'a'\n  [[layer.pin]]\n  name   = 'p' # it\n  keys   = [ { frame = 1 } ] # mine\n";
        let key = |frame, value, ease| ChannelKey { frame, value: Rotation::InView(value), ease };
        let added = put_rotate_keys(text, PIN, &[key(1.0, 20.0, Ease::Smooth), key(4.5, -7.25, Ease::Linear)]);
        let added = added.expect("a pin");
        let wanted = "  rotate_keys = [ { frame = 1, value = 20.0, ease = \"smooth\" },\n                  \
                      { frame = 4.5, value = -7.25 } ]\n";
        assert_eq!(added, format!("{text}{wanted}"));
        let commented = added.replace("value = 20.0,", "value = 20,").replace("-7.25 } ]", "-7.25 } ] # turns");
        let changed = put_rotate_keys(&commented, PIN, &[key(1.0, 20.0, Ease::Smooth), key(4.5, 8.0, Ease::Linear)]);
        assert_eq!(changed.expect("a pin"), commented.replace("-7.25", "8.0"));
        let removed = put_rotate_keys(&commented, PIN, &[]).expect("a pin");
        assert_eq!(removed, text);
    }

    #[test]
    fn angles_about_axes_and_scales_are_read_back_bit_for_bit() {
        let text = "scene = 'a.glb'\n[[layer]]\nname = 'a'\nlattice = { space = 'world', dims = [4, 4, 4] }\n\
                    pin = [{ name = 'p', anchor = { screen = [0.5, 0.5], frame = 1 } }]\n";
        let text = format!("frames = {{ first = 1, last = 9 }}\n{text}");
        let rotations = [ChannelKey { frame: 2.0, value: Rotation::Axes([0.1, 1.0 / 3.0, -720.0]), ease: Ease::Hold }];
        let scales = [ChannelKey { frame: 3.25, value: 1.0 / 7.0, ease: Ease::Bezier([0.1, 0.2, 0.3, 1.4]) }];
        let both = put_rotate_keys(&text, PIN, &rotations).and_then(|text| put_scale_keys(&text, PIN, &scales));
        let shot = crate::shot::Shot::parse(&both.expect("a pin"), "a.toml".as_ref()).expect("a shot");
        let pin = &shot.layers[0].pins[0];
        assert_eq!((pin.rotate_keys.as_slice(), pin.scale_keys.as_slice()), (&rotations[..], &scales[..]));
    }

    #[test]
    fn keys_that_hold_all_channels_replace_those_of_each() {
        let text = "[[layer]]\nname = 'a'\n  [[layer.pin]]\n  name = 'p'\n  keys = [ { frame = 1 } ]\n  \
                    rotate_keys = [ { frame = 1, value = 2 } ]\n  scale_keys = [ { frame = 1, value = 2 } ]\n";
        let key = crate::shot::PinKey {
            frame: 3.0,
            goal: crate::shot::Goal::Offset(crate::space::ScreenVector::default()),
            rotate_degrees: Some(Rotation::InView(5.0)),
            scale: None,
            ease: Ease::Linear,
        };
        let edit = super::super::LayerEdit {
            dims: [5, 5],
            basis: crate::lattice::Basis::default(),
            strength: super::super::Factor::Exactly(1.0),
            smoothness: super::super::Factor::Exactly(1.0),
            pins: &[super::super::KeyedPin { name: "p", anchor: None, keys: vec![key] }],
        };
        let baked = super::super::put_layer(text, Some("a"), &edit).expect("a layer");
        assert!(baked.contains("rotate = 5.0") && !baked.contains("_keys"), "{baked}");
    }
}
