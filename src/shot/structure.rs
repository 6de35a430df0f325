//! Compares a TOML tree with the schema: unknown and missing keys, types, ranges, names. Finds all faults at once.
//!
//! In: [`Document`]. Out: faults, each with its line, the probable intention, and the allowed values.

use super::document::{Document, child};
use super::schema::{self, choices, names, type_of};
use super::{ShotError, hints};
use serde_json::Value as Rules;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Returns all deviations of the document from the schema.
pub(super) fn faults(document: &Document) -> Vec<ShotError> {
    let mut walk = Walk { document, faults: Vec::new() };
    walk.value(schema::inlined(), &document.root, "");
    walk.faults
}

struct Walk<'a> {
    document: &'a Document<'a>,
    faults: Vec<ShotError>,
}

impl Walk<'_> {
    fn fault(&mut self, key: &str, what: String, hint: String) {
        self.faults.push(self.document.fault(key, what, hint));
    }

    fn value(&mut self, rules: &Rules, node: &Spanned<DeValue>, path: &str) {
        let value = node.get_ref();
        let fitting: Vec<&Rules> = choices(rules).into_iter().filter(|choice| is_of_type(choice, value)).collect();
        match (value, fitting.as_slice()) {
            (_, []) => {
                let found = hints::found(value);
                let what = format!("expected {}, found {found}", hints::expected(rules));
                self.fault(path, what, hints::example(rules, path));
            }
            (DeValue::String(text), fitting) => self.text(rules, fitting, text, path),
            (DeValue::Array(items), [list, ..]) => self.list(list, items.iter(), path),
            (DeValue::Table(table), [rules, ..]) => self.table(rules, table, path),
            (number, [rules, ..]) => self.number(rules, number, path),
        }
    }

    fn text(&mut self, rules: &Rules, fitting: &[&Rules], text: &str, path: &str) {
        let names: Vec<&str> = fitting.iter().flat_map(|choice| names(choice)).collect();
        if names.is_empty() {
            if text.is_empty() && fitting.iter().any(|choice| choice.get("minLength").is_some()) {
                self.fault(path, "is empty".to_owned(), hints::example(rules, path));
            }
        } else if !names.contains(&text) {
            let what = format!("{text:?} is not known");
            self.fault(path, what, hints::name(text, &names, rules));
        }
    }

    fn list<'v>(&mut self, rules: &Rules, items: impl ExactSizeIterator<Item = &'v Spanned<DeValue<'v>>>, path: &str) {
        let limit = |name: &str| rules.get(name).and_then(Rules::as_u64);
        let count = items.len() as u64;
        if limit("minItems").is_some_and(|min| count < min) || limit("maxItems").is_some_and(|max| count > max) {
            let what = format!("expected {}, found a list of {count}", hints::expected(rules));
            self.fault(path, what, hints::example(rules, path));
            return;
        }
        for (index, item) in items.enumerate() {
            self.value(&rules["items"], item, &format!("{path}[{index}]"));
        }
    }

    fn table(&mut self, rules: &Rules, table: &DeTable, path: &str) {
        let Some(known) = rules.get("properties").and_then(Rules::as_object) else { return };
        for (key, value) in table {
            let key = key.get_ref().as_ref();
            match known.get(key) {
                Some(rules) => self.value(rules, value, &child(path, key)),
                None => {
                    let (what, hint) = hints::unknown_key(key, known, path);
                    self.fault(&child(path, key), what, hint);
                }
            }
        }
        let required = rules.get("required").and_then(Rules::as_array).into_iter().flatten();
        for key in required.filter_map(Rules::as_str) {
            let is_given = table.contains_key(key) || hints::stands_for(table, key, known);
            if !is_given {
                let path = child(path, key);
                let hint = hints::example(&known[key], &path);
                self.fault(&path, "is missing".to_owned(), hint);
            }
        }
    }

    fn number(&mut self, rules: &Rules, number: &DeValue, path: &str) {
        let Some(value) = number_of(number) else { return };
        let limit = |name: &str| rules.get(name).and_then(Rules::as_f64);
        let is_low = limit("minimum").is_some_and(|min| value < min);
        let is_high = limit("maximum").is_some_and(|max| value > max);
        if !value.is_finite() {
            self.fault(path, format!("{} is not a number that can be used", hints::found(number)), hints::range(rules));
        } else if is_low || is_high {
            self.fault(path, format!("{} is out of range", hints::found(number)), hints::range(rules));
        }
    }
}

fn is_of_type(rules: &Rules, value: &DeValue) -> bool {
    match type_of(rules) {
        "string" => value.is_str(),
        "integer" => value.is_integer(),
        "number" => value.is_integer() || value.is_float(),
        "boolean" => value.is_bool(),
        "array" => value.is_array(),
        "object" => value.is_table(),
        _ => false,
    }
}

/// Returns the number, infinite if it is too large to be represented.
fn number_of(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Integer(number) => {
            let digits = i64::from_str_radix(number.as_str(), number.radix());
            // 2^53 and above are outside every range, so rounding does not matter.
            Some(digits.map_or(f64::INFINITY, |number| number as f64))
        }
        DeValue::Float(number) => Some(number.as_str().parse().unwrap_or(f64::NAN)),
        _ => None,
    }
}
