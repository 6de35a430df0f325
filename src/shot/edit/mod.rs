//! Edits pins in the text of a shot and preserves everything else byte for byte.
//!
//! In: a text and an [`Anchor`]. Out: the new text. The text must be TOML, but need not be a valid shot.

mod block;
#[cfg(feature = "editor")]
mod channel_keys;
#[cfg(any(test, feature = "ofx"))]
mod filter;
#[cfg(any(test, feature = "editor", feature = "ofx"))]
mod layer;
#[cfg(feature = "editor")]
mod move_pin;
#[cfg(feature = "editor")]
mod paths;
#[cfg(any(test, feature = "editor"))]
mod pin;
#[cfg(any(test, feature = "editor"))]
mod rename;
#[cfg(any(test, feature = "editor"))]
mod setting;
#[cfg(any(test, feature = "editor"))]
mod stroke;
mod text;

pub use block::pin_block;
#[cfg(feature = "editor")]
pub(crate) use channel_keys::{put_rotate_keys, put_scale_keys};
#[cfg(any(test, feature = "ofx"))]
pub(crate) use filter::put_filter;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use layer::{Factor, KeyedPin, LayerEdit, put_layer};
#[cfg(feature = "editor")]
pub(crate) use move_pin::move_pin;
#[cfg(feature = "editor")]
pub(crate) use paths::put_paths;
#[cfg(any(test, feature = "editor"))]
pub(crate) use pin::{PinName, put_handle, put_keys, put_region, remove_pin};
#[cfg(feature = "editor")]
pub(crate) use rename::rename_layer;
#[cfg(any(test, feature = "editor"))]
pub(crate) use rename::rename_pin;
#[cfg(any(test, feature = "editor"))]
pub(crate) use setting::Setting;
#[cfg(any(test, feature = "editor"))]
pub(crate) use setting::{
    add_layer, has_pin_setting, layer_number, move_layer, put_box, put_layer_setting, put_pin_setting, put_setting,
    remove_layer,
};

#[cfg(any(test, feature = "editor"))]
pub(crate) use stroke::{add_stroke, remove_strokes};

use super::{Anchor, ShotError};
use block::{Digits, NewPin, anchor_table, resting};
use text::EditableText;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

/// Appends a pin, held at rest by one key without offset, to the layer named `layer`; `None`: the first, which is
/// created if there is none. If the layer has a pin of that name, only its anchor is replaced.
///
/// ```
/// use pinwarp::shot::{Anchor, edit};
/// use pinwarp::space::ScreenPoint;
/// let text = "scene = 'a.glb'\n[[layer]]\nname = 'body' # all of it\n";
/// let anchor = Anchor::Screen { at: ScreenPoint::new(0.5, 0.25), frame: Some(3) };
/// let edited = edit::add_pin(text, Some("body"), "nose", &anchor)?;
/// assert!(edited.starts_with(text));
/// assert!(edited.contains("anchor = { screen = [0.5, 0.25], frame = 3 }"));
/// # Ok::<(), pinwarp::shot::ShotError>(())
/// ```
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, has no such layer, or if `layer` or `pin` is not a list of tables.
pub fn add_pin(text: &str, layer: Option<&str>, name: &str, anchor: &Anchor) -> Result<String, ShotError> {
    let edit = |what: &str, hint: &str| fault(name, what, hint);
    if name.is_empty() {
        return Err(edit("the name is empty", "give a name"));
    }
    let mut text = EditableText::parse(text).map_err(|(what, hint)| edit(&what, hint))?;
    let keys = resting(first_frame(text.document.as_table()));
    let pin = NewPin::anchored(name, anchor_table(anchor, Digits::Few), keys);
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    if is_empty_list(layers) && layer.is_none() {
        append_layer(layers);
    }
    let is_inline = layers.is_value();
    let layer = find(layers, layer, "layer").map_err(|(what, hint)| edit(&what, &hint))?;
    if !layer.contains_key("pin") {
        layer.insert("pin", if is_inline { Item::Value(Array::new().into()) } else { no_tables() });
    }
    put_pin(layer, &pin)?;
    Ok(text.finish())
}

/// Appends a pin that follows the pin `at` with mirrored keys, attached to the mirrored point.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, has no such pin, or a pin named `name` in its layer.
#[cfg(any(test, feature = "editor"))]
pub(crate) fn mirror_pin(text: &str, at: PinName, name: &str) -> Result<String, ShotError> {
    pin::edit_layer(text, at.layer, at.pin, |layer| {
        let not_tables = || fault(name, "`pin` is not a list of tables", "write [[layer.pin]] as in docs/SHOT.md");
        let pins = layer.get_mut("pin").ok_or_else(not_tables)?;
        find(pins, Some(at.pin), "pin").map_err(|(what, hint)| fault(at.pin, &what, &hint))?;
        if find(pins, Some(name), "pin").is_ok() {
            return Err(fault(name, "is there already", "choose another name"));
        }
        append_pin(pins, &NewPin::mirrored(name, at.pin)).ok_or_else(not_tables)
    })
}

fn fault(pin: &str, what: &str, hint: &str) -> ShotError {
    ShotError::Edit { pin: pin.to_owned(), what: what.to_owned(), hint: hint.to_owned() }
}

fn no_tables() -> Item {
    Item::ArrayOfTables(ArrayOfTables::new())
}

/// Returns the frame of the new pin's only key; its choice is arbitrary, as the value holds before and after.
fn first_frame(shot: &Table) -> i64 {
    let frames = shot.get("frames").and_then(Item::as_table_like);
    frames.and_then(|frames| frames.get("first")).and_then(Item::as_integer).unwrap_or(1)
}

fn is_empty_list(list: &Item) -> bool {
    list.as_array_of_tables().is_some_and(ArrayOfTables::is_empty) || list.as_array().is_some_and(Array::is_empty)
}

fn append_layer(layers: &mut Item) {
    let mut layer = Table::new();
    layer.insert("name", toml_edit::value("layer1"));
    match layers {
        Item::ArrayOfTables(layers) => layers.push(layer),
        Item::Value(Value::Array(layers)) => layers.push(layer.into_inline_table()),
        _ => {}
    }
}

/// Returns the tables of a list, inline or not; `None` if it is not a list of tables.
fn tables(list: &mut Item) -> Option<Vec<&mut dyn TableLike>> {
    match list {
        Item::ArrayOfTables(tables) => Some(tables.iter_mut().map(|table| table as &mut dyn TableLike).collect()),
        Item::Value(Value::Array(items)) => {
            items.iter_mut().map(|item| item.as_inline_table_mut().map(|table| table as &mut dyn TableLike)).collect()
        }
        _ => None,
    }
}

/// Returns the name of a table in a list: its `name`, else the default name in a shot.
fn name_of(table: &dyn TableLike, kind: &str, index: usize) -> String {
    let given = table.get("name").and_then(Item::as_str);
    given.map_or_else(|| format!("{kind}{}", index + 1), str::to_owned)
}

type Remedy = (String, String);

/// Returns the table of that name, or the first.
fn find<'a>(list: &'a mut Item, name: Option<&str>, kind: &str) -> Result<&'a mut dyn TableLike, Remedy> {
    let not_tables = (format!("`{kind}` is not a list of tables"), format!("write [[{kind}]] as in docs/SHOT.md"));
    let tables = tables(list).ok_or(not_tables)?;
    let names: Vec<String> = tables.iter().enumerate().map(|(index, table)| name_of(*table, kind, index)).collect();
    let index = name.map_or(Some(0), |name| names.iter().position(|other| other == name));
    let missing = || {
        let wanted = name.unwrap_or_default();
        (format!("there is no {kind} {wanted:?}"), format!("{kind}s here: {}", names.join(", ")))
    };
    index.and_then(|index| tables.into_iter().nth(index)).ok_or_else(missing)
}

/// Writes a pin into a layer that has a list of pins.
fn put_pin(layer: &mut dyn TableLike, pin: &NewPin) -> Result<(), ShotError> {
    let not_tables = || fault(pin.name, "`pin` is not a list of tables", "write [[layer.pin]] as in docs/SHOT.md");
    let pins = layer.get_mut("pin").ok_or_else(not_tables)?;
    if let Ok(existing) = find(pins, Some(pin.name), "pin") {
        if let Some(anchor) = pin.anchor() {
            replace_anchor(existing, anchor.clone());
        }
        return Ok(());
    }
    let is_appended = append_pin(pins, pin);
    is_appended.ok_or_else(not_tables)
}

/// Replaces the anchor, keeping the comment after it.
fn replace_anchor(pin: &mut dyn TableLike, new: InlineTable) {
    match pin.get_mut("anchor") {
        Some(Item::Table(old)) => replace_entries(old, new),
        Some(Item::Value(Value::InlineTable(old))) if old.is_dotted() => replace_entries(old, new),
        Some(Item::Value(old)) => {
            let decor = old.decor().clone();
            *old = Value::InlineTable(new);
            *old.decor_mut() = decor;
        }
        _ => {
            pin.insert("anchor", Item::Value(Value::InlineTable(new)));
        }
    }
}

/// Replaces the entries of `[layer.pin.anchor]` or `anchor.node = ..`, keeping the form, and the comments at common
/// entries.
fn replace_entries(old: &mut dyn TableLike, new: InlineTable) {
    let gone: Vec<String> = old.iter().map(|(key, _)| key.to_owned()).filter(|key| !new.contains_key(key)).collect();
    for key in gone {
        old.remove(&key);
    }
    for (key, mut value) in new {
        let decor = old.get(&key).and_then(Item::as_value).map(|value| value.decor().clone()).unwrap_or_default();
        *value.decor_mut() = decor;
        match old.get_mut(&key) {
            Some(item) => *item = Item::Value(value),
            None => _ = old.insert(&key, Item::Value(value)),
        }
    }
}

/// Appends a pin; `None` if the list is not a list of tables.
fn append_pin(list: &mut Item, pin: &NewPin) -> Option<()> {
    match list {
        Item::ArrayOfTables(pins) => {
            let last = pins.len().checked_sub(1).and_then(|last| pins.get(last));
            let indent = last.map_or("  ".to_owned(), text::indent_of);
            pins.push(pin.table(&indent));
        }
        Item::Value(Value::Array(pins)) if pins.iter().all(Value::is_inline_table) => {
            let last = pins.len().checked_sub(1).and_then(|last| pins.get(last));
            let prefix = last.and_then(|pin| pin.decor().prefix()?.as_str()).unwrap_or(" ").to_owned();
            pins.push_formatted(Value::InlineTable(pin.inline()).decorated(prefix, ""));
        }
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_mirrored_pin_names_the_one_it_follows() -> Result<(), crate::shot::ShotError> {
        use crate::shot::edit;
        let text =
            "[[layer]]\nname = 'body'\n[[layer.pin]]\nname = 'hand.L'\nanchor = { screen = [0.5, 0.5], frame = 1 }\n";
        let edited = edit::mirror_pin(text, edit::PinName { layer: "body", pin: "hand.L" }, "hand.R")?;
        assert!(edited.contains("name   = \"hand.R\"\nmirror = \"hand.L\""), "{edited}");
        Ok(())
    }
}
