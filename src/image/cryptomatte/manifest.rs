//! Manifests, which map names to ids.
//!
//! In: names, or the JSON of a file from another program. Out: sorted JSON; the ids that a pattern selects.

use super::MatteId;
use crate::spelling;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Names and their ids, sorted by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Manifest {
    ids: BTreeMap<String, MatteId>,
}

/// Ids selected by patterns.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Ids of all names that match a pattern.
    pub ids: BTreeSet<MatteId>,
    /// Patterns without a match, with a hint: `"Taepot": did you mean "Teapot"?`.
    pub unknown: Vec<String>,
}

impl Manifest {
    /// Creates a manifest of names, normalised by `clean_name`. Duplicate names are merged, since objects of one name share an id.
    #[must_use]
    pub fn of_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let named = |name| {
            let name = clean_name(name);
            let id = MatteId::of_name(&name);
            (name, id)
        };
        Self { ids: names.into_iter().map(named).collect() }
    }

    /// Parses a manifest of any program: a JSON object that maps names to eight hexadecimal digits. Since headers
    /// truncate long texts, a truncated manifest is read up to its last complete entry; invalid ids are skipped.
    #[must_use]
    pub fn from_json(text: &str) -> Self {
        let entry = |(name, id): (String, Value)| Some((name, MatteId::from_hex(id.as_str()?)?));
        Self { ids: whole_entries(text).into_iter().filter_map(entry).collect() }
    }

    /// Returns the JSON for headers and sidecar files, sorted by name and therefore deterministic.
    #[must_use]
    pub fn to_json(&self) -> String {
        let entries = self.ids.iter().map(|(name, id)| (name.clone(), Value::String(id.to_string())));
        Value::Object(entries.collect::<Map<_, _>>()).to_string()
    }

    /// Merges two manifests; if both contain a name, this one's id takes precedence.
    #[must_use]
    pub(crate) fn joined(&self, other: &Self) -> Self {
        let mut ids = other.ids.clone();
        ids.extend(self.ids.clone());
        Self { ids }
    }

    /// Iterates over names and ids, by name.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, MatteId)> {
        self.ids.iter().map(|(name, &id)| (name.as_str(), id))
    }

    /// Whether there are no names; ids can then still be selected by number or by hashing a name.
    #[must_use]
    pub(crate) fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Returns the ids that patterns select.
    ///
    /// A pattern is a literal name, a name with `*` and `?`, or an id: eight hexadecimal digits as in manifests, or the pixel value as in
    /// Nuke's lists, `<3.36000126251e-27>`. If the manifest is empty, a plain name selects the id that it hashes to.
    ///
    /// ```
    /// use pinwarp::image::cryptomatte::{Manifest, MatteId};
    /// let selection = Manifest::of_names(["Teapot", "Table"]).select(["Tea*"]);
    /// assert!(selection.ids.contains(&MatteId::of_name("Teapot")));
    /// ```
    #[must_use]
    pub fn select<'a>(&self, patterns: impl IntoIterator<Item = &'a str>) -> Selection {
        let mut selection = Selection::default();
        for pattern in patterns {
            let ids = self.ids_of(pattern);
            if ids.is_empty() {
                let hint = spelling::hint(pattern, self.ids.keys().map(String::as_str));
                selection.unknown.push(format!("\"{pattern}\": {hint}"));
            }
            selection.ids.extend(ids);
        }
        selection
    }

    fn ids_of(&self, pattern: &str) -> Vec<MatteId> {
        if let Some(&id) = self.ids.get(pattern) {
            return vec![id];
        }
        let number = pattern.strip_prefix('<').and_then(|rest| rest.strip_suffix('>'));
        let sample = number.and_then(|number| number.parse().ok()).map(MatteId::from_sample);
        if let Some(id) = sample.or_else(|| MatteId::from_hex(pattern)) {
            return vec![id];
        }
        if self.is_empty() && !pattern.contains(['*', '?']) {
            return vec![MatteId::of_name(pattern)];
        }
        self.iter().filter(|(name, _)| spelling::matches_pattern(pattern, name)).map(|(_, id)| id).collect()
    }
}

/// Returns the entries of a JSON object, or of its intact beginning if it is truncated.
fn whole_entries(text: &str) -> Map<String, Value> {
    if let Ok(entries) = serde_json::from_str(text) {
        return entries;
    }
    // Names may contain commas, so several are tried; a truncated name is assumed to contain fewer than this.
    const TRIES: usize = 16;
    let commas = text.rmatch_indices(',').take(TRIES);
    commas.filter_map(|(at, _)| serde_json::from_str(&format!("{}}}", &text[..at])).ok()).next().unwrap_or_default()
}

/// Normalises a name for hashing: no control characters, trimmed, never empty.
#[must_use]
pub(crate) fn clean_name(name: &str) -> String {
    let clean: String = name.trim().chars().map(|letter| if letter.is_control() { '_' } else { letter }).collect();
    if clean.is_empty() { "unnamed".into() } else { clean }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(text: &str) -> String {
        Manifest::from_json(text).to_json()
    }

    /// Test cases of Blender's `cryptomatte_test.cc`.
    #[test]
    fn manifests_read_as_blender_reads_them() {
        assert_eq!(round_trip("{}"), "{}");
        let spaced = r#"(  {  "Object"  :  "12345678"  ,  "Object2"  :  "87654321"  }  )"#;
        let spaced = spaced.trim_start_matches('(').trim_end_matches(')');
        assert_eq!(round_trip(spaced), r#"{"Object":"12345678","Object2":"87654321"}"#);
        let quoted = r#"{"Object\"01\"":"12345678","Object":"12345678"}"#;
        assert_eq!(round_trip(quoted), r#"{"Object":"12345678","Object\"01\"":"12345678"}"#);
        let escaped = r#"{"\/obj\/box:polygons:1":"9d416418"}"#;
        assert_eq!(round_trip(escaped), r#"{"/obj/box:polygons:1":"9d416418"}"#);
    }

    #[test]
    fn a_manifest_that_breaks_off_is_read_as_far_as_it_goes() {
        for cut in [r#"{"a":"11111111","b, c":"22222222","d, e"#, r#"{"a":"11111111","b, c":"22222222","d":"333"#] {
            assert_eq!(round_trip(cut), r#"{"a":"11111111","b, c":"22222222"}"#, "{cut}");
        }
        for useless in ["", "[]", "nonsense, more", r#"{"a":1,"b":"xyz"}"#] {
            assert_eq!(round_trip(useless), "{}", "{useless}");
        }
    }

    #[test]
    fn names_are_sorted_cleaned_and_merged() {
        let manifest = Manifest::of_names(["b", "a\n\"1\"", "b", "  "]);
        let names: Vec<&str> = manifest.iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["a_\"1\"", "b", "unnamed"]);
        assert_eq!(Manifest::from_json(&manifest.to_json()), manifest);
    }

    #[test]
    fn patterns_select_names_and_ids() {
        let manifest = Manifest::of_names(["Teapot", "Table", "a*b"]);
        let ids = |patterns: &[&str]| manifest.select(patterns.iter().copied());
        let of = |names: &[&str]| names.iter().map(|name| MatteId::of_name(name)).collect::<BTreeSet<_>>();
        assert_eq!(ids(&["T*"]).ids, of(&["Teapot", "Table"]));
        assert_eq!(ids(&["a*b"]).ids, of(&["a*b"]), "a name as it stands comes before patterns");
        assert_eq!(ids(&["248bfa47"]).ids, of(&["hello"]));
        assert_eq!(ids(&["<3.36000126251e-27>"]).ids, of(&["bunny"]), "Psyop's own tests write the bunny so");
        let wrong = ids(&["Taepot", "Table"]);
        assert_eq!(wrong.unknown, ["\"Taepot\": did you mean \"Teapot\"?"]);
        assert_eq!(wrong.ids, of(&["Table"]));
        assert_eq!(Manifest::default().select(["hello"]).ids, of(&["hello"]), "no manifest: the name is hashed");
    }
}
