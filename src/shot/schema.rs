//! The JSON schema of the shot file, generated from the raw types: one definition for reading, checking and publishing.
//!
//! In: [`RawShot`]. Out: text for editors (`docs/shot.schema.json`); the tree that [`super::structure`] walks, and
//! queries of it.

use super::raw::RawShot;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::sync::LazyLock;

/// Returns the JSON schema (draft 2020-12) of `shot.toml`, as text that ends with a newline.
///
/// ```
/// assert!(pinwarp::shot::schema().contains("\"pixel_aspect\""));
/// ```
#[must_use]
pub fn schema() -> String {
    let mut text = format!("{:#}", generate(false));
    text.push('\n');
    text
}

/// Returns the schema with all references inlined.
pub(super) fn inlined() -> &'static Value {
    static INLINED: LazyLock<Value> = LazyLock::new(|| generate(true));
    &INLINED
}

/// Returns the alternatives for a value: those of an enum's variants, else the rules themselves.
pub(super) fn choices(rules: &Value) -> Vec<&Value> {
    let several = rules.get("oneOf").or_else(|| rules.get("anyOf")).and_then(Value::as_array);
    several.map_or_else(|| vec![rules], |choices| choices.iter().collect())
}

/// Returns the allowed strings; empty if any string is allowed.
pub(super) fn names(rules: &Value) -> Vec<&str> {
    let listed = rules.get("enum").and_then(Value::as_array).into_iter().flatten();
    listed.chain(rules.get("const")).filter_map(Value::as_str).collect()
}

/// Returns the type's name in the schema; empty if there is none.
pub(super) fn type_of(rules: &Value) -> &str {
    rules.get("type").and_then(Value::as_str).unwrap_or_default()
}

fn generate(is_inlined: bool) -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = is_inlined);
    let mut schema = settings.into_generator().into_root_schema_for::<RawShot>().to_value();
    drop_null(&mut schema);
    schema
}

/// TOML has no null: an optional key is omitted, so its schema is that of the value.
fn drop_null(schema: &mut Value) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(drop_null),
        Value::Object(rules) => {
            if rules.get("default").is_some_and(Value::is_null) {
                rules.remove("default");
            }
            drop_null_type(rules);
            rules.values_mut().for_each(drop_null);
        }
        _ => {}
    }
}

fn drop_null_type(rules: &mut serde_json::Map<String, Value>) {
    if let Some(types) = rules.get_mut("type").and_then(Value::as_array_mut) {
        types.retain(|name| name != "null");
        if let [only] = types.as_slice() {
            rules["type"] = only.clone();
        }
    }
    let Some(choices) = rules.get_mut("anyOf").and_then(Value::as_array_mut) else { return };
    choices.retain(|choice| choice.get("type").is_none_or(|name| name != "null"));
    if choices.len() > 1 {
        return;
    }
    // A single alternative replaces the enum; existing entries (the key's own description) take precedence.
    if let Some(Value::Object(only)) = choices.pop() {
        rules.remove("anyOf");
        for (name, rule) in only {
            rules.entry(name).or_insert(rule);
        }
    }
}
