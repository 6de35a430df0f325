//! Cuts and joins between the parts of a layer, as written in the shot file.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use super::order::RawOrder;
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
    /// A part of a scene, or parts of a picture, which are separated from everything else.
    Part(Box<RawPartCut>),
}

/// A link between two parts of a scene at one place.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawJoin {
    /// Patterns of the names of two nodes, which are joined where they are nearest at rest.
    Nearest(#[schemars(inner(length(min = 1)))] [String; 2]),
    /// Two nodes and a place.
    At(RawPlacedJoin),
}

/// A link between two parts of a scene at a place that is named: the hinge between them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPlacedJoin {
    /// Patterns of the names of two nodes.
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["Arm", "Body"]))]
    pub(in crate::shot) nodes: [String; 2],
    /// The place in the scene at rest, metres: the nearest points of both parts are linked.
    #[schemars(example = serde_json::json!([0.3, 1.4, 0.0]))]
    pub(in crate::shot) at: [f64; 3],
}

/// A part of a scene, selected by names, or of a picture, selected by a mask. If several keys are set, only what all of them select is
/// cut off. `ids`, `regions` and `stroke` stand alone: parts of a picture by a picture of ids, or by what the lines of the drawing close; a
/// stroke over a scene.
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
    /// A picture of ids over the picture of the layer: each colour, or each id of a Cryptomatte, is a part of its own.
    #[schemars(example = serde_json::json!({ "file": "ids.png" }))]
    pub(in crate::shot) ids: Option<RawIds>,
    /// Regions that the lines of a drawing close: each is a part of its own, or those at some points are one.
    #[schemars(example = serde_json::json!({ "at": [[0.62, 0.40]] }))]
    pub(in crate::shot) regions: Option<RawRegions>,
    /// A stroke over a scene, as the camera sees it in `frame`: points in frame heights.
    #[schemars(length(min = 2), example = serde_json::json!([[0.62, 0.40], [0.62, 0.71]]))]
    pub(in crate::shot) stroke: Option<Vec<[f64; 2]>>,
    /// The frame over which `stroke` is drawn.
    #[schemars(example = 12)]
    pub(in crate::shot) frame: Option<i32>,
    /// Whether the cut also opens the surface of a mesh that it divides; that of a picture is always opened.
    pub(in crate::shot) open: bool,
    /// Order in depth of a part of a picture that `mask`, `ids` or `regions` chooses: where parts overlap, the one with the greater order
    /// lies in front; default: the order of its pins.
    #[schemars(example = 1)]
    pub(in crate::shot) order: Option<RawOrder>,
}

/// A picture of ids that lies over the picture of a layer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawIds {
    /// PNG file of flat colours, or EXR file of flat colours, ids or a Cryptomatte, relative to the shot file.
    #[schemars(length(min = 1), example = &"ids.png")]
    pub(in crate::shot) file: String,
    /// Name of a channel of ids.
    #[schemars(length(min = 1), example = &"id.object")]
    pub(in crate::shot) id: Option<String>,
    /// The ids in it that together are one part; default: each is a part of its own.
    #[schemars(length(min = 1), inner(range(min = 0, max = 4_294_967_295u32)), example = serde_json::json!([3]))]
    pub(in crate::shot) values: Option<Vec<u32>>,
    /// Names in a Cryptomatte, with * and ?, or ids as eight hexadecimal digits, that together are one part; default: each of its ids is a
    /// part of its own.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Arm*"]))]
    pub(in crate::shot) cryptomatte: Option<Vec<String>>,
    /// Name of the Cryptomatte; default: the one that contains most of the names, else that of objects, else of assets.
    #[schemars(length(min = 1), example = &"CryptoObject")]
    pub(in crate::shot) of: Option<String>,
}

/// The regions that the lines of a drawing close.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawRegions {
    /// Picture of the lines alone, of the shape of the layer's picture, relative to the shot file; default: the picture of the layer.
    #[schemars(length(min = 1), example = &"lines.png")]
    pub(in crate::shot) file: Option<String>,
    /// Points in frame heights, y up: the regions that contain them are together one part; default: every region is a part of its own.
    #[schemars(length(min = 1), example = serde_json::json!([[0.62, 0.40]]))]
    pub(in crate::shot) at: Option<Vec<[f64; 2]>>,
    /// Greatest gap in a line that still closes a region, and least width of a region, frame heights; default: 0.01.
    #[schemars(range(min = 0.0, max = 0.25), example = 0.02)]
    pub(in crate::shot) gap: Option<f64>,
    /// Greatest width of a line, frame heights: what is dark and wider is a region; default: 0.025.
    #[schemars(range(min = 0.0, max = 0.25), example = 0.01)]
    pub(in crate::shot) line: Option<f64>,
    /// Least contrast of a line with what lies beside it, as a fraction of that of black and white; default: 0.25.
    #[schemars(range(min = 0.01, max = 1.0), example = 0.15)]
    pub(in crate::shot) threshold: Option<f64>,
}

impl RawPartCut {
    /// Returns the rules of this part in the form of `select`.
    pub(in crate::shot) fn select(&self) -> RawSelect {
        let Self { joints, materials, vertex_color, mask, .. } = self.clone();
        RawSelect { joints, materials, vertex_color, mask, feather: None }
    }

    /// Returns the keys, beside `other`, of this cut.
    pub(in crate::shot) fn keys_beside(&self, other: &str) -> Vec<&'static str> {
        let keys = [
            ("nodes", self.nodes.is_some()),
            ("joints", self.joints.is_some()),
            ("materials", self.materials.is_some()),
            ("vertex_color", self.vertex_color.is_some()),
            ("mask", self.mask.is_some()),
            ("ids", self.ids.is_some()),
            ("regions", self.regions.is_some()),
            ("stroke", self.stroke.is_some()),
            ("frame", self.frame.is_some()),
            ("open", self.open),
        ];
        keys.into_iter().filter(|(key, is_given)| *is_given && *key != other).map(|(key, _)| key).collect()
    }
}
