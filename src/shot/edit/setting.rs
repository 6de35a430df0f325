//! Edits single values of a shot or a layer, and the order of layers, in the text of a shot.
//!
//! In: a text, a key, a value. Out: the new text; everything else is preserved, comments included.

use super::layer::{replace, sub_table};
use super::pin::{PinName, edit_layer, edit_pin};
use super::text::EditableText;
use super::{fault, find, no_tables, tables};
use crate::shot::ShotError;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

/// A value in a shot file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Setting {
    /// The default: the key is removed.
    Default,
    /// A number.
    Number(f64),
    /// An integer.
    Whole(i64),
    /// A string or a path.
    Text(String),
    /// A boolean.
    Flag(bool),
    /// A list of integers.
    Wholes(Vec<i64>),
    /// A list of strings.
    Texts(Vec<String>),
}

impl Setting {
    fn value(&self) -> Option<Value> {
        match self {
            Self::Default => None,
            Self::Number(number) => Some((*number).into()),
            Self::Whole(number) => Some((*number).into()),
            Self::Text(text) => Some(text.as_str().into()),
            Self::Flag(flag) => Some((*flag).into()),
            Self::Wholes(list) => Some(Value::Array(list.iter().copied().collect::<Array>())),
            Self::Texts(list) => Some(Value::Array(list.iter().map(String::as_str).collect::<Array>())),
        }
    }
}

/// Sets a value of the shot: a key, or a key in a table, such as `["frames", "last"]`.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, or a parent of the key is not a table.
pub(crate) fn put_setting(text: &str, key: &[&str], setting: &Setting) -> Result<String, ShotError> {
    let name = key.join(".");
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(&name, &what, hint))?;
    put(text.document.as_table_mut(), key, setting).ok_or_else(|| not_table(&name))?;
    Ok(text.finish())
}

/// Sets a value of a layer, as [`put_setting`] does.
///
/// # Errors
/// As [`put_setting`], and if there is no such layer.
pub(crate) fn put_layer_setting(text: &str, layer: &str, key: &[&str], setting: &Setting) -> Result<String, ShotError> {
    edit_layer(text, layer, layer, |table| put(table, key, setting).ok_or_else(|| not_table(&key.join("."))))
}

/// Fixes the rest box of a layer's lattice: left, bottom, right, top; in the scene x0, y0, z0, x1, y1, z1.
///
/// # Errors
/// As [`put_layer_setting`].
pub(crate) fn put_box(text: &str, layer: &str, corners: &[f64]) -> Result<String, ShotError> {
    edit_layer(text, layer, layer, |table| {
        let lattice = sub_table(table, "lattice").ok_or_else(|| not_table("lattice.box"))?;
        let fixed = InlineTable::from_iter([("fixed", Value::Array(corners.iter().copied().collect::<Array>()))]);
        replace(lattice, "box", Value::InlineTable(fixed));
        Ok(())
    })
}

/// Sets a single value of a pin: `weight`, `mute`.
///
/// # Errors
/// As [`put_setting`], and if there is no such pin.
pub(crate) fn put_pin_setting(text: &str, at: PinName, key: &str, setting: &Setting) -> Result<String, ShotError> {
    edit_pin(text, at, |pin| match setting.value() {
        Some(value) => replace(pin, key, value),
        None => _ = pin.remove(key),
    })
}

/// Returns whether a pin's table has a key of its own.
#[must_use]
pub(crate) fn has_pin_setting(text: &str, at: PinName, key: &str) -> bool {
    let mut is_there = false;
    let found = edit_pin(text, at, |pin| is_there = pin.contains_key(key));
    found.is_ok() && is_there
}

/// Returns a number in a layer's table; `None` if it is not set.
#[must_use]
pub(crate) fn layer_number(text: &str, layer: &str, key: &[&str]) -> Option<f64> {
    let mut text = EditableText::parse(text).ok()?;
    let table = find(text.document.get_mut("layer")?, Some(layer), "layer").ok()?;
    let (first, rest) = key.split_first()?;
    let value = rest.iter().try_fold(table.get(first)?, |value, key| value.get(key))?;
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn not_table(name: &str) -> ShotError {
    fault(name, "a parent key is not a table", "write it as in docs/SHOT.md")
}

fn put(table: &mut dyn TableLike, key: &[&str], setting: &Setting) -> Option<()> {
    match (key, setting.value()) {
        ([key], Some(value)) => replace(table, key, value),
        ([key], None) => _ = table.remove(key),
        ([first, ..], None) if !table.contains_key(first) => {}
        ([first, rest @ ..], _) => put(sub_table(table, first)?, rest, setting)?,
        ([], _) => {}
    }
    Some(())
}

/// Appends a layer that moves these nodes.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, or its layers are not a list of tables.
pub(crate) fn add_layer(text: &str, name: &str, nodes: &[String]) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(name, &what, hint))?;
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    let mut table = Table::new();
    table.insert("name", toml_edit::value(name));
    if !nodes.is_empty() {
        table.insert("nodes", Item::Value(Value::Array(nodes.iter().map(String::as_str).collect::<Array>())));
    }
    match layers {
        Item::ArrayOfTables(layers) => {
            table.decor_mut().set_prefix("\n");
            layers.push(table);
        }
        Item::Value(Value::Array(layers)) => layers.push(table.into_inline_table()),
        _ => return Err(not_table("layer")),
    }
    Ok(text.finish())
}

/// Removes a layer.
///
/// # Errors
/// As [`add_layer`], and if there is no such layer.
pub(crate) fn remove_layer(text: &str, name: &str) -> Result<String, ShotError> {
    reorder(text, name, |order, at| _ = order.remove(at))
}

/// Moves a layer to another index; of nodes named by several layers, later layers take them from earlier ones.
///
/// # Errors
/// As [`remove_layer`].
pub(crate) fn move_layer(text: &str, name: &str, to: usize) -> Result<String, ShotError> {
    reorder(text, name, |order, at| {
        let layer = order.remove(at);
        order.insert(to.min(order.len()), layer);
    })
}

fn reorder(text: &str, name: &str, change: impl FnOnce(&mut Vec<usize>, usize)) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(name, &what, hint))?;
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    let names: Vec<String> = tables(layers)
        .ok_or_else(|| not_table("layer"))?
        .iter()
        .enumerate()
        .map(|(index, table)| super::name_of(*table, "layer", index))
        .collect();
    let at = names.iter().position(|other| other == name);
    let at = at.ok_or_else(|| fault(name, "there is no such layer", "reload the file"))?;
    let mut order: Vec<usize> = (0..names.len()).collect();
    change(&mut order, at);
    match layers {
        Item::ArrayOfTables(layers) => {
            let mut old: Vec<Table> = layers.iter().cloned().collect();
            // Tables are written in the order of their original positions.
            let places: Vec<Option<isize>> = old.iter().map(Table::position).collect();
            let mut new = ArrayOfTables::new();
            for (place, &from) in order.iter().enumerate() {
                let mut table = std::mem::take(&mut old[from]);
                shift(&mut table, places[place]);
                new.push(table);
            }
            *layers = new;
        }
        Item::Value(Value::Array(layers)) => {
            let old: Vec<Value> = layers.iter().cloned().collect();
            *layers = order.iter().map(|&from| old[from].clone()).collect();
        }
        _ => return Err(not_table("layer")),
    }
    Ok(text.finish())
}

/// Sets the position at which a table and everything below it is written.
fn shift(table: &mut Table, place: Option<isize>) {
    table.set_position(place);
    for (_, item) in table.iter_mut() {
        match item {
            Item::Table(table) => shift(table, place),
            Item::ArrayOfTables(tables) => tables.iter_mut().for_each(|table| shift(table, place)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_setting_is_replaced_in_place() -> Result<(), crate::shot::ShotError> {
        use crate::shot::edit::{Setting, put_setting};
        let text = "frames = { first = 1, last = 24 } # all\n";
        let edited = put_setting(text, &["frames", "last"], &Setting::Whole(48))?;
        assert_eq!(edited, "frames = { first = 1, last = 48 } # all\n");
        Ok(())
    }

    #[test]
    fn a_setting_of_a_pin_is_added_and_removed() -> Result<(), crate::shot::ShotError> {
        use crate::shot::edit::{PinName, Setting, put_pin_setting};
        let text = "[[layer]]\nname = 'a'\n[[layer.pin]]\nname = 'p' # mine\n";
        let at = PinName { layer: "a", pin: "p" };
        let edited = put_pin_setting(text, at, "mute", &Setting::Flag(true))?;
        assert_eq!(edited, "[[layer]]\nname = 'a'\n[[layer.pin]]\nname = 'p' # mine\nmute = true\n");
        assert_eq!(put_pin_setting(&edited, at, "mute", &Setting::Default)?, text);
        Ok(())
    }
}
