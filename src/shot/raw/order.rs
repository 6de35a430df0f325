//! Which overlapping part of a picture lies in front, as written in the shot file.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use schemars::JsonSchema;
use serde::Deserialize;

/// The order of a pin or of a part, constant or with keys.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawOrder {
    /// The same order in all frames.
    Always(#[schemars(range(min = -1000, max = 1000))] i32),
    /// Keys in order of frames. Each holds until the next one; the first also holds before its frame.
    Keys(#[schemars(length(min = 1))] Vec<RawOrderKey>),
}

/// A keyframe of an order.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawOrderKey {
    /// Frame number of the key.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Order from this frame on.
    #[schemars(range(min = -1000, max = 1000), example = 1)]
    pub(in crate::shot) value: i32,
}
