//! Renames pins and layers in the text of a shot, with the pins that follow them.
//!
//! In: a text, names. Out: the new text.

use super::layer::replace;
use super::pin::{PinName, missing};
use super::text::EditableText;
use super::{fault, find, no_tables, tables};
use crate::shot::ShotError;
use toml_edit::Item;

/// Renames a pin.
///
/// # Errors
/// As [`put_keys`](super::put_keys), and if the name is empty.
pub(crate) fn rename_pin(text: &str, at: PinName, name: &str) -> Result<String, ShotError> {
    edit_layers(text, (at.pin, name), |layers| {
        let layer = find(layers, Some(at.layer), "layer").map_err(|(what, hint)| fault(at.pin, &what, &hint))?;
        let pins = layer.get_mut("pin").ok_or_else(|| missing(at.pin))?;
        let pin = find(pins, Some(at.pin), "pin").map_err(|(what, hint)| fault(at.pin, &what, &hint))?;
        replace(pin, "name", name.into());
        for pin in tables(pins).unwrap_or_default() {
            if pin.get("mirror").and_then(Item::as_str) == Some(at.pin) {
                replace(pin, "mirror", name.into());
            }
        }
        rename_followed(layers, &[("layer", at.layer), ("pin", at.pin)], ("pin", name));
        Ok(())
    })
}

/// Renames a layer.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML or has no such layer, or if the name is empty.
#[cfg(feature = "editor")]
pub(crate) fn rename_layer(text: &str, layer: &str, name: &str) -> Result<String, ShotError> {
    edit_layers(text, (layer, name), |layers| {
        let own = find(layers, Some(layer), "layer").map_err(|(what, hint)| fault(layer, &what, &hint))?;
        replace(own, "name", name.into());
        rename_followed(layers, &[("layer", layer)], ("layer", name));
        Ok(())
    })
}

fn edit_layers(
    text: &str,
    (old, new): (&str, &str),
    edit: impl FnOnce(&mut Item) -> Result<(), ShotError>,
) -> Result<String, ShotError> {
    if new.trim().is_empty() {
        return Err(fault(old, "the new name is empty", "give a name"));
    }
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(old, &what, hint))?;
    edit(text.document.entry("layer").or_insert_with(no_tables))?;
    Ok(text.finish())
}

/// Replaces a name in `mirror = { layer = "..", pin = ".." }` of all pins whose `mirror` has these names.
pub(super) fn rename_followed(layers: &mut Item, names: &[(&str, &str)], (key, name): (&str, &str)) {
    for layer in tables(layers).unwrap_or_default() {
        for pin in layer.get_mut("pin").and_then(tables).unwrap_or_default() {
            let Some(mirror) = pin.get_mut("mirror").and_then(Item::as_table_like_mut) else { continue };
            let has = |&(key, name): &(&str, &str)| mirror.get(key).and_then(Item::as_str) == Some(name);
            if names.iter().all(has) {
                replace(mirror, key, name.into());
            }
        }
    }
}

#[cfg(all(test, feature = "editor"))]
mod tests {
    use super::*;

    const TEXT: &str = "[[layer]]
name = \"left\"
[[layer.pin]]
name = \"hand\"
[[layer.pin]]
name = \"thumb\"
mirror = \"hand\"
[[layer]]
name = \"right\"
[[layer.pin]]
name = \"hand\"
mirror = { layer = \"left\", pin = \"hand\" } # the other one
[[layer.pin]]
name = \"foot\"
mirror = { layer = \"far\", pin = \"hand\" }
";

    #[test]
    fn pins_follow_a_pin_and_a_layer_under_their_new_names() {
        let renamed = rename_pin(TEXT, PinName { layer: "left", pin: "hand" }, "fist").expect("it is there");
        let wanted = TEXT
            .replacen("\"hand\"", "\"fist\"", 2)
            .replace("{ layer = \"left\", pin = \"hand\" }", "{ layer = \"left\", pin = \"fist\" }");
        assert_eq!(renamed, wanted);
        assert_eq!(rename_layer(TEXT, "left", "near").expect("it is there"), TEXT.replace("\"left\"", "\"near\""));
        assert!(rename_layer(TEXT, "left", " ").is_err() && rename_layer(TEXT, "up", "near").is_err());
    }
}
