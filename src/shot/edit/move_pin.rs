//! Moves a pin to another layer in the text of a shot, with the pins that follow it.
//!
//! In: a text, names. Out: the new text; the pin keeps its comments.

use super::pin::{PinName, missing};
use super::rename::rename_followed;
use super::text::EditableText;
use super::{fault, find, no_tables, tables};
use crate::shot::ShotError;
use crate::shot::edit::layer::replace;
use toml_edit::{InlineTable, Item, Table, Value};

/// Moves a pin to the end of another layer.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, has no such pin or layer, or does not write its pins as `[[layer.pin]]`.
pub(crate) fn move_pin(text: &str, at: PinName, layer: &str) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(at.pin, &what, hint))?;
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    let found = |(what, hint): (String, String)| fault(at.pin, &what, &hint);
    let from = find(layers, Some(at.layer), "layer").map_err(found)?;
    let pins = from.get_mut("pin").ok_or_else(|| missing(at.pin))?;
    // Within a layer the name of the pin alone is enough.
    for pin in tables(pins).unwrap_or_default() {
        if pin.get("mirror").and_then(Item::as_str) == Some(at.pin) {
            replace(pin, "mirror", followed(layer, at.pin));
        }
    }
    let names = tables(pins).unwrap_or_default();
    let place = names.iter().enumerate().position(|(index, pin)| super::name_of(*pin, "pin", index) == at.pin);
    let (place, pins) = place.zip(pins.as_array_of_tables_mut()).ok_or_else(|| missing(at.pin))?;
    let mut pin = pins.get(place).cloned().ok_or_else(|| missing(at.pin))?;
    pins.remove(place);
    if let Some(of) = pin.get("mirror").and_then(Item::as_str).map(str::to_owned) {
        replace(&mut pin, "mirror", followed(at.layer, &of));
    }
    // Its default name depends on its place.
    replace(&mut pin, "name", at.pin.into());
    unplaced(&mut pin);
    let to = find(layers, Some(layer), "layer").map_err(found)?;
    let pins = to.entry("pin").or_insert_with(no_tables);
    pins.as_array_of_tables_mut().ok_or_else(|| missing(at.pin))?.push(pin);
    rename_followed(layers, &[("layer", at.layer), ("pin", at.pin)], ("layer", layer));
    Ok(text.finish())
}

fn followed(layer: &str, pin: &str) -> Value {
    Value::InlineTable(InlineTable::from_iter([("layer", layer), ("pin", pin)]))
}

/// Lets a table, and those in it, be written where they are in the document and no longer where they were.
fn unplaced(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        if let Item::Table(table) = item {
            unplaced(table);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_moves_with_its_comments_and_is_followed_there() {
        let text = "[[layer]]
name = 'all'

  [[layer.pin]]
  name = 'hand.L' # mine
  keys = [ { frame = 1, offset = [0, 0] } ] # here

  [[layer.pin]]
  name = 'hand.R'
  mirror = 'hand.L'

  [[layer.pin]]
  name = 'foot'

[[layer]]
name = 'arm'

[output]
path = 'a.####.exr'
";
        let at = |pin| PinName { layer: "all", pin };
        let moved = move_pin(text, at("hand.L"), "arm").expect("it is there");
        let wanted = text
            .replace("\n  [[layer.pin]]\n  name = 'hand.L' # mine\n  keys = [ { frame = 1, offset = [0, 0] } ] # here\n", "")
            .replace("mirror = 'hand.L'", "mirror = { layer = \"arm\", pin = \"hand.L\" }")
            .replace(
                "name = 'arm'\n",
                "name = 'arm'\n\n  [[layer.pin]]\n  name = \"hand.L\" # mine\n  keys = [ { frame = 1, offset = [0, 0] } ] # here\n",
            );
        assert_eq!(moved, wanted);
        let both = move_pin(&moved, at("hand.R"), "arm").expect("it is there");
        assert!(both.contains("mirror = { layer = \"arm\", pin = \"hand.L\" }"), "{both}");
        assert!(both.find("hand.R") > both.find("name = 'arm'"), "{both}");
        // The one that is followed leaves later.
        let moved = move_pin(text, at("hand.R"), "arm").expect("it is there");
        assert!(moved.contains("mirror = { layer = \"all\", pin = \"hand.L\" }"), "{moved}");
        let both = move_pin(&moved, at("hand.L"), "arm").expect("it is there");
        assert!(both.contains("mirror = { layer = \"arm\", pin = \"hand.L\" }"), "{both}");
        assert!(move_pin(text, at("head"), "arm").is_err() && move_pin(text, at("foot"), "leg").is_err());
    }
}
