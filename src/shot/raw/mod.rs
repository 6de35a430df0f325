//! The shot file as written: every key with its type, range and default, without relations between keys.
//!
//! In: TOML that [`super::structure`] compared with the schema of these types. Out: input of [`super::check`]. The doc comments
//! below are the descriptions of the keys in the published schema.

mod camera;
mod connectivity;
mod image;
mod layer;
mod order;
mod plate;
mod select;

pub(super) use camera::*;
pub(super) use connectivity::*;
pub(super) use image::*;
pub(super) use layer::*;
pub(super) use order::*;
pub(super) use plate::*;
pub(super) use select::*;

use schemars::JsonSchema;
use serde::Deserialize;

/// A shot of pinwarp: a scene, pictures or a plate, a range of frames, layers with pins, and the output.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields, title = "pinwarp shot")]
pub(super) struct RawShot {
    /// Version of the format.
    #[serde(default = "default_version")]
    #[schemars(range(min = 1, max = 1))]
    #[expect(dead_code, reason = "compared before the rest of the file is looked at; here for the schema")]
    pub(super) version: u32,
    /// The glTF scene (.gltf or .glb), relative to the shot file. Required without `image` and `plate`.
    #[schemars(length(min = 1), example = &"scene.glb")]
    pub(super) scene: Option<String>,
    /// Replaces the scene with a picture (PNG, JPEG, EXR), or several of one size from back to front, relative to the shot file. Beside
    /// `plate`, its reference frame.
    #[schemars(example = &"girl.png")]
    pub(super) image: Option<RawImage>,
    /// Finished frames that `pinwarp warp` warps, relative to the shot file, with #### or %04d for the frame number.
    #[schemars(length(min = 1), example = &"beauty.####.exr")]
    pub(super) plate: Option<String>,
    /// How finished frames are warped.
    #[serde(default)]
    pub(super) warp: RawWarp,
    /// Name of a camera or of its node, a view such as "front", or a camera defined in the shot; default: the scene's first
    /// camera. A scene without cameras is shown whole.
    #[schemars(example = &"ShotCam")]
    pub(super) camera: Option<RawCamera>,
    /// Patterns of node names: matching nodes and their subtrees are not drawn.
    #[serde(default)]
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["*Sword*"]))]
    pub(super) hide: Vec<String>,
    /// Patterns of names of nodes that are drawn even if `hide` matches them. Without `hide`, only these nodes are drawn.
    #[serde(default)]
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["Knight_*"]))]
    pub(super) show: Vec<String>,
    /// First and last frame, frame rate and animation clip.
    #[schemars(example = serde_json::json!({ "first": 1, "last": 48, "rate": 24 }))]
    pub(super) frames: RawFrames,
    /// First and last frame of the range over which layers with a temporal weight are solved. Frames inside the range stay
    /// bit-identical when `frames` is trimmed. Default: the frames of the shot.
    #[schemars(inner(range(min = -1_000_000, max = 1_000_000)), example = serde_json::json!([1, 48]))]
    pub(super) solve_range: Option<[i32; 2]>,
    /// Motion blur; default: none.
    pub(super) shutter: Option<RawShutter>,
    /// Width and height of the frame in pixels; default: that of the first picture, or of the plate; for a scene [1920, 1080].
    #[schemars(inner(range(min = 1, max = 65536)), example = serde_json::json!([1920, 1080]))]
    pub(super) size: Option<[u32; 2]>,
    /// Width of a pixel divided by its height; default: that of the first picture, or of the plate; for a scene 1.
    #[schemars(range(min = 0.1, max = 10.0), example = 1.0)]
    pub(super) pixel_aspect: Option<f64>,
    /// Samples per pixel, distributed over the pixel and the shutter interval.
    #[serde(default = "default_samples")]
    #[schemars(range(min = 1, max = 4096))]
    pub(super) samples: u32,
    /// Strength of the neutral environment light; default: 1 if the scene has no lights, else 0.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub(super) environment: Option<f32>,
    /// Gain on all lights, stops.
    #[serde(default)]
    #[schemars(range(min = -32.0, max = 32.0))]
    pub(super) exposure: f32,
    /// Number of frames for which pins hold their offsets, counted from the first frame: 2 is "on twos". At 1 nothing is held.
    #[serde(default = "default_step")]
    #[schemars(range(min = 1, max = 1000))]
    pub(super) step: u32,
    /// Scales the offsets, rotations and log-scales of all layers; 0 means no warp.
    #[serde(default = "default_one")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(super) strength: f64,
    /// Layers; each is deformed by one lattice.
    #[serde(default)]
    pub(super) layer: Vec<RawLayer>,
    /// The files to write.
    #[serde(default)]
    pub(super) output: RawOutput,
}

/// First and last frame, frame rate and animation clip.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawFrames {
    /// First frame.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(super) first: i32,
    /// Last frame, inclusive.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 48)]
    pub(super) last: i32,
    /// Frames per second.
    #[serde(default = "default_rate")]
    #[schemars(range(min = 0.01, max = 1000.0), example = 24)]
    pub(super) rate: f64,
    /// Name or number of the animation clip; default: the scene's first.
    #[schemars(example = &"Walk")]
    pub(super) clip: Option<RawClip>,
    /// The frame at which the clip starts; default: `first`.
    #[schemars(range(min = -1_000_000, max = 1_000_000))]
    pub(super) clip_start: Option<i32>,
    /// Repeats the clip instead of holding it at its ends.
    #[serde(default, rename = "loop")]
    pub(super) is_looped: bool,
}

/// An animation clip, by name or number.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum RawClip {
    /// Number in the file, from 0.
    Index(#[schemars(range(min = 0, max = 4_294_967_295u32))] u32),
    /// Name.
    Name(#[schemars(length(min = 1))] String),
}

/// The shutter, which is open from frame + phase/360 to frame + (phase + angle)/360.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawShutter {
    /// Shutter angle, degrees. 360: always open, 0: no motion blur.
    #[serde(default = "default_angle")]
    #[schemars(range(min = 0.0, max = 360.0), example = 180)]
    pub(super) angle: f64,
    /// Start of the exposure relative to the frame, degrees; default: -angle/2, which centres the blur on the frame.
    #[schemars(range(min = -360.0, max = 360.0), example = -90)]
    pub(super) phase: Option<f64>,
}

/// The files to write.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// EXR files with #### or %04d for the frame number, relative to the shot file; default: out/<name of the shot>.####.exr.
    #[schemars(length(min = 1), example = &"out/shot.####.exr")]
    pub(super) path: Option<String>,
    /// Groups of channels; default: all but cryptomatte.
    #[schemars(length(min = 1), example = serde_json::json!(["beauty", "depth"]))]
    pub(super) channels: Option<Vec<RawChannel>>,
    /// EXR compression; default: zip.
    pub(super) compression: Option<RawCompression>,
}

/// Groups of channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawChannel {
    /// Colour and alpha: R, G, B, A.
    Beauty,
    /// Depth: depth.Z.
    Depth,
    /// Motion vectors: forward.u, forward.v, backward.u, backward.v.
    Motion,
    /// Normals: N.X, N.Y, N.Z.
    Normal,
    /// Ids: id.layer, id.object.
    Id,
    /// Cryptomattes of all names: CryptoObject, CryptoMaterial, CryptoLayer, six ranks each.
    Cryptomatte,
}

/// EXR compressions.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawCompression {
    /// No compression.
    None,
    /// Run-length encoding.
    Rle,
    /// Deflate, blocks of one line.
    Zips,
    /// Deflate, blocks of 16 lines.
    Zip,
    /// Wavelets.
    Piz,
    /// Lossy for colour.
    Dwaa,
    /// Lossy for colour, in larger blocks.
    Dwab,
}

fn default_version() -> u32 {
    1
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
