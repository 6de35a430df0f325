//! `nodes` and `[layer.select]` as written in the shot file: which meshes a layer claims, and which part of them.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use crate::shot::selection::ColorChannel;
use schemars::JsonSchema;
use serde::Deserialize;

/// The nodes that a layer claims.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawNodes {
    /// `rest`: everything that no other layer claims.
    Named(RawNamedNodes),
    /// Patterns of node names. Each includes the subtrees of its nodes; a pattern that starts with `!` excludes them.
    Patterns(
        #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Teapot*", "!*Lid"]))]
        Vec<String>,
    ),
}

/// Values of `nodes` that are not patterns.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedNodes {
    /// Everything that no other layer claims.
    Rest,
}

/// Written by hand, so that the schema has a single list of values.
impl JsonSchema for RawNamedNodes {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawNamedNodes".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["rest"] })
    }
}

/// The part of the meshes of its nodes that a layer claims. If several keys are set, only what all of them select is claimed.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSelect {
    /// Patterns of joint names: vertices belong to the layer by their skin weights for these joints and the joints below them. A
    /// pattern that starts with `!` excludes them.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["LeftArm*"]))]
    pub(in crate::shot) joints: Option<Vec<String>>,
    /// Patterns of material names; a pattern that starts with `!` excludes them.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Skin*"]))]
    pub(in crate::shot) materials: Option<Vec<String>>,
    /// Channel of the vertex colours: 1 selects fully, 0 not at all.
    #[schemars(example = &"r")]
    pub(in crate::shot) vertex_color: Option<ColorChannel>,
    /// A picture painted over the UVs of the meshes: white selects fully, black not at all.
    #[schemars(example = serde_json::json!({ "file": "arm.png" }))]
    pub(in crate::shot) mask: Option<RawMask>,
    /// Minimum width of the transition between two layers of a mesh, in diagonals of the meshes of its node at rest; default:
    /// 0.1.
    #[schemars(range(min = 0.0, max = 1.0), example = 0.1)]
    pub(in crate::shot) feather: Option<f64>,
}

/// A picture painted over the UVs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMask {
    /// PNG, JPEG or EXR file, relative to the shot file.
    #[schemars(length(min = 1), example = &"arm.png")]
    pub(in crate::shot) file: String,
    /// Channel to read; default: r, which is the grey of a grey picture.
    #[schemars(example = &"a")]
    pub(in crate::shot) channel: Option<ColorChannel>,
    /// UV set of the meshes: TEXCOORD_0 or TEXCOORD_1.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub(in crate::shot) texcoord: usize,
}
