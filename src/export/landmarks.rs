//! Reads landmark files: corresponding points of two pictures.
//!
//! In: JSON or CSV. Out: validated pairs of points; docs/EXPORT.md describes both forms.

use super::ExportError;
use crate::files::{TABLE_BYTES, read_text};
use crate::image::FileKind;
use crate::key_fault::KeyFault;
use serde::Deserialize;
use std::path::Path;

/// Unit of landmark coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LandmarkUnit {
    /// Pixels of the respective picture, y DOWN from the upper left corner, as in picture viewers.
    #[default]
    Pixels,
    /// Frame heights, y up from the lower left corner.
    Frame,
}

/// Pairs of points.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmarks {
    /// Unit of the coordinates.
    #[serde(default)]
    pub(crate) unit: LandmarkUnit,
    /// At least one pair.
    pub pairs: Vec<Landmark>,
}

/// A point of picture A and the corresponding point of picture B.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    /// Name for messages; may be empty.
    #[serde(default)]
    pub name: String,
    /// In picture A.
    pub a: [f64; 2],
    /// In picture B.
    pub b: [f64; 2],
}

impl Landmarks {
    /// Reads and checks a `.csv` file, or JSON.
    ///
    /// # Errors
    /// [`ExportError`], naming the file and the line or pair.
    pub fn read(path: &Path) -> Result<Self, ExportError> {
        let text = read_text(path, TABLE_BYTES);
        let text = text.map_err(|source| ExportError::Read { path: path.to_owned(), source })?;
        let read = if FileKind::of(path) == Some(FileKind::Csv) { from_csv(&text) } else { from_json(&text) };
        let checked = read.and_then(Self::checked);
        checked.map_err(|fault| ExportError::invalid(path, fault))
    }

    fn checked(mut self) -> Result<Self, KeyFault> {
        if self.pairs.is_empty() {
            return Err(KeyFault::new("pairs", "is empty", "give at least one pair of points"));
        }
        for (number, pair) in self.pairs.iter_mut().enumerate() {
            if pair.a.iter().chain(&pair.b).any(|value| !(-1e9..=1e9).contains(value)) {
                let what = format!("is {:?} to {:?}", pair.a, pair.b);
                return Err(KeyFault::new(format!("pairs[{number}]"), what, "give numbers within the pictures"));
            }
            if pair.name.is_empty() {
                pair.name = format!("{}", number + 1);
            }
        }
        Ok(self)
    }
}

fn from_json(text: &str) -> Result<Landmarks, KeyFault> {
    serde_json::from_str(text).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        let hint =
            "write { \"unit\": \"pixels\", \"pairs\": [ { \"name\": \"nose\", \"a\": [x, y], \"b\": [x, y] } ] }";
        KeyFault::new(place, error.to_string(), hint)
    })
}

/// Parses lines of `ax,ay,bx,by` or `name,ax,ay,bx,by`, in pixels; skips empty lines, text from # on, and a header.
fn from_csv(text: &str) -> Result<Landmarks, KeyFault> {
    let mut pairs = Vec::new();
    let lines = text.lines().map(str::trim).enumerate();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let fields: Vec<&str> = line.split([',', ';', '\t']).map(|field| field.trim().trim_matches('"')).collect();
        if pairs.is_empty() && fields.ends_with(&["ax", "ay", "bx", "by"]) {
            continue;
        }
        pairs.push(csv_pair(&fields).ok_or_else(|| {
            let what = format!("'{line}' is no pair of points");
            KeyFault::new(format!("line {}", number + 1), what, "write ax,ay,bx,by or name,ax,ay,bx,by")
        })?);
    }
    Ok(Landmarks { unit: LandmarkUnit::Pixels, pairs })
}

fn csv_pair(fields: &[&str]) -> Option<Landmark> {
    let (name, numbers) = match fields.len() {
        4 => ("", fields),
        5 => (fields[0], &fields[1..]),
        _ => return None,
    };
    let numbers: Vec<f64> = numbers.iter().map(|field| field.parse().ok()).collect::<Option<_>>()?;
    let [ax, ay, bx, by] = numbers.try_into().ok()?;
    Some(Landmark { name: name.to_owned(), a: [ax, ay], b: [bx, by] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, text: &str) -> Result<Landmarks, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("written");
        Landmarks::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn both_forms_say_the_same() {
        let json = r#"{ "pairs": [ { "name": "nose", "a": [1, 2.5], "b": [3, 4] }, { "a": [5, 6], "b": [7, 8] } ] }"#;
        let csv = "# by hand\nname,ax,ay,bx,by\nnose, 1, 2.5, 3, 4\n\n5;6;7;8\n";
        let (json, csv) = (read("a.json", json).expect("JSON"), read("a.csv", csv).expect("CSV"));
        assert_eq!(json, csv);
        assert_eq!((json.pairs[1].name.as_str(), json.unit), ("2", LandmarkUnit::Pixels));
    }

    #[test]
    fn faults_name_file_and_place() {
        let cases = [
            ("a.json", "{ \"pairs\": [] }", "pairs: is empty"),
            ("a.json", "{ \"pairs\": [ { \"a\": [1], \"b\": [1, 2] } ] }", "line 1, column"),
            ("a.json", "{ \"pairs\": [ { \"a\": [1, 1e300], \"b\": [1, 2] } ] }", "pairs[0]"),
            ("a.json", "{ \"unit\": \"inch\", \"pairs\": [] }", "pixels"),
            ("a.csv", "1,2,3,4\n1,2,x,4\n", "line 2: '1,2,x,4' is no pair"),
            ("a.csv", "1,2,3\n", "write ax,ay,bx,by"),
            ("a.csv", "", "pairs: is empty"),
            ("a.csv", "1,2,nan,4", "pairs[0]"),
        ];
        for (name, text, wanted) in cases {
            let error = read(name, text).expect_err(text);
            assert!(error.contains(wanted) && error.contains(name), "{text}: {error}");
        }
    }
}
