//! `image` as written in the shot file: one picture, or several from back to front.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use schemars::JsonSchema;
use serde::Deserialize;

/// Pictures: PNG, JPEG or EXR files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawImage {
    /// One picture.
    One(#[schemars(length(min = 1))] String),
    /// Several pictures, from back to front.
    Several(#[schemars(length(min = 1), inner(length(min = 1)))] Vec<String>),
}

impl RawImage {
    /// Returns the key and path of each picture.
    pub(in crate::shot) fn paths(&self) -> Vec<(String, &str)> {
        match self {
            Self::One(path) => vec![("image".to_owned(), path)],
            Self::Several(paths) => {
                paths.iter().enumerate().map(|(index, path)| (format!("image[{index}]"), path.as_str())).collect()
            }
        }
    }
}
