//! The shot file as written: every key, its type, range and default, nothing related to anything else yet.
//!
//! In: TOML that [`super::structure`] compared with the schema of these types. Out: input of [`super::check`].
//! The descriptions below are what the published schema says about each key.

use super::model::{Ease, OffsetUnit};
use crate::lattice::Basis;
use crate::solve::{EdgeWeights, Energy, Regularizer};
use schemars::JsonSchema;
use serde::Deserialize;

/// A shot of pinwarp: a scene, frames, layers with pins, and what is written.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields, title = "pinwarp shot")]
pub(super) struct RawShot {
    /// Version of the format.
    #[serde(default = "default_version")]
    #[schemars(range(min = 1, max = 1))]
    #[expect(dead_code, reason = "compared before the rest of the file is looked at; here for the schema")]
    pub(super) version: u32,
    /// The glTF scene (.gltf or .glb), relative to the shot file.
    #[schemars(length(min = 1), example = &"scene.glb")]
    pub(super) scene: String,
    /// Name of the camera or of its node; default: the scene's first, and where there is none the scene is framed.
    #[schemars(length(min = 1), example = &"ShotCam")]
    pub(super) camera: Option<String>,
    /// Frames, rate and clip.
    #[schemars(example = serde_json::json!({ "first": 1, "last": 48, "rate": 24 }))]
    pub(super) frames: RawFrames,
    /// Motion blur; without this table there is none.
    pub(super) shutter: Option<RawShutter>,
    /// Width and height of the frame, pixels.
    #[serde(default = "default_size")]
    #[schemars(inner(range(min = 1, max = 65536)), example = [1920, 1080])]
    pub(super) size: [u32; 2],
    /// Width of a pixel divided by its height.
    #[serde(default = "default_one")]
    #[schemars(range(min = 0.1, max = 10.0))]
    pub(super) pixel_aspect: f64,
    /// Samples a pixel, spread over the pixel and the shutter.
    #[serde(default = "default_samples")]
    #[schemars(range(min = 1, max = 4096))]
    pub(super) samples: u32,
    /// Strength of the neutral surroundings; default: 1 where the scene has no lights, else 0.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) environment: Option<f32>,
    /// Gain on all lights, stops.
    #[serde(default)]
    #[schemars(range(min = -32.0, max = 32.0))]
    pub(super) exposure: f32,
    /// Pins hold their offsets for this many frames, counted from the first; 1: they move all the time.
    #[serde(default = "default_step")]
    #[schemars(range(min = 1, max = 1000))]
    pub(super) step: u32,
    /// Scales offsets, rotations and log-scales of all layers; 0: no warp.
    #[serde(default = "default_one")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(super) strength: f64,
    /// What is warped: one lattice each.
    #[serde(default)]
    pub(super) layer: Vec<RawLayer>,
    /// What is written.
    #[serde(default)]
    pub(super) output: RawOutput,
}

/// Frames, rate and clip.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawFrames {
    /// First frame.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(super) first: i32,
    /// Last frame, included.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 48)]
    pub(super) last: i32,
    /// Frames a second.
    #[serde(default = "default_rate")]
    #[schemars(range(min = 0.01, max = 1000.0), example = 24)]
    pub(super) rate: f64,
    /// Name or number of the animation clip; default: the scene's first.
    #[schemars(example = &"Walk")]
    pub(super) clip: Option<RawClip>,
    /// The frame at which the clip starts; default: the first.
    #[schemars(range(min = -1_000_000, max = 1_000_000))]
    pub(super) clip_start: Option<i32>,
    /// The clip repeats instead of holding at its ends.
    #[serde(default, rename = "loop")]
    pub(super) is_looped: bool,
}

/// A clip by name or number.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum RawClip {
    /// Number in the file, from 0.
    Index(u32),
    /// Name.
    Name(#[schemars(length(min = 1))] String),
}

/// The shutter is open from frame + phase/360 to frame + (phase + angle)/360.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawShutter {
    /// Degrees; 360: open all the time, 0: no motion blur.
    #[serde(default = "default_angle")]
    #[schemars(range(min = 0.0, max = 360.0), example = 180)]
    pub(super) angle: f64,
    /// Degrees; default: -angle/2, which centres the blur on the frame.
    #[schemars(range(min = -360.0, max = 360.0), example = -90)]
    pub(super) phase: Option<f64>,
}

/// Scene nodes that one lattice deforms.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawLayer {
    /// Name, unique in the shot; default: layer1, layer2...
    #[schemars(length(min = 1), example = &"body")]
    pub(super) name: Option<String>,
    /// Patterns of node names with * and ?; each claims its subtree. Default: all nodes.
    #[schemars(length(min = 1), inner(length(min = 1)), example = ["Teapot*"])]
    pub(super) nodes: Option<Vec<String>>,
    /// The grid of handles.
    #[serde(default)]
    pub(super) lattice: RawLattice,
    /// The solver.
    #[serde(default)]
    pub(super) solve: RawSolve,
    /// As the shot's `step`, which it replaces.
    #[schemars(range(min = 1, max = 1000))]
    pub(super) step: Option<u32>,
    /// As the shot's `strength`, by which it is multiplied.
    #[serde(default = "default_one")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(super) strength: f64,
    /// Points and where they go.
    #[serde(default)]
    pub(super) pin: Vec<RawPin>,
    /// Handles moved by hand.
    #[serde(default)]
    pub(super) handle: Vec<RawHandle>,
}

/// The grid of handles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawLattice {
    /// Handles across and up.
    #[schemars(inner(range(min = 2, max = 64)), example = [10, 10])]
    pub(super) dims: [usize; 2],
    /// How handles are blended.
    pub(super) basis: Basis,
    /// Where the box of the grid comes from.
    #[serde(rename = "box")]
    pub(super) bounds: RawBox,
}

/// Where the box of the grid comes from.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawBox {
    /// It follows the layer.
    #[default]
    Follow,
    /// The whole frame.
    Frame,
    /// Always this: x and y of the lower left, x and y of the upper right corner, frame heights.
    Fixed(#[schemars(example = [0.0, 0.0, 1.778, 1.0])] [f64; 4]),
}

/// The solver: a preset, or its parts.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSolve {
    /// All settings at once, instead of the other keys.
    #[schemars(example = &"paper")]
    pub(super) preset: Option<RawPreset>,
    /// How distortion is measured; default: area.
    pub(super) energy: Option<Energy>,
    /// What holds handles that nothing else holds; default: bend.
    pub(super) regularizer: Option<Regularizer>,
    /// Weights of the edges, with energy = "edge".
    pub(super) weights: Option<EdgeWeights>,
}

/// Settings by name.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawPreset {
    /// The default: area and bend.
    Default,
    /// Exactly the paper's: edge and rest.
    Paper,
}

/// A point and where it goes.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawPin {
    /// Name, unique in its layer; default: pin1, pin2...
    #[schemars(length(min = 1), example = &"spout")]
    pub(super) name: Option<String>,
    /// What it is attached to.
    #[schemars(example = serde_json::json!({ "screen": [0.9, 0.5], "frame": 1 }))]
    pub(super) anchor: RawAnchor,
    /// Unit of the offsets.
    #[serde(default)]
    pub(super) unit: OffsetUnit,
    /// Where it goes, frames increasing; none: it holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(super) keys: Vec<RawPinKey>,
}

/// A point of a surface (node, triangle, barycentric) or of the screen (screen).
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawAnchor {
    /// Surface: name of the node.
    #[schemars(length(min = 1), example = &"Teapot")]
    pub(super) node: Option<String>,
    /// Surface: number of the primitive in the node's mesh, from 0; default: 0.
    #[schemars(range(min = 0, max = 4_294_967_295u32))]
    pub(super) primitive: Option<usize>,
    /// Surface: number of the triangle, from 0.
    #[schemars(range(min = 0, max = 4_294_967_295u32), example = 312)]
    pub(super) triangle: Option<usize>,
    /// Surface: weights of the triangle's corners; they sum to 1.
    #[schemars(example = [0.2, 0.5, 0.3])]
    pub(super) barycentric: Option<[f64; 3]>,
    /// Surface: the point's place in its node at rest, metres; tells when the scene has changed.
    #[schemars(example = [0.0, 1.0, 0.0])]
    pub(super) rest: Option<[f64; 3]>,
    /// Screen: x and y, frame heights, y up.
    #[schemars(example = [0.91, 0.52])]
    pub(super) screen: Option<[f64; 2]>,
    /// Screen: cast onto the surface seen there in this frame, which the pin then follows.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(super) frame: Option<i32>,
}

/// A key of a pin.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawPinKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(super) frame: f64,
    /// Added to the point's place, in `unit`; default: [0, 0].
    #[schemars(example = [0.06, 0.03])]
    pub(super) offset: Option<[f64; 2]>,
    /// Instead of `offset`: a place on the screen, frame heights, y up.
    #[schemars(example = [0.9, 0.5])]
    pub(super) target: Option<[f64; 2]>,
    /// Rotation held, degrees counter-clockwise; default: free, or 0 where another key has it.
    #[schemars(range(min = -36_000.0, max = 36_000.0), example = 20)]
    pub(super) rotate: Option<f64>,
    /// Scale held; default: free, or 1 where another key has it.
    #[schemars(range(min = 0.001, max = 1000.0), example = 1.2)]
    pub(super) scale: Option<f64>,
    /// Shape of the segment that leaves this key; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(super) ease: Ease,
}

/// A handle moved by hand.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawHandle {
    /// Column and row, from 0 at the lower left.
    #[schemars(inner(range(min = 0, max = 63)), example = [9, 4])]
    pub(super) index: [usize; 2],
    /// Where it goes, frames increasing; none: it holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(super) keys: Vec<RawHandleKey>,
}

/// A key of a handle.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawHandleKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(super) frame: f64,
    /// Added to the handle's place at rest, sizes of the lattice's box.
    #[schemars(example = [0.0, 0.1])]
    pub(super) offset: [f64; 2],
    /// Shape of the segment that leaves this key; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(super) ease: Ease,
}

/// What is written.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// EXR files with #### or %04d for the frame, relative to the shot file; default: out/<name of the shot>.####.exr.
    #[schemars(length(min = 1), example = &"out/shot.####.exr")]
    pub(super) path: Option<String>,
    /// Groups of channels; default: all.
    #[schemars(length(min = 1), example = ["beauty", "depth"])]
    pub(super) channels: Option<Vec<RawChannel>>,
    /// EXR compression; default: zip.
    pub(super) compression: Option<RawCompression>,
}

/// Groups of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawChannel {
    /// R, G, B, A.
    Beauty,
    /// depth.Z.
    Depth,
    /// forward.u, forward.v, backward.u, backward.v.
    Motion,
    /// N.X, N.Y, N.Z.
    Normal,
    /// id.layer, id.object.
    Id,
}

/// EXR compressions.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawCompression {
    /// None.
    None,
    /// Run lengths.
    Rle,
    /// Deflate, one line a block.
    Zips,
    /// Deflate, 16 lines a block.
    Zip,
    /// Wavelets.
    Piz,
    /// Lossy on colour.
    Dwaa,
    /// Lossy on colour, large blocks.
    Dwab,
}

impl Default for RawLattice {
    fn default() -> Self {
        Self { dims: [10, 10], basis: Basis::Bspline, bounds: RawBox::Follow }
    }
}

fn default_version() -> u32 {
    1
}

fn default_size() -> [u32; 2] {
    [1920, 1080]
}

fn default_one() -> f64 {
    1.0
}

fn default_samples() -> u32 {
    16
}

fn default_step() -> u32 {
    1
}

fn default_rate() -> f64 {
    24.0
}

fn default_angle() -> f64 {
    180.0
}
