//! The checked shot: plain data that the later stages read.
//!
//! In: what [`super::check`] accepted. Out: types only, no rules.

use super::{CameraRule, ColorChannel, Connectivity, KeyLines, Selection, Visibility};
use crate::image::Compression;
use crate::lattice::Basis;
use crate::plate::{Matte, WarpSettings};
use crate::raster::ChannelGroup;
use crate::solve::Settings;
use crate::space::{FrameSize, ScreenBox, ScreenPoint, ScreenVector};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A checked shot. Paths are relative to the shot file's folder in the file, resolved here.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The shot file.
    pub path: PathBuf,
    /// Where its keys stand, for messages.
    pub lines: KeyLines,
    /// What the lattices are laid over.
    pub source: Source,
    /// Finished frames that `pinwarp warp` warps, a path with a frame counter; `None`: named on the command line.
    pub plate: Option<PathBuf>,
    /// How they are warped.
    pub warp: WarpSettings,
    /// Which camera sees it.
    pub camera: CameraRule,
    /// Which nodes of the scene are drawn.
    pub visibility: Visibility,
    /// The scene may refer to files outside its folder. No key of the file: whoever runs the program decides.
    pub allow_outside: bool,
    /// Name or index of the clip; `None`: the scene's first, if it has any.
    pub clip: Option<ClipName>,
    /// The clip repeats.
    pub is_looped: bool,
    /// Frames and rate.
    pub frames: FrameRange,
    /// First and last frame that layers with a temporal weight are solved over.
    pub solve_range: [i32; 2],
    /// Motion blur.
    pub shutter: Shutter,
    /// The frame.
    pub size: FrameSize,
    /// Sub-pixel (and sub-frame) samples a pixel, ≥ 1.
    pub samples: u32,
    /// Strength of the neutral surroundings; `None`: 1 where the scene has no lights, else 0.
    pub environment: Option<f32>,
    /// Gain on all lights, in stops (`exposure`).
    pub exposure_stops: f32,
    /// Layers, in order.
    pub layers: Vec<Layer>,
    /// What is written.
    pub output: Output,
}

impl Shot {
    /// The glTF scene, where the shot has one.
    #[must_use]
    pub fn scene(&self) -> Option<&Path> {
        match &self.source {
            Source::Scene(path) => Some(path),
            Source::Images(_) | Source::Frame => None,
        }
    }

    /// The files that it names, but for sequences: scene or pictures, masks, and lattices from elsewhere.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let drawn = match &self.source {
            Source::Scene(scene) => std::slice::from_ref(scene),
            Source::Images(images) => images,
            Source::Frame => &[],
        };
        let selections = self.layers.iter().flat_map(|layer| layer.connectivity.selections().chain([&layer.selection]));
        let masks = selections.filter_map(|selection| Some(&selection.mask.as_ref()?.file));
        let lattices = self.layers.iter().filter_map(|layer| Some(&layer.transfer.as_ref()?.file));
        drawn.iter().chain(masks).chain(lattices)
    }
}

/// What the lattices of a shot are laid over.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// A glTF scene.
    Scene(PathBuf),
    /// Pictures, from back to front: each becomes a node named after its file (or its EXR layer), outlined by its alpha.
    Images(Vec<PathBuf>),
    /// Nothing but the frame itself, as one flat card: shots that warp whole plates.
    Frame,
}

/// A clip by name or number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClipName {
    /// By its name.
    Name(String),
    /// By its index in the file.
    Index(usize),
}

/// Frames of the shot; animation time in seconds = (frame − clip_start) / rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRange {
    /// First frame.
    pub first: i32,
    /// Last frame, included.
    pub last: i32,
    /// Frames a second.
    pub rate: f64,
    /// The frame at which the clip starts.
    pub clip_start: i32,
}

impl FrameRange {
    /// Animation time of a (fractional) frame, seconds.
    #[must_use]
    pub fn seconds(&self, frame: f64) -> f64 {
        (frame - f64::from(self.clip_start)) / self.rate
    }

    /// Number of frames, first and last included.
    #[must_use]
    pub fn count(&self) -> usize {
        usize::try_from(i64::from(self.last) - i64::from(self.first) + 1).unwrap_or(0)
    }
}

/// The shutter: open from frame + phase/360 to frame + (phase + angle)/360.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Degrees, 0..=360; 0: no motion blur.
    pub angle: f64,
    /// Degrees; −angle/2 centres the blur on the frame.
    pub phase: f64,
}

/// Scene nodes that one lattice deforms.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name, unique in the shot.
    pub name: String,
    /// Patterns of node names (`*` and `?`); each takes its subtree, with a `!` before it takes it out. Where none takes:
    /// all nodes.
    pub nodes: Vec<String>,
    /// Which part of the meshes of those nodes.
    pub selection: Selection,
    /// Where the lattice lies, its handles and its box.
    pub space: LayerSpace,
    /// The dims of `space` are chosen when the shot is prepared, from the thinnest parts of the layer and its nearest pins.
    pub has_auto_dims: bool,
    /// What separates and joins its parts, for lattices that branch.
    pub connectivity: Connectivity,
    /// Basis of the lattice.
    pub basis: Basis,
    /// The solver's settings.
    pub settings: Settings,
    /// Offsets are held for this many frames, counted from the first frame of the shot; 1: every frame.
    pub step: u32,
    /// Scales offsets, rotations and log-scales (shot's strength times layer's).
    pub strength: f64,
    /// Parts that are stiffer or softer than the rest.
    pub stiffness: Vec<StiffnessRule>,
    /// Pins.
    pub pins: Vec<Pin>,
    /// Moved handles.
    pub handles: Vec<HandleTrack>,
    /// Lattices solved elsewhere, instead of pins and handles.
    pub transfer: Option<Transfer>,
    /// The part of a plate that the layer moves; `None`: see [`Self::unmatted`].
    pub matte: Option<Matte>,
    /// What of a plate the layer moves where it names no matte.
    pub unmatted: Unmatted,
}

/// What of a plate a layer moves that names no matte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unmatted {
    /// Its own nodes, where the shot has a scene and the layer does not move all of it; else the whole picture.
    #[default]
    OwnNodes,
    /// The whole picture, background and all: `matte = "none"`.
    Picture,
}

/// Lattices solved for another shot, laid over a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// The lattice file.
    pub file: PathBuf,
    /// Layer of that file; `None`: its only one.
    pub layer: Option<String>,
    /// Where the lattices go.
    pub fit: TransferFit,
    /// Frame of the shot that shows the first frame of the file; `None`: equal frame numbers.
    pub start: Option<i32>,
}

/// Where transferred lattices go.
#[derive(Clone, Debug, PartialEq)]
pub enum TransferFit {
    /// Their box becomes the box of the layer in that frame.
    Box,
    /// The same place on the screen.
    AsIs,
    /// Points there and here.
    Landmarks(Vec<[ScreenPoint; 2]>),
}

/// Where a layer's lattice lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayerSpace {
    /// On the screen: it moves what the camera sees.
    Screen {
        /// Handles across and up.
        dims: [usize; 2],
        /// Where its box comes from.
        bounds: BoxRule,
    },
    /// In the scene: it moves the meshes themselves.
    World {
        /// Handles along x, y and z.
        dims: [usize; 3],
        /// Where its box comes from.
        bounds: WorldBoxRule,
    },
}

impl LayerSpace {
    /// Handles along x, y and z; one layer of them on the screen.
    #[must_use]
    pub const fn dims(self) -> [usize; 3] {
        match self {
            Self::Screen { dims: [nx, ny], .. } => [nx, ny, 1],
            Self::World { dims, .. } => dims,
        }
    }
}

/// Where the rest box of a lattice in the scene comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorldBoxRule {
    /// The layer's bounds in the frame of the node that carries all of it, padded and smoothed over frames.
    Follow,
    /// Always this: lower and upper corner, scene space, metres.
    Fixed([[f64; 3]; 2]),
}

/// Where the rest box of a lattice on the screen comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxRule {
    /// The layer's bounds, padded and smoothed over frames.
    Follow,
    /// Always this.
    Fixed(ScreenBox),
    /// The whole frame.
    Frame,
}

/// A point of the model and where it has to go.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// Name, unique in its layer.
    pub name: String,
    /// What it is attached to.
    pub anchor: Anchor,
    /// Unit of the offsets.
    pub unit: OffsetUnit,
    /// What it takes along; `None`: its point alone.
    pub region: Option<PinRegion>,
    /// 0..=1: how firmly it holds its point, in powers of ten; 1: exactly.
    pub weight: f64,
    /// It does not act.
    pub is_muted: bool,
    /// Where parts of a picture overlap, that around the pin of the greater order lies in front: keys, held, frames strictly
    /// increasing. Empty: 0.
    pub order: Vec<OrderKey>,
    /// Keys, frames strictly increasing, at least one.
    pub keys: Vec<PinKey>,
}

impl Pin {
    /// The order at a (fractional) frame.
    #[must_use]
    pub fn order_at(&self, frame: f64) -> i32 {
        let before = self.order.partition_point(|key| key.frame <= frame);
        self.order.get(before.saturating_sub(1)).map_or(0, |key| key.value)
    }
}

/// A key of a pin's order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderKey {
    /// When.
    pub frame: f64,
    /// The order from there on.
    pub value: i32,
}

/// The neighbourhood that a pin takes along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinRegion {
    /// Distance of its rim from the pin: frame heights (world layers: metres), with [`OffsetUnit::Box`] diagonals of the
    /// lattice's box.
    pub radius: f64,
    /// How firmly it moves as one piece, 0..=1.
    pub rigidity: f64,
    /// Multiplier of the stiffness at the pin; 1 at the rim.
    pub stiffness: f64,
}

/// An entry of `[[layer.stiffness]]`; entries that meet multiply.
#[derive(Clone, Debug, PartialEq)]
pub struct StiffnessRule {
    /// What is stiff.
    pub part: StiffPart,
    /// How stiff it is, above 0; 1 is as everything else.
    pub value: f64,
}

/// What a layer is stiff in.
#[derive(Clone, Debug, PartialEq)]
pub enum StiffPart {
    /// Patterns of node names, each with its subtree.
    Nodes(Vec<String>),
    /// Everything of a material.
    Material(String),
    /// Where a channel of the vertex colours is 1; 0 is not stiff, in between it mixes.
    VertexColor(ColorChannel),
}

/// What a pin is attached to.
#[derive(Clone, Debug, PartialEq)]
pub enum Anchor {
    /// A point of a triangle.
    Surface {
        /// Node name.
        node: String,
        /// Index of the primitive in the node's mesh.
        primitive: usize,
        /// Index of the triangle.
        triangle: usize,
        /// Weights of its corners; they sum to 1.
        barycentric: [f64; 3],
        /// The point's place in its node at rest, metres, as stored when the pin was made.
        rest: Option<[f64; 3]>,
    },
    /// A point of the screen.
    Screen {
        /// Where.
        at: ScreenPoint,
        /// Cast once onto the front-most unwarped surface of this frame, then it follows the surface.
        frame: Option<i32>,
    },
}

/// Unit of a pin's offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OffsetUnit {
    /// Frame heights; metres where an offset has three numbers.
    #[default]
    Frame,
    /// Sizes of the lattice box.
    Box,
}

/// A key of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinKey {
    /// When.
    pub frame: f64,
    /// Where to.
    pub goal: Goal,
    /// Rotation it holds, degrees; `None`: it holds none.
    pub rotate_degrees: Option<Rotation>,
    /// Scale it holds; `None`: it holds none.
    pub scale: Option<f64>,
    /// Shapes the segment that leaves this key.
    pub ease: Ease,
}

/// Where a key sends its pin. All keys of a pin are of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Added to the projected anchor; in world layers at the anchor's depth.
    Offset(ScreenVector),
    /// An absolute place; in world layers at the anchor's depth.
    Target(ScreenPoint),
    /// World layers: added to the anchor in scene space, metres (or box sizes along the axes of the box).
    SceneOffset([f64; 3]),
    /// World layers: a point of scene space, metres.
    SceneTarget([f64; 3]),
}

/// A rotation held. All rotations of a pin are of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// About the camera's view axis, counter-clockwise as it is seen.
    InView(f64),
    /// World layers: about x, then y, then z of the scene (or of the box, where offsets are in box sizes).
    Axes([f64; 3]),
}

/// The shape of a segment between keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Ease {
    /// Keeps the value until the next key.
    Hold,
    /// Straight.
    #[default]
    Linear,
    /// Slow in, slow out: 3t² − 2t³.
    Smooth,
    /// A CSS-like cubic curve through (0,0), (x1,y1), (x2,y2), (1,1); x1, x2 in 0..=1.
    Bezier([f64; 4]),
}

/// Keys of one lattice handle.
#[derive(Clone, Debug, PartialEq)]
pub struct HandleTrack {
    /// Column, row and layer; on the screen the layer is 0.
    pub index: [usize; 3],
    /// Frame, offset in box sizes, ease; frames strictly increasing.
    pub keys: Vec<HandleKey>,
}

/// A key of a handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandleKey {
    /// When.
    pub frame: f64,
    /// Offset from the rest handle, in box sizes along its axes; on the screen the third is 0.
    pub offset: [f64; 3],
    /// Shapes the segment that leaves this key.
    pub ease: Ease,
}

/// What is written where.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// `frame.####.exr` or `frame.%04d.exr`, resolved against the shot's folder.
    pub path: PathBuf,
    /// Channel groups.
    pub channels: Vec<ChannelGroup>,
    /// EXR compression.
    pub compression: Compression,
}

/// What the keys say at one time: one entry a pin and a handle of the layer, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PinTargets {
    /// As many as pins.
    pub pins: Vec<PinTarget>,
    /// As many as handles: offset in box sizes along its axes (on the screen the third is 0), strength applied.
    pub handles: Vec<[f64; 3]>,
}

/// Where one pin has to go at one time, strength and step applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinTarget {
    /// Offset (in the pin's unit) or absolute target. Strength scales offsets; towards a target it is applied by the
    /// pipeline: anchor + strength·(target − anchor).
    pub goal: Goal,
    /// Radians; `None`: free.
    pub rotation: Option<Rotation>,
    /// Natural logarithm of the scale; `None`: free.
    pub log_scale: Option<f64>,
}
