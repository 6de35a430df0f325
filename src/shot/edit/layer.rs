//! Writes a layer's lattice and keyed pins into the text of a shot.
//!
//! In: a text, the new values. Out: the new text; everything else is preserved, comments included.

use super::block::{Digits, NewPin, anchor_table, numbers};
use super::text::EditableText;
use super::{append_layer, append_pin, fault, find, is_empty_list, no_tables, replace_anchor, tables};
use crate::lattice::Basis;
use crate::shot::{Anchor, Ease, Goal, PinKey, Rotation, ShotError};
use serde::Serialize;
use std::collections::HashMap;
use toml_edit::ser::ValueSerializer;
use toml_edit::{Array, InlineTable, Item, TableLike, Value};

/// The values to write to a layer.
#[derive(Clone, Debug)]
pub(crate) struct LayerEdit<'a> {
    /// Number of handles across and up.
    pub dims: [usize; 2],
    /// Basis of the lattice.
    pub basis: Basis,
    /// The layer's strength.
    pub strength: Factor,
    /// The layer's smoothness.
    pub smoothness: Factor,
    /// The pins to write; other pins of the layer are kept.
    pub pins: &'a [KeyedPin<'a>],
}

/// How to set a factor that the layer may have already.
#[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin makes one"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Factor {
    /// Replaces it.
    Exactly(f64),
    /// Multiplies it.
    Times(f64),
}

impl Factor {
    fn of(self, old: f64) -> f64 {
        match self {
            Self::Exactly(factor) => factor,
            Self::Times(by) => old * by,
        }
    }
}

/// A pin with its keys.
#[derive(Clone, Debug)]
pub(crate) struct KeyedPin<'a> {
    /// Its name in the layer.
    pub name: &'a str,
    /// Its anchor; `None` keeps the anchor of the existing pin of that name.
    pub anchor: Option<Anchor>,
    /// Screen-space keys, in frame heights.
    pub keys: Vec<PinKey>,
}

/// Writes a lattice and pins into the layer named `layer`; `None`: the first, which is created if there is none.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, has no such layer, or has a structure that cannot be edited.
#[cfg_attr(not(any(test, feature = "ofx")), expect(dead_code, reason = "only the OpenFX plugin calls it"))]
pub(crate) fn put_layer(text: &str, layer: Option<&str>, edit: &LayerEdit) -> Result<String, ShotError> {
    let name = layer.unwrap_or("layer");
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault(name, &what, hint))?;
    let layers = text.document.entry("layer").or_insert_with(no_tables);
    if is_empty_list(layers) && layer.is_none() {
        append_layer(layers);
    }
    let is_inline = layers.is_value();
    let table = find(layers, layer, "layer").map_err(|(what, hint)| fault(name, &what, &hint))?;
    put_lattice(table, edit)
        .ok_or_else(|| fault(name, "`lattice` is no table", "write lattice = { dims = [10, 10] }"))?;
    scale(table, "strength", edit.strength);
    let is_told = table.get("solve").is_some_and(|solve| solve.get("smoothness").is_some());
    if is_told || edit.smoothness.of(1.0) != 1.0 {
        let solve = sub_table(table, "solve");
        let solve = solve.ok_or_else(|| fault(name, "`solve` is no table", "write solve = { smoothness = 1.0 }"))?;
        scale(solve, "smoothness", edit.smoothness);
    }
    if !table.contains_key("pin") && !edit.pins.is_empty() {
        table.insert("pin", if is_inline { Item::Value(Array::new().into()) } else { no_tables() });
    }
    put_pins(table, edit.pins)?;
    Ok(text.finish())
}

fn put_lattice(layer: &mut dyn TableLike, edit: &LayerEdit) -> Option<()> {
    let lattice = sub_table(layer, "lattice")?;
    let dims: Array = edit.dims.iter().map(|&count| count as i64).collect();
    replace(lattice, "dims", dims.into());
    if lattice.contains_key("basis") || edit.basis != Basis::default() {
        replace(lattice, "basis", word(edit.basis));
    }
    Some(())
}

/// Returns the table of that name, created if missing; `None` if the name is taken by something else.
pub(super) fn sub_table<'a>(table: &'a mut dyn TableLike, name: &str) -> Option<&'a mut dyn TableLike> {
    if !table.contains_key(name) {
        table.insert(name, Item::Value(Value::InlineTable(InlineTable::new())));
    }
    table.get_mut(name)?.as_table_like_mut()
}

/// Returns the TOML spelling of an enum variant.
pub(super) fn word(choice: impl Serialize) -> Value {
    choice.serialize(ValueSerializer::new()).expect("choices are written as words")
}

/// Replaces a value, keeping the comment after it.
pub(super) fn replace(table: &mut dyn TableLike, key: &str, mut value: Value) {
    if let Some(old) = table.get(key).and_then(Item::as_value) {
        *value.decor_mut() = old.decor().clone();
    }
    match table.get_mut(key) {
        Some(item) => *item = Item::Value(value),
        None => _ = table.insert(key, Item::Value(value)),
    }
}

/// Sets a factor, whose default is 1; a value that is already right keeps its spelling.
fn scale(table: &mut dyn TableLike, key: &str, factor: Factor) {
    let number = |item: &Item| item.as_float().or_else(|| item.as_integer().map(|number| number as f64));
    let old = table.get(key).and_then(number).unwrap_or(1.0);
    let new = factor.of(old);
    if new != old {
        replace(table, key, new.into());
    }
}

/// Edits existing pins and appends new ones, in one pass over the list.
fn put_pins(layer: &mut dyn TableLike, pins: &[KeyedPin]) -> Result<(), ShotError> {
    let Some(first) = pins.first() else { return Ok(()) };
    let not_tables = || fault(first.name, "`pin` is not a list of tables", "write [[layer.pin]] as in docs/SHOT.md");
    let list = layer.get_mut("pin").ok_or_else(not_tables)?;
    let mut there = tables(list).ok_or_else(not_tables)?;
    let mut places: HashMap<String, usize> = HashMap::new();
    for (index, table) in there.iter().enumerate() {
        places.entry(super::name_of(*table, "pin", index)).or_insert(index);
    }
    let (known, new): (Vec<_>, Vec<_>) = pins.iter().partition(|pin| places.contains_key(pin.name));
    for pin in known {
        edit_keyed(there[places[pin.name]], pin);
    }
    for pin in new {
        let anchor = pin.anchor.as_ref().ok_or_else(|| fault(pin.name, "is not there", "give it an anchor"))?;
        let keys = keys_array(&pin.keys);
        let pin = NewPin::anchored(pin.name, anchor_table(anchor, Digits::All), keys);
        append_pin(list, &pin).ok_or_else(not_tables)?;
    }
    Ok(())
}

fn edit_keyed(table: &mut dyn TableLike, pin: &KeyedPin) {
    if let Some(anchor) = &pin.anchor {
        replace_anchor(table, anchor_table(anchor, Digits::All));
    }
    // The new keys are in frame heights.
    if table.contains_key("unit") {
        replace(table, "unit", "frame".into());
    }
    replace(table, "keys", keys_array(&pin.keys).into());
    // The new keys hold all channels.
    for channel in ["rotate_keys", "scale_keys"] {
        table.remove(channel);
    }
}

/// Formats the keys, one per line.
fn keys_array(keys: &[PinKey]) -> Array {
    tables_array(keys.iter().map(key_table).collect(), "  keys   = [ ".len())
}

/// Formats tables, one per line, indented by a number of letters.
pub(super) fn tables_array(tables: Vec<InlineTable>, indent: usize) -> Array {
    let (mut array, count) = (Array::new(), tables.len());
    for (index, table) in tables.into_iter().enumerate() {
        let prefix = if index == 0 { " ".to_owned() } else { format!("\n{}", " ".repeat(indent)) };
        let suffix = if index + 1 == count { " " } else { "" };
        array.push_formatted(Value::InlineTable(table).decorated(prefix, suffix));
    }
    array
}

pub(super) fn key_table(key: &PinKey) -> InlineTable {
    let mut table = InlineTable::new();
    let is_whole = key.frame.fract() == 0.0;
    table.insert("frame", if is_whole { (key.frame as i64).into() } else { key.frame.into() });
    let (name, place) = match key.goal {
        Goal::Offset(offset) => ("offset", offset.0.to_array().to_vec()),
        Goal::Target(target) => ("target", target.0.to_array().to_vec()),
        Goal::SceneOffset(offset) => ("offset", offset.to_vec()),
        Goal::SceneTarget(target) => ("target", target.to_vec()),
    };
    table.insert(name, numbers(&place, Digits::All));
    match key.rotate_degrees {
        Some(Rotation::InView(angle)) => _ = table.insert("rotate", angle.into()),
        Some(Rotation::Axes(angles)) => _ = table.insert("rotate", numbers(&angles, Digits::All)),
        None => {}
    }
    if let Some(scale) = key.scale {
        table.insert("scale", scale.into());
    }
    put_ease(&mut table, key.ease);
    table
}

/// Sets the ease by name or curve; linear, the default, is omitted.
pub(super) fn put_ease(table: &mut InlineTable, ease: Ease) {
    let value = match ease {
        Ease::Linear => return,
        Ease::Hold => "hold".into(),
        Ease::Smooth => "smooth".into(),
        Ease::Bezier(curve) => {
            let mut table = InlineTable::new();
            table.insert("bezier", numbers(&curve, Digits::All));
            Value::InlineTable(table)
        }
    };
    table.insert("ease", value);
}
