//! The names behind ids.
//!
//! In: names, or the JSON of a foreign file. Out: JSON, sorted; the ids that a pattern selects.

use super::MatteId;
use crate::spelling;
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Names and their ids, sorted by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Manifest {
    ids: BTreeMap<String, MatteId>,
}

/// What patterns select.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Ids of all names that a pattern fits.
    pub ids: BTreeSet<MatteId>,
    /// Patterns that fit nothing, with a hint: `"Taepot": did you mean "Teapot"?`.
    pub unknown: Vec<String>,
}

impl Manifest {
    /// The manifest of these names, cleaned by [`clean_name`]; a name that comes twice stands once, since objects of one
    /// name share an id.
    #[must_use]
    pub fn of_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let named = |name| {
            let name = clean_name(name);
            let id = MatteId::of_name(&name);
            (name, id)
        };
        Self { ids: names.into_iter().map(named).collect() }
    }

    /// Reads a manifest of any program: a JSON object, names to eight hexadecimal digits. Headers cut long texts, so one
    /// that ends too early is read up to its last whole entry; entries that are no ids are left out.
    #[must_use]
    pub fn from_json(text: &str) -> Self {
        let entry = |(name, id): (String, Value)| Some((name, MatteId::from_hex(id.as_str()?)?));
        Self { ids: whole_entries(text).into_iter().filter_map(entry).collect() }
    }

    /// The manifest as headers and side files hold it: sorted by name, the same text every time.
    #[must_use]
    pub fn to_json(&self) -> String {
        let entries = self.ids.iter().map(|(name, id)| (name.clone(), Value::String(id.to_string())));
        Value::Object(entries.collect::<Map<_, _>>()).to_string()
    }

    /// The names of both; where both know one, the own id counts.
    #[must_use]
    pub fn joined(&self, other: &Self) -> Self {
        let mut ids = other.ids.clone();
        ids.extend(self.ids.clone());
        Self { ids }
    }

    /// Names and ids, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, MatteId)> {
        self.ids.iter().map(|(name, &id)| (name.as_str(), id))
    }

    /// Number of names.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// No names: ids can still be selected by the name they come from, or by number.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The ids that patterns select. A pattern is a name as it stands, a name with `*` and `?`, or an id: eight
    /// hexadecimal digits as in manifests, or the number in the pixels as Nuke's lists have it, `<3.36000126251e-27>`. Without any names in the manifest a plain name
    /// selects the id it hashes to.
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
        self.iter().filter(|(name, _)| spelling::fits(pattern, name)).map(|(_, id)| id).collect()
    }
}

/// The entries of a JSON object, or those in front of the place where it breaks off.
fn whole_entries(text: &str) -> Map<String, Value> {
    if let Ok(entries) = serde_json::from_str(text) {
        return entries;
    }
    // A comma may also stand in a name, so further ones are tried; a broken name is shorter than this many commas.
    const TRIES: usize = 16;
    let commas = text.rmatch_indices(',').take(TRIES);
    commas.filter_map(|(at, _)| serde_json::from_str(&format!("{}}}", &text[..at])).ok()).next().unwrap_or_default()
}

/// A name as it goes into ids: without control characters and space around it, never empty.
#[must_use]
pub fn clean_name(name: &str) -> String {
    let clean: String = name.trim().chars().map(|letter| if letter.is_control() { '_' } else { letter }).collect();
    if clean.is_empty() { "unnamed".into() } else { clean }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(text: &str) -> String {
        Manifest::from_json(text).to_json()
    }

    /// Cases of Blender's `cryptomatte_test.cc`.
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
