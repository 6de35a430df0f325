//! Cuts and joins between the parts of a layer, as written in the shot file.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use super::select::{RawMask, RawSelect};
use crate::shot::selection::ColorChannel;
use schemars::JsonSchema;
use serde::Deserialize;

/// A cut that separates parts of a layer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawCut {
    /// A stroke across a picture: points in frame heights.
    Stroke(#[schemars(length(min = 2))] Vec<[f64; 2]>),
    /// A part of a scene, or of a picture under a mask, which is separated from everything else.
    Part(RawPartCut),
}

/// A part of a scene, selected by names, or of a picture, selected by a mask. If several keys are set, only what all of them select is
/// cut off.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPartCut {
    /// Patterns of node names, including their subtrees; a pattern that starts with `!` excludes them.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Arm*"]))]
    pub(in crate::shot) nodes: Option<Vec<String>>,
    /// Patterns of joint names: what is skinned mostly to these joints and the joints below them.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["LeftArm*"]))]
    pub(in crate::shot) joints: Option<Vec<String>>,
    /// Patterns of material names.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Sleeve*"]))]
    pub(in crate::shot) materials: Option<Vec<String>>,
    /// Channel of the vertex colours: selects where it is above 0.5.
    #[schemars(example = &"r")]
    pub(in crate::shot) vertex_color: Option<ColorChannel>,
    /// A picture painted over the UVs of the meshes, or over the picture of the layer: selects where it is above 0.5.
    #[schemars(example = serde_json::json!({ "file": "arm.png" }))]
    pub(in crate::shot) mask: Option<RawMask>,
    /// Whether the cut also opens the surface of a mesh that the part belongs to; that of a picture is always opened.
    pub(in crate::shot) open: bool,
}

impl RawPartCut {
    /// Returns the rules of this part in the form of `select`.
    pub(in crate::shot) fn select(&self) -> RawSelect {
        let Self { joints, materials, vertex_color, mask, .. } = self.clone();
        RawSelect { joints, materials, vertex_color, mask, feather: None }
    }
}
