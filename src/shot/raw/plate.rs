//! `[warp]` and `matte` as written: how finished frames are warped, and which part of them a layer moves.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use crate::plate::{Filter, NormalMode, Semantic};
use schemars::JsonSchema;
use serde::Deserialize;

/// How `pinwarp warp` warps finished frames.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawWarp {
    /// How colour is resampled.
    pub(in crate::shot) filter: Filter,
    /// Treatment of normals.
    pub(in crate::shot) normals: NormalMode,
    /// What fills places that the warp uncovers.
    pub(in crate::shot) holes: RawHoles,
    /// How the plate stores motion vectors; default: not said, so those of other programs pass through as they are.
    #[schemars(example = serde_json::json!({ "unit": "pixels", "y": "down" }))]
    pub(in crate::shot) motion: Option<RawMotion>,
    /// What channels mean whose names do not tell it; the first pattern that fits counts.
    #[schemars(example = serde_json::json!([{ "name": "zz.*", "meaning": "depth" }]))]
    pub(in crate::shot) channels: Vec<RawSemantic>,
}

/// What fills places that the warp uncovers.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawHoles {
    /// Nothing: they stay transparent, and are counted.
    #[default]
    Leave,
    /// The shot's own scene, drawn without the layers that have a matte.
    Geometry,
    /// Frames without the things that move, relative to the shot file.
    Plate(#[schemars(length(min = 1), example = &"clean.####.exr")] String),
}

/// How a plate stores motion vectors.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMotion {
    /// What 1 means: a pixel, the whole frame (across and up), or this many pixels; default: pixels.
    #[serde(default)]
    #[schemars(example = &"frame")]
    pub(in crate::shot) unit: RawMotionUnit,
    /// Where positive u points.
    #[serde(default)]
    pub(in crate::shot) x: RawAcross,
    /// Where positive v points.
    #[serde(default)]
    pub(in crate::shot) y: RawUpright,
}

/// What 1 means in a motion channel.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawMotionUnit {
    /// By name.
    Named(RawNamedUnit),
    /// Pixels.
    Number(#[schemars(range(min = 0.000001, max = 1_000_000.0))] f64),
}

/// Units that have a name.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedUnit {
    /// A pixel of the plate.
    Pixels,
    /// Width and height of the frame.
    Frame,
}

/// By hand, so that the two names stand beside the number in one list of choices.
impl JsonSchema for RawNamedUnit {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawNamedUnit".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["pixels", "frame"] })
    }
}

impl Default for RawMotionUnit {
    fn default() -> Self {
        Self::Named(RawNamedUnit::Pixels)
    }
}

/// Where positive u points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawAcross {
    /// Right.
    #[default]
    Right,
    /// Left.
    Left,
}

/// Where positive v points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawUpright {
    /// Up.
    #[default]
    Up,
    /// Down.
    Down,
}

/// What channels mean.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSemantic {
    /// Full name of a channel, with its layer; * and ? stand for any letters.
    #[schemars(length(min = 1), example = &"zz.*")]
    pub(in crate::shot) name: String,
    /// What it holds.
    #[schemars(example = &"depth")]
    pub(in crate::shot) meaning: Semantic,
}

/// The part of a plate that a layer moves.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawMatte {
    /// `alpha`: all that is there, for pictures of one thing over nothing; `none`: the whole picture.
    Named(RawNamedMatte),
    /// What a channel, ids or a Cryptomatte select.
    Part(RawPart),
}

/// Mattes that have a name.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedMatte {
    /// All that is there.
    Alpha,
    /// None: the layer moves the whole picture.
    None,
}

/// As for [`RawNamedUnit`].
impl JsonSchema for RawNamedMatte {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawNamedMatte".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["alpha", "none"] })
    }
}

/// A part of a plate: one of channel, id and cryptomatte.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPart {
    /// The values of a channel, 0 to 1.
    #[schemars(length(min = 1), example = &"mask.R")]
    pub(in crate::shot) channel: Option<String>,
    /// A channel of ids; with `values`.
    #[schemars(length(min = 1), example = &"id.object")]
    pub(in crate::shot) id: Option<String>,
    /// The ids.
    #[schemars(length(min = 1), inner(range(min = 0, max = 4_294_967_295u32)), example = serde_json::json!([3]))]
    pub(in crate::shot) values: Option<Vec<u32>>,
    /// Names in a Cryptomatte, with * and ?, or ids as eight hexadecimal digits.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Body*"]))]
    pub(in crate::shot) cryptomatte: Option<Vec<String>>,
    /// The Cryptomatte that is asked; default: the only one that knows the names.
    #[schemars(length(min = 1), example = &"CryptoObject")]
    pub(in crate::shot) of: Option<String>,
}
