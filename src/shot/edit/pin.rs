//! Edits one pin or handle in the text of a shot: keys, name, region, removal.
//!
//! In: a text, names, new values. Out: the new text. Keys whose frames are kept preserve their comments and entry
//! order.

use super::block::{Digits, numbers};
use super::layer::{key_table, replace};
use super::text::EditableText;
use super::{fault, find, no_tables, tables};
use crate::shot::{HandleKey, PinKey, PinRegion, ShotError};
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

/// A pin, identified by the names of layer and pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PinName<'a> {
    /// Its layer.
    pub layer: &'a str,
    /// Its name in that layer.
    pub pin: &'a str,
}

/// Sets the keys of a pin, in frame heights.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML or has no such pin.
pub(crate) fn put_keys(text: &str, at: PinName, keys: &[PinKey]) -> Result<String, ShotError> {
    edit_pin(text, at, |pin| {
        let new: Vec<(f64, InlineTable)> = keys.iter().map(|key| (key.frame, key_table(key))).collect();
        put_key_tables(pin, "keys", &new);
    })
}

/// Sets the region that a pin carries; `None`: only its point.
///
/// # Errors
/// As [`put_keys`].
pub(crate) fn put_region(text: &str, at: PinName, region: Option<PinRegion>) -> Result<String, ShotError> {
    edit_pin(text, at, |pin| match region {
        None => _ = pin.remove("region"),
        Some(PinRegion { radius, rigidity, stiffness }) => {
            let mut table = InlineTable::new();
            for (key, value) in [("radius", radius), ("rigidity", rigidity), ("stiffness", stiffness)] {
                table.insert(key, few(value));
            }
            replace(pin, "region", Value::InlineTable(table));
        }
    })
}

/// Removes a pin.
///
/// # Errors
/// As [`put_keys`].
pub(crate) fn remove_pin(text: &str, at: PinName) -> Result<String, ShotError> {
    edit_layer(text, at.layer, at.pin, |layer| {
        let pins = layer.get_mut("pin").ok_or_else(|| missing(at.pin))?;
        let names = tables(pins).unwrap_or_default();
        let index = names.iter().enumerate().position(|(index, pin)| super::name_of(*pin, "pin", index) == at.pin);
        take_out(pins, index.ok_or_else(|| missing(at.pin))?);
        Ok(())
    })
}

/// Sets the keys of a handle; without keys the handle is removed.
///
/// # Errors
/// As [`put_keys`].
pub(crate) fn put_handle(text: &str, layer: &str, index: &[usize], keys: &[HandleKey]) -> Result<String, ShotError> {
    edit_layer(text, layer, "handle", |layer| {
        let handles = layer.entry("handle").or_insert_with(no_tables);
        let is_this = |table: &&mut dyn TableLike| -> bool {
            let list = table.get("index").and_then(Item::as_array);
            let places = list.map(|list| list.iter().filter_map(Value::as_integer).map(|place| place as usize));
            places.is_some_and(|places| places.collect::<Vec<_>>() == index)
        };
        let known = tables(handles).and_then(|tables| tables.iter().position(is_this));
        match (known, keys.is_empty()) {
            (Some(place), true) => take_out(handles, place),
            (None, true) => {}
            (place, false) => {
                let place = match place {
                    Some(place) => place,
                    None => append_handle(handles, index).ok_or_else(|| missing("handle"))?,
                };
                let new: Vec<_> = keys.iter().map(|key| (key.frame, handle_key(key, index.len()))).collect();
                let table = tables(handles).and_then(|tables| tables.into_iter().nth(place));
                put_key_tables(table.ok_or_else(|| missing("handle"))?, "keys", &new);
            }
        }
        if tables(handles).is_some_and(|tables| tables.is_empty()) {
            layer.remove("handle");
        }
        Ok(())
    })
}

pub(super) fn missing(name: &str) -> ShotError {
    fault(name, "it is not in the file, or not written as a list of tables", "reload the file")
}

pub(super) fn few(value: f64) -> Value {
    match numbers(&[value], Digits::Few) {
        Value::Array(list) => list.get(0).cloned().unwrap_or_else(|| value.into()),
        other => other,
    }
}

pub(super) fn edit_pin(text: &str, at: PinName, edit: impl FnOnce(&mut dyn TableLike)) -> Result<String, ShotError> {
    edit_layer(text, at.layer, at.pin, |layer| {
        let pins = layer.get_mut("pin").ok_or_else(|| missing(at.pin))?;
        edit(find(pins, Some(at.pin), "pin").map_err(|(what, hint)| fault(at.pin, &what, &hint))?);
        Ok(())
    })
}

pub(super) fn edit_layer(
    text: &str,
    layer: &str,
    name: &str,
    edit: impl FnOnce(&mut dyn TableLike) -> Result<(), ShotError>,
) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(name, &what, hint))?;
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    edit(find(layers, Some(layer), "layer").map_err(|(what, hint)| fault(name, &what, &hint))?)?;
    Ok(text.finish())
}

fn take_out(list: &mut Item, index: usize) {
    match list {
        Item::ArrayOfTables(tables) => _ = tables.remove(index),
        Item::Value(Value::Array(tables)) => _ = tables.remove(index),
        _ => {}
    }
}

/// Appends a handle and returns its place in the list.
fn append_handle(list: &mut Item, index: &[usize]) -> Option<usize> {
    let place: Array = index.iter().map(|&place| place as i64).collect();
    match list {
        Item::ArrayOfTables(tables) => {
            let mut table = Table::new();
            table.insert("index", Item::Value(place.into()));
            indent(&mut table, tables);
            tables.push(table);
            Some(tables.len() - 1)
        }
        Item::Value(Value::Array(tables)) => {
            tables.push(InlineTable::from_iter([("index", Value::Array(place))]));
            Some(tables.len() - 1)
        }
        _ => None,
    }
}

fn indent(table: &mut Table, list: &ArrayOfTables) {
    let last = list.len().checked_sub(1).and_then(|last| list.get(last));
    let indent = last.map_or("  ".to_owned(), super::text::indent_of);
    table.decor_mut().set_prefix(format!("\n{indent}"));
    if let Some(mut key) = table.key_mut("index") {
        key.leaf_decor_mut().set_prefix(indent);
    }
}

fn handle_key(key: &HandleKey, axes: usize) -> InlineTable {
    let mut table = InlineTable::new();
    table.insert("frame", frame(key.frame));
    table.insert("offset", numbers(&key.offset[..axes.min(3)], Digits::Few));
    super::layer::put_ease(&mut table, key.ease);
    table
}

pub(super) fn frame(frame: f64) -> Value {
    if frame.fract() == 0.0 { (frame as i64).into() } else { frame.into() }
}

/// Updates a list of keys to these, frame by frame; entries that are kept preserve their formatting.
pub(super) fn put_key_tables(table: &mut dyn TableLike, name: &str, keys: &[(f64, InlineTable)]) {
    let is_list = table.get(name).and_then(Item::as_array).is_some_and(|list| list.iter().all(Value::is_inline_table));
    if !is_list {
        let mut list = Array::new();
        keys.iter().enumerate().for_each(|(place, (_, key))| insert(&mut list, place, key.clone()));
        replace(table, name, list.into());
        return;
    }
    let Some(list) = table.get_mut(name).and_then(Item::as_array_mut) else { return };
    let frame_of = |value: &Value| {
        let frame = value.as_inline_table().and_then(|key| key.get("frame"));
        frame.and_then(|frame| frame.as_float().or_else(|| frame.as_integer().map(|whole| whole as f64)))
    };
    for place in (0..list.len()).rev() {
        let is_kept = list.get(place).and_then(frame_of).is_some_and(|at| keys.iter().any(|(frame, _)| *frame == at));
        if !is_kept {
            list.remove(place);
        }
    }
    for (place, (frame, key)) in keys.iter().enumerate() {
        if list.get(place).and_then(frame_of) != Some(*frame) {
            insert(list, place, key.clone());
        } else if let Some(old) = list.get_mut(place).and_then(Value::as_inline_table_mut) {
            update(old, key);
        }
    }
    // The formatting of the last entry differs from that of the others, and entries may have become or ceased to be the
    // last.
    let last = list.len().saturating_sub(1);
    for (place, key) in list.iter_mut().enumerate() {
        let suffix = key.decor().suffix().and_then(|suffix| suffix.as_str()).unwrap_or_default().to_owned();
        if suffix.trim().is_empty() {
            key.decor_mut().set_suffix(if place == last { " " } else { "" });
        }
    }
}

/// Inserts a key on a line of its own, except for the first.
fn insert(list: &mut Array, place: usize, key: InlineTable) {
    let beside = list.get(place.saturating_sub(1)).or_else(|| list.get(place)).filter(|_| place > 0);
    let prefix = beside.and_then(|key| key.decor().prefix()?.as_str()).filter(|prefix| prefix.contains('\n'));
    let prefix = match (place, prefix) {
        (0, _) => " ".to_owned(),
        (_, Some(prefix)) if prefix.trim().is_empty() => prefix.to_owned(),
        _ => "\n             ".to_owned(),
    };
    if place == 0
        && let Some(first) = list.get_mut(0)
    {
        first.decor_mut().set_prefix("\n             ");
    }
    list.insert_formatted(place, Value::InlineTable(key).decorated(prefix, ""));
}

/// Updates the entries; equal values keep their spelling.
fn update(old: &mut InlineTable, new: &InlineTable) {
    let gone: Vec<String> = old.iter().map(|(key, _)| key.to_owned()).filter(|key| !new.contains_key(key)).collect();
    for key in gone {
        old.remove(&key);
    }
    for (key, value) in new {
        match old.get_mut(key) {
            Some(there) if means_same(there, value) => {}
            Some(there) => {
                let decor = there.decor().clone();
                *there = value.clone();
                *there.decor_mut() = decor;
            }
            None => _ = old.insert(key, value.clone()),
        }
    }
}

/// Returns whether two values are equal as numbers or text, regardless of spelling.
fn means_same(a: &Value, b: &Value) -> bool {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| means_same(a, b))
        }
        (Value::InlineTable(a), Value::InlineTable(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| means_same(a, b)))
        }
        _ if number(a).is_some() => number(a) == number(b),
        _ => a.as_str().is_some() && a.as_str() == b.as_str() || a.as_bool().is_some() && a.as_bool() == b.as_bool(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn keys_are_replaced_in_place() -> Result<(), crate::shot::ShotError> {
        use crate::shot::{Ease, Goal, PinKey, edit};
        use crate::space::ScreenVector;
        let text =
            "[[layer]]\nname = 'a'\n[[layer.pin]]\nname = 'p'\nkeys = [ { frame = 1, offset = [0, 0] } ] # mine\n";
        let key = PinKey {
            frame: 1.0,
            goal: Goal::Offset(ScreenVector::new(0.5, 0.0)),
            rotate_degrees: None,
            scale: None,
            ease: Ease::Linear,
        };
        let edited = edit::put_keys(text, edit::PinName { layer: "a", pin: "p" }, &[key])?;
        assert!(edited.contains("keys = [ { frame = 1, offset = [0.5, 0.0] } ] # mine"), "{edited}");
        Ok(())
    }
}
