//! Provenance of a frame: what pinwarp notes in every file that it writes, for `--resume` and `pinwarp report`.
//!
//! In: [`Provenance`]. Out: one JSON text, kept as an attribute of EXR files and as a text chunk of PNG files, and back.

use super::exr_file::text;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The attribute, or the keyword of the text chunk, that holds [`Provenance`].
pub(super) const NAME: &str = "pinwarp";

/// The version that writes.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Frame, shot, device, version and report, in the order in which they are written.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Provenance {
    pub(super) frame: i32,
    pub(super) shot_hash: String,
    pub(super) device: String,
    /// Empty in files from before it was written.
    #[serde(default)]
    pub(super) version: String,
    /// What the maker of the frame reports of it; null where it reports nothing.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub(super) report: Value,
}

impl Provenance {
    /// As JSON.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).expect("texts and a number are always JSON")
    }
}

/// The fields of an EXR file's part; `None` where another program wrote it.
pub(super) fn from_layer(layer: &LayerAttributes) -> Option<Provenance> {
    let AttributeValue::Text(json) = layer.other.get(&text(NAME))? else { return None };
    serde_json::from_slice(json.as_slice()).ok()
}

/// Puts the fields into a part, and room for the checksum of the file's pixels.
pub(super) fn put(layer: &mut LayerAttributes, provenance: &Provenance) {
    layer.other.insert(text(NAME), AttributeValue::Text(text(&provenance.json())));
    let room = "0".repeat(super::exr_head::CHECKSUM_DIGITS);
    layer.other.insert(Text::from(super::exr_head::CHECKSUM), AttributeValue::Text(Text::from(room.as_str())));
}
