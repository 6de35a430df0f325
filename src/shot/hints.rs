//! The wording of faults: what was expected, what was probably meant, what to write instead.
//!
//! In: schema rules and what the user wrote. Out: parts of messages.

use super::schema::{choices, names, type_of};
use crate::spelling::nearest;
use serde_json::{Map, Value as Rules};
use toml::de::{DeTable, DeValue};

/// Values known under another name elsewhere.
const FOREIGN_NAMES: &[(&str, &str)] = &[
    ("rgba", "R, G, B and A are called \"beauty\""),
    ("velocity", "motion vectors are called \"motion\""),
    ("rims", "it is called \"spokes-and-rims\""),
];

/// Renamed keys: the table (without its number) that contains the key, the former name, the current one.
const FORMER_KEYS: &[(&str, &str, &str)] =
    &[("region", "grip", "rigidity"), ("region", "starch", "stiffness"), ("solve", "stiffness", "smoothness")];

/// Keys that belong to another table, or are not supported.
const FOREIGN_KEYS: &[(&str, &str)] = &[
    ("clip", "it belongs in frames: frames = { first = 1, last = 48, clip = \"Walk\" }"),
    ("clip_start", "it belongs in frames: frames = { first = 1, last = 48, clip_start = 1 }"),
    ("loop", "it belongs in frames: frames = { first = 1, last = 48, loop = true }"),
    ("rate", "it belongs in frames: frames = { first = 1, last = 48, rate = 24 }"),
    ("pin", "pins belong to a layer: [[layer]], then [[layer.pin]]"),
    ("handle", "handles belong to a layer: [[layer]], then [[layer.handle]]"),
    ("fov", "it belongs in camera: camera = { yaw = 30, fov = 30 }"),
    ("look_at", "it belongs in camera: camera = { look_at = \"Head\", distance = 3 }"),
    ("yaw", "it belongs in camera: camera = { yaw = 30 }"),
    ("visible", "use hide = [\"*Sword*\"] or show = [..] of the shot"),
    ("space", "it belongs in lattice: lattice = { space = \"world\", dims = [5, 5, 5] }"),
    ("dims", "it belongs in lattice: lattice = { dims = [10, 10] }"),
    ("basis", "it belongs in lattice: lattice = { basis = \"bspline\" }"),
    ("box", "it belongs in lattice: lattice = { box = \"follow\" }"),
    ("energy", "it belongs in solve: solve = { energy = \"area\" }"),
    ("regularizer", "it belongs in solve: solve = { regularizer = \"bend\" }"),
    ("preset", "it belongs in solve: solve = { preset = \"paper\" }"),
    ("channels", "it belongs in [output]"),
    ("compression", "it belongs in [output]"),
    ("region", "it belongs to a pin: region = { radius = 0.1, rigidity = 1.0 }"),
    ("rigidity", "it belongs in region of a pin: region = { radius = 0.1, rigidity = 1.0 }"),
    ("smoothness", "it belongs in solve: solve = { smoothness = 2.0 }"),
    ("stiffness", "it belongs to a layer: [[layer]], then [[layer.stiffness]]"),
    ("weight", "it belongs to a pin: weight = 0.5; `strength` of the layer scales all pins"),
];

/// Describes briefly what the user wrote.
pub(super) fn found(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("the text {text:?}"),
        DeValue::Integer(number) => number.to_string(),
        DeValue::Float(number) => number.to_string(),
        DeValue::Boolean(value) => value.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

/// Describes what is expected: `a whole number`, `a list of 2 numbers`, `"hold", "linear"... or { bezier = .. }`.
pub(super) fn expected(rules: &Rules) -> String {
    let words: Vec<String> = choices(rules).into_iter().map(expected_one).collect();
    words.join(" or ")
}

fn expected_one(rules: &Rules) -> String {
    let names = names(rules);
    if !names.is_empty() {
        return quoted(&names).join(" or ");
    }
    match type_of(rules) {
        "string" => "text in quotes".to_owned(),
        "integer" => "a whole number".to_owned(),
        "number" => "a number".to_owned(),
        "boolean" => "true or false".to_owned(),
        "array" => expected_list(rules),
        _ => expected_table(rules),
    }
}

fn expected_list(rules: &Rules) -> String {
    let kind = match type_of(&rules["items"]) {
        "integer" => "whole numbers",
        "number" => "numbers",
        "object" => "tables",
        "array" => "lists",
        _ => "texts",
    };
    let limit = |name: &str| rules.get(name).and_then(Rules::as_u64);
    match (limit("minItems"), limit("maxItems")) {
        (Some(min), Some(max)) if min == max => format!("a list of {min} {kind}"),
        (Some(min), Some(max)) if min + 1 == max => format!("a list of {min} or {max} {kind}"),
        (Some(min), Some(max)) => format!("a list of {min} to {max} {kind}"),
        (Some(min), _) => format!("a list of at least {min} {kind}"),
        _ => format!("a list of {kind}"),
    }
}

fn expected_table(rules: &Rules) -> String {
    let keys = rules.get("properties").and_then(Rules::as_object).into_iter().flatten();
    let single: Vec<&String> = keys.map(|(key, _)| key).collect();
    match single.as_slice() {
        [only] => format!("{{ {only} = .. }}"),
        _ => "a table".to_owned(),
    }
}

/// Returns an example such as `write scene = "scene.glb"`, from the schema's example or default.
pub(super) fn example(rules: &Rules, path: &str) -> String {
    let key = path.rsplit('.').next().unwrap_or(path);
    let value = rules.pointer("/examples/0").or_else(|| rules.get("default"));
    match value {
        Some(value) if !key.contains('[') => format!("write for example `{key} = {}`", toml_text(value)),
        _ if !rules.get("minimum").is_none_or(Rules::is_null) => range(rules),
        _ => format!("write {}", expected(rules)),
    }
}

/// Describes the allowed range: `give a whole number from 1 to 4096`.
pub(super) fn range(rules: &Rules) -> String {
    let kind = expected_one(rules);
    let limit = |name: &str| rules.get(name).filter(|limit| limit.is_number()).map(limit_text);
    match (limit("minimum"), limit("maximum")) {
        (Some(min), Some(max)) if min == max => format!("write {min}"),
        (Some(min), Some(max)) => format!("give {kind} from {min} to {max}"),
        (Some(min), None) => format!("give {kind} of at least {min}"),
        (None, Some(max)) => format!("give {kind} of at most {max}"),
        (None, None) => format!("give {kind}"),
    }
}

/// Formats integral limits without `.0`, so that -32.0 becomes -32.
fn limit_text(limit: &Rules) -> String {
    limit.as_f64().map_or_else(|| limit.to_string(), |number| number.to_string())
}

/// Describes a name that is not in `names`; `rules` may allow other values, too.
pub(super) fn name(written: &str, names: &[&str], rules: &Rules) -> String {
    if let Some(remedy) = foreign(FOREIGN_NAMES, written) {
        return remedy.to_owned();
    }
    let allowed = format!("allowed: {}", expected_names(names, rules));
    match nearest(written, names.iter().copied()) {
        Some(meant) => format!("did you mean {meant:?}? {allowed}"),
        None => allowed,
    }
}

fn expected_names(names: &[&str], rules: &Rules) -> String {
    let tables = choices(rules).into_iter().filter(|choice| type_of(choice) == "object").map(expected_table);
    quoted(names).into_iter().chain(tables).collect::<Vec<_>>().join(", ")
}

/// Describes an unknown key of the table at `path`, and what to do about it.
pub(super) fn unknown_key(key: &str, known: &Map<String, Rules>, path: &str) -> (String, String) {
    let what = "is not a key".to_owned() + if path.is_empty() { " of a shot" } else { " of this table" };
    let keys: Vec<&str> = known.keys().map(String::as_str).collect();
    let allowed = format!("keys here: {}", keys.join(", "));
    let former = FORMER_KEYS.iter().find(|(table, former, _)| *former == key && table_name(path) == *table);
    let former = former.map(|(_, _, present)| format!("it is called `{present}`"));
    let remedy = former.or_else(|| foreign(FOREIGN_KEYS, key).map(str::to_owned));
    let meant = nearest(key, keys.iter().copied()).map(|meant| format!("did you mean `{meant}`?"));
    // A key of another table is an exact match, a similar spelling only a guess.
    match remedy.or(meant) {
        Some(remedy) => (what, format!("{remedy} ({allowed})")),
        None => (what, format!("remove it ({allowed})")),
    }
}

/// Returns whether another key of the table, misspelt or unsupported, was already reported in place of the missing one.
pub(super) fn stands_for(table: &DeTable, missing: &str, known: &Map<String, Rules>) -> bool {
    let unknown = table.keys().map(|key| key.get_ref().as_ref()).filter(|key| !known.contains_key(*key));
    let mut meant = unknown.map(|key| nearest(key, known.keys().map(String::as_str)) == Some(missing));
    meant.any(|is_meant| is_meant)
}

/// Returns the key of the table at `path`, without its number: `pin` for `layer[0].pin[2]`.
fn table_name(path: &str) -> &str {
    let last = path.rsplit('.').next().unwrap_or(path);
    last.split('[').next().unwrap_or(last)
}

fn foreign(table: &'static [(&str, &str)], word: &str) -> Option<&'static str> {
    table.iter().find(|(foreign, _)| *foreign == word).map(|(_, remedy)| *remedy)
}

fn quoted(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| format!("{name:?}")).collect()
}

/// Converts a JSON value to TOML.
fn toml_text(value: &Rules) -> String {
    match value {
        Rules::Object(table) => {
            let pairs: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {}", toml_text(value))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        Rules::Array(items) => format!("[{}]", items.iter().map(toml_text).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}
