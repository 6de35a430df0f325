//! `nodes` and `[layer.select]` as written: which meshes a layer takes, and which part of them.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use crate::shot::selection::ColorChannel;
use schemars::JsonSchema;
use serde::Deserialize;

/// Which nodes a layer takes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawNodes {
    /// `rest`: all that no other layer takes.
    Named(RawNamedNodes),
    /// Those that fit one of the patterns, with their subtrees; not those that fit one with a `!` before it.
    Patterns(
        #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Teapot*", "!*Lid"]))]
        Vec<String>,
    ),
}

/// Nodes that go by a word.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedNodes {
    /// All that no other layer takes.
    Rest,
}

/// Written out, so that the schema has one list of words.
impl JsonSchema for RawNamedNodes {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawNamedNodes".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["rest"] })
    }
}

/// The part of the meshes of its nodes that a layer takes; where several keys are given, only what all of them name.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSelect {
    /// Patterns of joint names: what a skin ties to these joints and those below them, by weight; a `!` before it takes out.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["LeftArm*"]))]
    pub(in crate::shot) joints: Option<Vec<String>>,
    /// Patterns of material names; a `!` before it takes out.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Skin*"]))]
    pub(in crate::shot) materials: Option<Vec<String>>,
    /// Channel of the vertex colours: all where it is 1, nothing where it is 0.
    #[schemars(example = &"r")]
    pub(in crate::shot) vertex_color: Option<ColorChannel>,
    /// A picture that is painted over the UVs of the meshes: all where it is white, nothing where it is black.
    #[schemars(example = serde_json::json!({ "file": "arm.png" }))]
    pub(in crate::shot) mask: Option<RawMask>,
    /// Least width of the border over which one mesh goes from layer to layer, diagonals of the mesh; default: 0.1.
    #[schemars(range(min = 0.0, max = 1.0), example = 0.1)]
    pub(in crate::shot) feather: Option<f64>,
}

/// A picture painted over UVs.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMask {
    /// PNG, JPEG or EXR, relative to the shot file.
    #[schemars(length(min = 1), example = &"arm.png")]
    pub(in crate::shot) file: String,
    /// Its channel; default: r, which in a grey picture is the grey.
    #[schemars(example = &"a")]
    pub(in crate::shot) channel: Option<ColorChannel>,
    /// Which UVs of the meshes: TEXCOORD_0 or TEXCOORD_1.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub(in crate::shot) texcoord: usize,
}
