//! The shot file as written: every key with its type, range and default, without relations between keys.
//!
//! In: TOML that [`super::structure`] compared with the schema of these types. Out: input of [`super::check`]. The
//! descriptions below are what the published schema says about each key.

mod camera;
mod connectivity;
mod image;
mod layer;
mod plate;
mod select;

pub(super) use camera::*;
pub(super) use connectivity::*;
pub(super) use image::*;
pub(super) use layer::*;
pub(super) use plate::*;
pub(super) use select::*;

use schemars::JsonSchema;
use serde::Deserialize;

/// A shot of pinwarp: a scene, pictures or a plate, frames, layers with pins, and what is written.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields, title = "pinwarp shot")]
pub(super) struct RawShot {
    /// Version of the format.
    #[serde(default = "default_version")]
    #[schemars(range(min = 1, max = 1))]
    #[expect(dead_code, reason = "compared before the rest of the file is looked at; here for the schema")]
    pub(super) version: u32,
    /// The glTF scene (.gltf or .glb), relative to the shot file; a shot without one has an `image` or a `plate`.
    #[schemars(length(min = 1), example = &"scene.glb")]
    pub(super) scene: Option<String>,
    /// Instead of a scene: a picture (PNG, JPEG, EXR), or several of one size from back to front, relative to the shot file.
    #[schemars(example = &"girl.png")]
    pub(super) image: Option<RawImage>,
    /// Finished frames that `pinwarp warp` warps, relative to the shot file, with #### or %04d for the frame.
    #[schemars(length(min = 1), example = &"beauty.####.exr")]
    pub(super) plate: Option<String>,
    /// How they are warped.
    #[serde(default)]
    pub(super) warp: RawWarp,
    /// Name of the camera or of its node, a view such as "front", or a table; default: the scene's first, and where there is
    /// none one that shows the whole scene.
    #[schemars(example = &"ShotCam")]
    pub(super) camera: Option<RawCamera>,
    /// Nodes that are not drawn: patterns of names, each with what hangs below it.
    #[serde(default)]
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["*Sword*"]))]
    pub(super) hide: Vec<String>,
    /// Nodes that are drawn although `hide` matches; without `hide` nothing else is drawn.
    #[serde(default)]
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["Knight_*"]))]
    pub(super) show: Vec<String>,
    /// Frames, rate and clip.
    #[schemars(example = serde_json::json!({ "first": 1, "last": 48, "rate": 24 }))]
    pub(super) frames: RawFrames,
    /// First and last frame that layers with a temporal weight are solved over: frames inside keep their bits when the shot is
    /// trimmed. Default: the frames of the shot.
    #[schemars(inner(range(min = -1_000_000, max = 1_000_000)), example = serde_json::json!([1, 48]))]
    pub(super) solve_range: Option<[i32; 2]>,
    /// Motion blur; without this table there is none.
    pub(super) shutter: Option<RawShutter>,
    /// Width and height of the frame, pixels; default: [1920, 1080], of pictures the size of the first.
    #[schemars(inner(range(min = 1, max = 65536)), example = serde_json::json!([1920, 1080]))]
    pub(super) size: Option<[u32; 2]>,
    /// Width of a pixel divided by its height; default: 1, of pictures as the first says.
    #[schemars(range(min = 0.1, max = 10.0), example = 1.0)]
    pub(super) pixel_aspect: Option<f64>,
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
    Index(#[schemars(range(min = 0, max = 4_294_967_295u32))] u32),
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

/// What is written.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// EXR files with #### or %04d for the frame, relative to the shot file; default: out/<name of the shot>.####.exr.
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
    /// Mattes of all names: CryptoObject, CryptoMaterial, CryptoLayer, six ranks each.
    Cryptomatte,
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
