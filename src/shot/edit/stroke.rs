//! Adds and removes brush strokes of stiffness in the text of a shot.
//!
//! In: a text, the name of a layer, a stroke. Out: the new text; everything else is preserved, comments included.

use super::block::{Digits, numbers};
use super::pin::{edit_layer, few};
use super::{fault, no_tables, tables, text};
use crate::shot::{BrushStroke, ShotError};
use toml_edit::{Array, InlineTable, Item, Table, TableLike, Value};

/// Appends a stroke to the stiffness of a layer.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML, has no such layer, or if its `stiffness` is not a list of tables.
pub(crate) fn add_stroke(text: &str, layer: &str, stroke: &BrushStroke) -> Result<String, ShotError> {
    edit_layer(text, layer, layer, |table| {
        let entries = [("stroke", Value::InlineTable(stroke_table(stroke))), ("value", few(stroke.value))];
        match table.entry("stiffness").or_insert_with(no_tables) {
            Item::ArrayOfTables(list) => {
                let last = list.len().checked_sub(1).and_then(|last| list.get(last));
                let indent = last.map_or("  ".to_owned(), text::indent_of);
                let mut entry = Table::new();
                entry.decor_mut().set_prefix(format!("\n{indent}"));
                for (key, value) in entries {
                    entry.insert(key, Item::Value(value));
                    if let Some(mut name) = entry.key_mut(key) {
                        name.leaf_decor_mut().set_prefix(&*indent);
                        name.leaf_decor_mut().set_suffix(" ".repeat("stroke ".len() - key.len()));
                    }
                }
                list.push(entry);
            }
            Item::Value(Value::Array(list)) => list.push(InlineTable::from_iter(entries)),
            _ => return Err(not_tables(layer)),
        }
        Ok(())
    })
}

/// Removes all strokes from the stiffness of a layer.
///
/// # Errors
/// As [`add_stroke`].
pub(crate) fn remove_strokes(text: &str, layer: &str) -> Result<String, ShotError> {
    edit_layer(text, layer, layer, |table| {
        let Some(list) = table.get_mut("stiffness") else { return Ok(()) };
        let is_kept = |entry: &dyn TableLike| !entry.contains_key("stroke");
        match list {
            Item::ArrayOfTables(list) => list.retain(|entry| is_kept(entry)),
            Item::Value(Value::Array(list)) => {
                list.retain(|entry| entry.as_inline_table().is_none_or(|entry| is_kept(entry)));
            }
            _ => return Err(not_tables(layer)),
        }
        if tables(list).is_some_and(|tables| tables.is_empty()) {
            table.remove("stiffness");
        }
        Ok(())
    })
}

fn not_tables(layer: &str) -> ShotError {
    fault(layer, "`stiffness` is not a list of tables", "write [[layer.stiffness]] as in docs/SHOT.md")
}

fn stroke_table(stroke: &BrushStroke) -> InlineTable {
    let mut table = InlineTable::new();
    if !stroke.nodes.is_empty() {
        table.insert("nodes", Value::Array(stroke.nodes.iter().map(String::as_str).collect::<Array>()));
    }
    table.insert("radius", few(stroke.radius));
    let points: Array = stroke.points.iter().map(|point| numbers(point, Digits::Few)).collect();
    table.insert("points", Value::Array(points));
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_come_and_go_and_leave_other_entries_alone() {
        let stroke = BrushStroke { nodes: Vec::new(), points: vec![[0.25; 3], [0.5; 3]], radius: 0.5, value: 1.0 };
        let texts = [
            "[[layer]]\nname = 'a'\n\n  [[layer.stiffness]] # head\n  nodes = ['H*']\n  value = 4 # firm\n\n[[layer]]\nname = 'b'\n",
            "[[layer]]\nname = 'a'\nstiffness = [{ nodes = ['H*'], value = 4 }]\n",
            "layer = [{ name = 'a', stiffness = [{ material = 'M', value = 2 }] }]\n",
        ];
        for text in texts {
            let once = add_stroke(text, "a", &stroke).expect("a layer");
            let twice = add_stroke(&once, "a", &stroke).expect("a layer");
            assert_eq!(twice.matches("points").count(), 2, "{twice}");
            assert_eq!(remove_strokes(&twice, "a").expect("a layer"), text, "{twice}");
        }
        let none = "[[layer]]\nname = 'a'\n";
        let once = add_stroke(none, "a", &stroke).expect("a layer");
        assert_eq!(remove_strokes(&once, "a").expect("a layer"), none);
        assert!(add_stroke("[[layer]]\nname = 'a'\nstiffness = 4\n", "a", &stroke).is_err());
        assert!(add_stroke(none, "b", &stroke).is_err());
    }

    #[test]
    fn a_stroke_is_appended_to_the_stiffness() -> Result<(), crate::shot::ShotError> {
        use crate::shot::{BrushStroke, edit};
        let stroke = BrushStroke { nodes: vec!["Body".into()], points: vec![[0.0, 1.0, 0.5]], radius: 0.1, value: 8.0 };
        let edited = edit::add_stroke("[[layer]]\nname = 'a' # mine\n", "a", &stroke)?;
        assert_eq!(
            edited,
            "[[layer]]\nname = 'a' # mine\n\n  [[layer.stiffness]]
  stroke = { nodes = [\"Body\"], radius = 0.1, points = [[0.0, 1.0, 0.5]] }\n  value  = 8.0\n"
        );
        Ok(())
    }
}
