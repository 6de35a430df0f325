//! The camera as written: a name, or a table with keys.
//!
//! In: TOML. Out: input of `check/camera.rs`; the descriptions are those of the published schema.

use crate::shot::Ease;
use schemars::JsonSchema;
use serde::Deserialize;

/// A camera of the scene or a standard view by name, or a camera of the shot itself.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawCamera {
    /// Name of a camera or of its node; else a view: front, back, left, right, side, top, bottom, three-quarter or fit,
    /// with `:LAYER` fitted to that layer.
    Named(#[schemars(length(min = 1))] String),
    /// A camera of the shot itself.
    Own(Box<RawOwnCamera>),
}

/// A camera of the shot itself. It orbits `look_at`, or stands at `position`. Angles are in degrees.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawOwnCamera {
    #[serde(flatten)]
    pub(in crate::shot) state: RawCameraState,
    /// How it moves; values that a key leaves out are those of the table.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "yaw": 0 }, { "frame": 48, "yaw": 90, "ease": "smooth" }]))]
    pub(in crate::shot) keys: Vec<RawCameraKey>,
}

/// A key of the camera.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawCameraKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    #[serde(flatten)]
    pub(in crate::shot) state: RawCameraState,
    /// Shape of the segment that leaves this key; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// Where a camera is and how it sees.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub(in crate::shot) struct RawCameraState {
    /// What it looks at: a point of the scene, metres, or a pattern of node names, whose middle counts; default: the scene.
    #[schemars(example = &"Head*")]
    pub(in crate::shot) look_at: Option<RawLookAt>,
    /// Distance from `look_at`, metres; default: as far as shows all of it.
    #[schemars(range(min = 0.000_001, max = 1_000_000.0), example = 3.0)]
    pub(in crate::shot) distance: Option<f64>,
    /// Instead of `distance`: where it stands, metres.
    #[schemars(inner(range(min = -1_000_000.0, max = 1_000_000.0)), example = serde_json::json!([0.0, 1.5, 4.0]))]
    pub(in crate::shot) position: Option<[f64; 3]>,
    /// Turns it around the scene's y: 0 sees the front (from +z), 90 from +x; default: 0.
    #[schemars(range(min = -36_000.0, max = 36_000.0), example = 30)]
    pub(in crate::shot) yaw: Option<f64>,
    /// Raises it: 90 looks straight down; default: 0.
    #[schemars(range(min = -90.0, max = 90.0), example = 10)]
    pub(in crate::shot) pitch: Option<f64>,
    /// Turns it about its view axis, counter-clockwise; default: 0.
    #[schemars(range(min = -36_000.0, max = 36_000.0), example = 5)]
    pub(in crate::shot) roll: Option<f64>,
    /// Vertical field of view; default: 30.
    #[schemars(range(min = 0.1, max = 170.0), example = 30)]
    pub(in crate::shot) fov: Option<f64>,
    /// Instead of `fov`: the height that a camera without perspective sees, metres.
    #[schemars(range(min = 0.000_001, max = 1_000_000.0), example = 2.0)]
    pub(in crate::shot) ortho: Option<f64>,
}

/// A point, or nodes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawLookAt {
    /// A point of the scene, metres.
    Point(#[schemars(inner(range(min = -1_000_000.0, max = 1_000_000.0)))] [f64; 3]),
    /// A pattern of node names.
    Nodes(#[schemars(length(min = 1))] String),
}
