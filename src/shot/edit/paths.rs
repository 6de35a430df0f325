//! Replaces the paths of the files that a shot reads.
//!
//! In: a text, a function of paths. Out: the new text; everything else is preserved, comments included.

use super::fault;
use super::text::EditableText;
use crate::shot::ShotError;
use toml_edit::{Item, TableLike, Value};

/// The keys of paths, from the top; a list on the way stands for each of its entries.
const PATHS: [&[&str]; 9] = [
    &["scene"],
    &["image"],
    &["plate"],
    &["warp", "holes", "plate"],
    &["layer", "select", "mask", "file"],
    &["layer", "transfer", "lattice"],
    &["layer", "lattice", "cuts", "mask", "file"],
    &["layer", "lattice", "cuts", "ids", "file"],
    &["layer", "lattice", "cuts", "regions", "file"],
];

/// Replaces the paths for which a function returns another one.
///
/// # Errors
/// [`ShotError::Edit`] if the text is not TOML.
pub(crate) fn put_paths(text: &str, moved: &dyn Fn(&str) -> Option<String>) -> Result<String, ShotError> {
    let mut text = EditableText::parse(text).map_err(|(what, hint)| fault("shot", &what, hint))?;
    PATHS.iter().for_each(|keys| in_table(text.document.as_table_mut(), keys, moved));
    Ok(text.finish())
}

fn in_table(table: &mut dyn TableLike, keys: &[&str], moved: &dyn Fn(&str) -> Option<String>) {
    if let Some((first, rest)) = keys.split_first()
        && let Some(item) = table.get_mut(first)
    {
        in_item(item, rest, moved);
    }
}

fn in_item(item: &mut Item, keys: &[&str], moved: &dyn Fn(&str) -> Option<String>) {
    match item {
        Item::None => {}
        Item::Value(value) => in_value(value, keys, moved),
        Item::Table(table) => in_table(table, keys, moved),
        Item::ArrayOfTables(tables) => tables.iter_mut().for_each(|table| in_table(table, keys, moved)),
    }
}

fn in_value(value: &mut Value, keys: &[&str], moved: &dyn Fn(&str) -> Option<String>) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(|value| in_value(value, keys, moved)),
        Value::InlineTable(table) => in_table(table, keys, moved),
        Value::String(path) if keys.is_empty() => {
            if let Some(other) = moved(path.value()) {
                let decor = path.decor().clone();
                *value = other.into();
                *value.decor_mut() = decor;
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_that_a_shot_reads_is_named_anew_and_nothing_else() {
        let text = r#"# mine
image  = [ "back.png", 'front.png' ]   # both
plate  = "beauty.####.exr"
warp   = { holes = { plate = "clean.####.exr" } }

[[layer]]
name   = "file"   # no path
[layer.select]
mask = { file = "mask.png", texcoord = 1 }
[layer.lattice]
cuts = [{ mask = { file = "arm.png" } }, [[0.1, 0.2], [0.3, 0.4]], { ids = { file = "ids.exr" } }]

[[layer]]
transfer = { lattice = "walk.json", layer = "file" }
lattice.cuts = [{ regions = { file = "lines.png", at = [[0.6, 0.4]] } }]

[output]
path = "out/frame.####.exr"
"#;
        let moved = |path: &str| Some(format!("up/{path}"));
        let paths = ["back.png", "front.png", "beauty.####.exr", "clean.####.exr", "mask.png", "arm.png", "ids.exr"];
        let mut wanted = text.replace("'front.png'", "\"front.png\"");
        for path in paths.iter().chain(&["walk.json", "lines.png"]) {
            wanted = wanted.replace(path, &format!("up/{path}"));
        }
        assert_eq!(put_paths(text, &moved).expect("it is TOML"), wanted);
        assert_eq!(put_paths(text, &|_| None).expect("it is TOML"), text);
        assert_eq!(put_paths("scene = 'a.glb'\n", &moved).expect("it is TOML"), "scene = \"up/a.glb\"\n");
    }
}
