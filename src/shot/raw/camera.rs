//! The camera as written in the shot file: a name, or a table with keys.
//!
//! In: TOML. Out: input of `check/camera.rs`. The doc comments are the descriptions of the published schema.

use crate::shot::Ease;
use schemars::JsonSchema;
use serde::Deserialize;

/// A camera of the scene or a standard view, by name, or a camera defined in the shot.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawCamera {
    /// Name of a camera or of its node; otherwise a view: front, back, left, right, side, top, bottom, three-quarter or fit. A
    /// view with `:LAYER` frames that layer.
    Named(#[schemars(length(min = 1))] String),
    /// A camera defined in the shot.
    Own(Box<RawShotCamera>),
}

/// A camera defined in the shot. It orbits `look_at`, or stands at `position`. Angles are in degrees.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawShotCamera {
    #[serde(flatten)]
    pub(in crate::shot) state: RawCameraState,
    /// Keyframes of the camera. Values that a key omits come from the table.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "yaw": 0 }, { "frame": 48, "yaw": 90, "ease": "smooth" }]))]
    pub(in crate::shot) keys: Vec<RawCameraKey>,
}

/// A keyframe of the camera.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawCameraKey {
    /// Frame number of the key.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    #[serde(flatten)]
    pub(in crate::shot) state: RawCameraState,
    /// Shape of the segment from this key to the next; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// Position, orientation and view of a camera.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
pub(in crate::shot) struct RawCameraState {
    /// Point that the camera looks at: a position in metres, or a pattern of node names, which means the centre of their meshes;
    /// default: the centre of the whole scene.
    #[schemars(example = &"Head*")]
    pub(in crate::shot) look_at: Option<RawLookAt>,
    /// Distance from `look_at` in metres; default: far enough to show all of it.
    #[schemars(range(min = 0.000_001, max = 1_000_000.0), example = 3.0)]
    pub(in crate::shot) distance: Option<f64>,
    /// Position of the camera in metres; replaces `distance`.
    #[schemars(inner(range(min = -1_000_000.0, max = 1_000_000.0)), example = serde_json::json!([0.0, 1.5, 4.0]))]
    pub(in crate::shot) position: Option<[f64; 3]>,
    /// Rotation about the scene's y axis: 0 views the front (from +z), 90 views from +x; default: 0.
    #[schemars(range(min = -36_000.0, max = 36_000.0), example = 30)]
    pub(in crate::shot) yaw: Option<f64>,
    /// Elevation of the camera: 90 looks straight down; default: 0.
    #[schemars(range(min = -90.0, max = 90.0), example = 10)]
    pub(in crate::shot) pitch: Option<f64>,
    /// Rotation about the view axis, counter-clockwise; default: 0.
    #[schemars(range(min = -36_000.0, max = 36_000.0), example = 5)]
    pub(in crate::shot) roll: Option<f64>,
    /// Vertical field of view; default: 30.
    #[schemars(range(min = 0.1, max = 170.0), example = 30)]
    pub(in crate::shot) fov: Option<f64>,
    /// Makes the camera orthographic: the height that it sees, in metres. Replaces `fov`.
    #[schemars(range(min = 0.000_001, max = 1_000_000.0), example = 2.0)]
    pub(in crate::shot) ortho: Option<f64>,
}

/// The point that a camera looks at: a position, or nodes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawLookAt {
    /// A position in the scene, metres.
    Point(#[schemars(inner(range(min = -1_000_000.0, max = 1_000_000.0)))] [f64; 3]),
    /// A pattern of node names.
    Nodes(#[schemars(length(min = 1))] String),
}
