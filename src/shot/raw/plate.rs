//! `[warp]` and `matte` as written in the shot file: how finished frames are warped, and which part of them a layer moves.
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
    /// How normals are treated.
    pub(in crate::shot) normals: NormalMode,
    /// What fills areas that the warp uncovers.
    pub(in crate::shot) holes: RawHoles,
    /// How the plate stores motion vectors. If unset, the vectors of pinwarp and Blender are recognised; those of other programs
    /// pass through unchanged.
    #[schemars(example = serde_json::json!({ "unit": "pixels", "y": "down" }))]
    pub(in crate::shot) motion: Option<RawMotion>,
    /// Meanings of channels whose names do not reveal them; the first matching pattern applies.
    #[schemars(example = serde_json::json!([{ "name": "zz.*", "meaning": "depth" }]))]
    pub(in crate::shot) channels: Vec<RawSemantic>,
}

/// What fills areas that the warp uncovers.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawHoles {
    /// Nothing: they stay transparent, and their pixels are counted.
    #[default]
    Leave,
    /// The shot's own scene, drawn without the layers that have a matte.
    Geometry,
    /// A clean plate: frames without the moving objects, relative to the shot file.
    Plate(#[schemars(length(min = 1), example = &"clean.####.exr")] String),
}

/// How a plate stores motion vectors.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMotion {
    /// Length of a vector with the value 1: a pixel, the size of the frame (width for u, height for v), or this many pixels;
    /// default: pixels.
    #[serde(default)]
    #[schemars(example = &"frame")]
    pub(in crate::shot) unit: RawMotionUnit,
    /// Direction of positive u.
    #[serde(default)]
    pub(in crate::shot) x: RawHorizontal,
    /// Direction of positive v.
    #[serde(default)]
    pub(in crate::shot) y: RawVertical,
}

/// The unit of a motion channel.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawMotionUnit {
    /// A unit with a name.
    Named(RawNamedUnit),
    /// A number of pixels.
    Number(#[schemars(range(min = 0.000001, max = 1_000_000.0))] f64),
}

/// Units with names.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedUnit {
    /// One pixel of the plate.
    Pixels,
    /// Width and height of the frame.
    Frame,
}

/// Written by hand, so that the two names appear in the same list of alternatives as the number.
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

/// The direction of positive u.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawHorizontal {
    /// Right.
    #[default]
    Right,
    /// Left.
    Left,
}

/// The direction of positive v.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawVertical {
    /// Up.
    #[default]
    Up,
    /// Down.
    Down,
}

/// The meaning of channels.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSemantic {
    /// Full name of a channel, including its layer; * and ? are wildcards.
    #[schemars(length(min = 1), example = &"zz.*")]
    pub(in crate::shot) name: String,
    /// What the channel holds.
    #[schemars(example = &"depth")]
    pub(in crate::shot) meaning: Semantic,
}

/// The part of a plate that a layer moves.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawMatte {
    /// `alpha`: everything in the plate, for pictures of one thing over nothing; `nodes`: the layer's nodes, even where it moves all of
    /// the scene; `none`: the whole picture.
    Named(RawNamedMatte),
    /// The part that a channel, ids or a Cryptomatte select.
    Part(RawMatteSource),
}

/// Mattes with names.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawNamedMatte {
    /// Everything in the plate, by its alpha.
    Alpha,
    /// The layer's own nodes, even where it moves all of the scene.
    Nodes,
    /// No matte: the layer moves the whole picture.
    None,
}

/// Written by hand for the same reason as that of [`RawNamedUnit`].
impl JsonSchema for RawNamedMatte {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawNamedMatte".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["alpha", "nodes", "none"] })
    }
}

/// A part of a plate. Set one of channel, id and cryptomatte.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMatteSource {
    /// Name of a channel whose values, 0 to 1, are the matte.
    #[schemars(length(min = 1), example = &"mask.R")]
    pub(in crate::shot) channel: Option<String>,
    /// Name of a channel of ids; requires `values`.
    #[schemars(length(min = 1), example = &"id.object")]
    pub(in crate::shot) id: Option<String>,
    /// The ids that are selected.
    #[schemars(length(min = 1), inner(range(min = 0, max = 4_294_967_295u32)), example = serde_json::json!([3]))]
    pub(in crate::shot) values: Option<Vec<u32>>,
    /// Names in a Cryptomatte, with * and ?, or ids as eight hexadecimal digits.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Body*"]))]
    pub(in crate::shot) cryptomatte: Option<Vec<String>>,
    /// Name of the Cryptomatte to search; default: the only one that contains the names.
    #[schemars(length(min = 1), example = &"CryptoObject")]
    pub(in crate::shot) of: Option<String>,
}
