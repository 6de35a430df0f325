//! Provenance of a frame: the metadata in every file that pinwarp writes, for `--resume` and `pinwarp report`.
//!
//! In: [`Provenance`]. Out: one JSON text, stored as an EXR attribute or a PNG text chunk, and the inverse.

use super::exr_file::text;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::LayerAttributes;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Name of the attribute, or keyword of the text chunk, that stores [`Provenance`].
pub(super) const NAME: &str = "pinwarp";

/// Version of this program.
pub(super) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Frame, shot, device, version and report, in the order in which they are written.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Provenance {
    pub(super) frame: i32,
    pub(super) shot_hash: String,
    pub(super) device: String,
    /// Empty in files from before this field existed.
    #[serde(default)]
    pub(super) version: String,
    /// Report on the frame; null if there is none.
    #[serde(default, skip_serializing_if = "Value::is_null")]
    pub(super) report: Value,
}

impl Provenance {
    /// Serialises as JSON.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).expect("texts and a number are always JSON")
    }
}

/// Reads the fields from an EXR part; `None` if another program wrote it.
pub(super) fn from_layer(layer: &LayerAttributes) -> Option<Provenance> {
    let AttributeValue::Text(json) = layer.other.get(&text(NAME))? else { return None };
    serde_json::from_slice(json.as_slice()).ok()
}

/// Stores the fields in a part, with a placeholder for the checksum of the file's pixels.
pub(super) fn put(layer: &mut LayerAttributes, provenance: &Provenance) {
    layer.other.insert(text(NAME), AttributeValue::Text(text(&provenance.json())));
    let room = "0".repeat(super::exr_head::CHECKSUM_DIGITS);
    layer.other.insert(Text::from(super::exr_head::CHECKSUM), AttributeValue::Text(Text::from(room.as_str())));
}
