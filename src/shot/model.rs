//! The validated shot: plain data for the later stages.
//!
//! In: what [`super::check`] accepted. Out: types only, no rules.

use super::order::OrderKey;
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

/// A validated shot. Paths in the file are relative to its folder; here they are resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// The shot file.
    pub path: PathBuf,
    /// The lines of its keys, for messages.
    pub(crate) lines: KeyLines,
    /// The source that the lattices deform.
    pub(crate) source: Source,
    /// Finished frames for `pinwarp warp`, as a path with a frame counter; `None`: given on the command line.
    pub plate: Option<PathBuf>,
    /// The settings of plate warps.
    pub warp: WarpSettings,
    /// The camera.
    pub(crate) camera: CameraRule,
    /// The drawn nodes of the scene.
    pub(crate) visibility: Visibility,
    /// Whether the scene may refer to files outside its folder. Not a key of the file: the user who runs the program
    /// decides.
    pub allow_outside: bool,
    /// Name or index of the clip; `None`: the scene's first, if it has any.
    pub(crate) clip: Option<ClipName>,
    /// Whether the clip loops.
    pub is_looped: bool,
    /// Frame range and rate.
    pub frames: FrameRange,
    /// First and last frame that layers with a temporal weight are solved over.
    pub solve_range: [i32; 2],
    /// Motion blur.
    pub shutter: Shutter,
    /// The frame size.
    pub size: FrameSize,
    /// Sub-pixel (and sub-frame) samples per pixel, ≥ 1.
    pub samples: u32,
    /// Intensity of the neutral environment light; `None`: 1 if the scene has no lights, else 0.
    pub environment: Option<f32>,
    /// Gain on all lights, in stops (`exposure`).
    pub exposure_stops: f32,
    /// Layers, in order.
    pub layers: Vec<Layer>,
    /// The output files.
    pub output: Output,
}

impl Shot {
    /// Returns the glTF scene, if the shot has one.
    #[must_use]
    pub fn scene(&self) -> Option<&Path> {
        match &self.source {
            Source::Scene(path) => Some(path),
            Source::Images(_) | Source::Frame => None,
        }
    }

    /// Returns the index of the layer of this name.
    #[must_use]
    pub(crate) fn layer_index(&self, name: &str) -> Option<usize> {
        self.layers.iter().position(|layer| layer.name == name)
    }

    /// Gives mirrored pins the keys of the pins that they follow, after those have changed.
    #[cfg(any(test, feature = "editor"))]
    pub(crate) fn copy_mirrored_keys(&mut self) {
        for layer in 0..self.layers.len() {
            for pin in 0..self.layers[layer].pins.len() {
                if let Some(mirror) = self.layers[layer].pins[pin].mirror {
                    let followed = self.layers[mirror.layer].pins[mirror.pin].clone();
                    self.layers[layer].pins[pin].copy_keys(&followed);
                }
            }
        }
    }

    /// Returns the files that the shot refers to, except sequences: scene or pictures, masks and other pictures that cut, and lattices
    /// to transfer.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        let drawn = match &self.source {
            Source::Scene(scene) => std::slice::from_ref(scene),
            Source::Images(images) => images,
            Source::Frame => &[],
        };
        let masks = self.layers.iter().flat_map(|layer| {
            let cuts = layer.connectivity.cuts.iter().filter_map(|cut| Some(cut.file()?.1));
            cuts.chain(layer.selection.mask.as_ref().map(|mask| &mask.file))
        });
        let lattices = self.layers.iter().filter_map(|layer| Some(&layer.transfer.as_ref()?.file));
        drawn.iter().chain(masks).chain(lattices)
    }
}

/// The source that the lattices of a shot deform.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// A glTF scene.
    Scene(PathBuf),
    /// Pictures, from back to front: each becomes a node named after its file (or its EXR layer), with the outline of
    /// its alpha.
    Images(Vec<PathBuf>),
    /// Only the frame itself, as one flat card: shots that warp whole plates.
    Frame,
}

/// A clip, by name or index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ClipName {
    /// By its name.
    Name(String),
    /// By its index in the file.
    Index(usize),
}

/// The frames of a shot; animation time in seconds = (frame − clip_start) / rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRange {
    /// First frame.
    pub first: i32,
    /// Last frame, included.
    pub last: i32,
    /// Frames per second.
    pub rate: f64,
    /// The frame at which the clip starts.
    pub clip_start: i32,
}

impl Shot {
    /// The frame in which what holds for the whole shot is measured, such as lattices with `dims = "auto"`: the first that is solved.
    /// Trimming `frames` does not move it.
    pub(crate) const fn reference_frame(&self) -> i32 {
        self.solve_range[0]
    }
}

impl FrameRange {
    /// Returns the animation time of a (fractional) frame in seconds.
    #[must_use]
    pub fn seconds(&self, frame: f64) -> f64 {
        (frame - f64::from(self.clip_start)) / self.rate
    }

    /// Returns the number of frames, first and last included.
    #[must_use]
    pub(crate) fn count(&self) -> usize {
        usize::try_from(i64::from(self.last) - i64::from(self.first) + 1).unwrap_or(0)
    }
}

/// The shutter: open from frame + phase/360 to frame + (phase + angle)/360.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Shutter angle in degrees, 0..=360; 0: no motion blur.
    pub angle: f64,
    /// Phase in degrees; −angle/2 centres the blur on the frame.
    pub phase: f64,
}

impl Shutter {
    /// No motion blur.
    pub(crate) const CLOSED: Self = Self { angle: 0.0, phase: 0.0 };
}

/// Scene nodes deformed by one lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Name, unique in the shot.
    pub name: String,
    /// Patterns of node names (`*` and `?`); each includes its subtree, or excludes it with a leading `!`. If nothing
    /// is included: all nodes.
    pub nodes: Vec<String>,
    /// The part of the meshes of those nodes.
    pub(crate) selection: Selection,
    /// The lattice's space, its handles and its box.
    pub space: LayerSpace,
    /// The orientation of its box.
    pub(crate) orientation: BoxOrientation,
    /// Whether the dims of `space` are chosen during preparation, from the thinnest parts of the layer and its nearest
    /// pins.
    pub has_auto_dims: bool,
    /// Whether the shot leaves the topology of the lattice open. Over pictures it then branches where it can.
    pub has_auto_topology: bool,
    /// Cuts and joins of its parts, for branching lattices.
    pub(crate) connectivity: Connectivity,
    /// Basis of the lattice.
    pub basis: Basis,
    /// The solver's settings.
    pub settings: Settings,
    /// Number of frames for which offsets are held, counted from the first frame of the shot; 1: not held.
    pub step: u32,
    /// Factor of offsets, rotations and log-scales: the shot's strength times the layer's; 0 if the layer is muted.
    pub strength: f64,
    /// Whether the layer is muted: it is at rest.
    pub is_muted: bool,
    /// Parts that are stiffer or softer than the rest.
    pub(crate) stiffness: Vec<StiffnessRule>,
    /// Brush strokes of stiffness, which multiply what the rules say, in the order of the file.
    pub(crate) strokes: Vec<BrushStroke>,
    /// The plane at which mirrored pins are reflected; `None`: the layer's own plane of symmetry at rest.
    pub(crate) symmetry: Option<AxisPlane>,
    /// Pins.
    pub pins: Vec<Pin>,
    /// Manually moved handles.
    pub(crate) handles: Vec<HandleTrack>,
    /// Lattices solved elsewhere, which replace pins and handles.
    pub transfer: Option<Transfer>,
    /// The part of a plate that the layer moves; `None`: see [`Self::unmatted`].
    pub matte: Option<Matte>,
    /// The part of a plate that the layer moves if it has no matte.
    pub unmatted: Unmatted,
}

/// The part of a plate moved by a layer without a matte.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unmatted {
    /// Its own nodes, if the shot has a scene and the layer does not move all of it; else the whole picture.
    #[default]
    OwnNodes,
    /// Its own nodes, even where it moves all of the scene: `matte = "nodes"`.
    Nodes,
    /// The whole picture, background included: `matte = "none"`.
    Picture,
}

/// Lattices solved for another shot, applied to a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfer {
    /// The lattice file.
    pub file: PathBuf,
    /// Layer of that file; `None`: its only one.
    pub layer: Option<String>,
    /// How the lattices are placed.
    pub fit: TransferFit,
    /// Frame of the shot that shows the first frame of the file; `None`: frame numbers correspond.
    pub start: Option<i32>,
}

/// How transferred lattices are placed.
#[derive(Clone, Debug, PartialEq)]
pub enum TransferFit {
    /// Their box is mapped to the box of the layer in each frame.
    Box,
    /// At the same position on the screen.
    AsIs,
    /// Aligned by landmarks: pairs of points in the original and in this shot.
    Landmarks(Vec<[ScreenPoint; 2]>),
}

/// The space of a layer's lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayerSpace {
    /// Screen space: it deforms the camera's view.
    Screen {
        /// Number of handles across and up.
        dims: [usize; 2],
        /// The source of its box.
        bounds: BoxRule,
    },
    /// World space: it deforms the meshes themselves.
    World {
        /// Number of handles along x, y and z.
        dims: [usize; 3],
        /// The source of its box.
        bounds: WorldBoxRule,
    },
}

impl Layer {
    /// Whether the lattice may branch.
    pub(crate) fn can_branch(&self) -> bool {
        self.basis.can_branch() && self.settings.branching_fault().is_none()
    }
}

impl LayerSpace {
    /// Returns the number of handles along x, y and z; in screen space one layer of them.
    #[must_use]
    pub(crate) const fn dims(self) -> [usize; 3] {
        match self {
            Self::Screen { dims: [nx, ny], .. } => [nx, ny, 1],
            Self::World { dims, .. } => dims,
        }
    }
}

/// The source of the rest box of a world-space lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WorldBoxRule {
    /// The layer's bounds in the frame of the node that carries all of it, padded and smoothed over frames.
    Follow,
    /// A fixed box: lower and upper corner in scene space, in metres.
    Fixed([[f64; 3]; 2]),
}

/// The source of the rest box of a screen-space lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxRule {
    /// The layer's bounds, padded and smoothed over frames.
    Follow,
    /// A fixed box.
    Fixed(ScreenBox),
    /// The whole frame.
    Frame,
}

/// The orientation of a lattice's box: the key `lattice.frame`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BoxOrientation {
    /// A node that the box turns with. On the screen the box's second axis points along an axis of the node (0, 1, 2 for
    /// x, y, z) as the camera sees it; in the scene the box has the axes of the node.
    pub node: Option<(String, usize)>,
    /// Angle in radians by which the box is rotated further on the screen, counter-clockwise.
    pub angle: f64,
}

/// A plane perpendicular to an axis of the scene at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisPlane {
    /// The axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// The plane's coordinate on it: metres, in pictures and plates frame heights.
    pub at: f64,
}

/// The pin on the other side of the model that a mirrored pin follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mirror {
    /// Index of its layer in the shot.
    pub layer: usize,
    /// Its index in that layer.
    pub pin: usize,
    /// Whether the mirrored pin is attached to the mirrored point, in place of an anchor of its own.
    pub is_anchor_mirrored: bool,
}

/// A point of the model with its target over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// Name, unique in its layer.
    pub name: String,
    /// Its anchor; that of the other pin if its mirror includes the anchor.
    pub anchor: Anchor,
    /// The pin whose mirrored keys it takes; `keys` and `unit` are those of that pin.
    pub(crate) mirror: Option<Mirror>,
    /// Unit of the offsets.
    pub(crate) unit: OffsetUnit,
    /// The region that it carries; `None`: only its point.
    pub(crate) region: Option<PinRegion>,
    /// Weight, 0..=1, on a logarithmic scale: how firmly it holds its point; 1: exactly.
    pub weight: f64,
    /// Whether it is inactive.
    pub is_muted: bool,
    /// Depth order where parts of a picture overlap: the part around the pin of higher order lies in front. Stepped
    /// keys, frames strictly increasing. Empty: 0.
    pub(crate) order: Vec<OrderKey>,
    /// Keys, frames strictly increasing, at least one.
    pub keys: Vec<PinKey>,
    /// Keys of its rotation alone, frames strictly increasing; `keys` then hold none. Empty: `keys` hold the rotation.
    pub(crate) rotate_keys: Vec<ChannelKey<Rotation>>,
    /// Keys of its scale alone, as `rotate_keys`.
    pub(crate) scale_keys: Vec<ChannelKey<f64>>,
}

/// The region that a pin carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PinRegion {
    /// Distance of its rim from the pin: frame heights (world layers: metres), with [`OffsetUnit::Box`] diagonals of
    /// the lattice's box.
    pub radius: f64,
    /// How rigidly it moves, 0..=1.
    pub rigidity: f64,
    /// Stiffness multiplier at the pin; 1 at the rim.
    pub stiffness: f64,
}

/// An entry of `[[layer.stiffness]]` without a stroke; overlapping entries are multiplied.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StiffnessRule {
    /// The part that it applies to.
    pub part: StiffPart,
    /// The stiffness, > 0; 1 is that of everything else.
    pub value: f64,
}

/// A part of a layer with its own stiffness.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum StiffPart {
    /// Patterns of node names, including their subtrees.
    Nodes(Vec<String>),
    /// Everything with a material.
    Material(String),
    /// Where a channel of the vertex colours is 1; values below 1 apply partially.
    VertexColor(ColorChannel),
}

/// A brush stroke of stiffness over the surface of a model at rest: an entry of `[[layer.stiffness]]` with `stroke`. Later
/// strokes of a layer paint over earlier ones.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BrushStroke {
    /// Patterns of the names of the nodes that it paints, including their subtrees; empty: all of the layer.
    pub nodes: Vec<String>,
    /// Points of its line in the scene at rest (without a clip): metres, in pictures frame heights.
    pub points: Vec<[f64; 3]>,
    /// Distance from the line, in the same unit, at which it ends; up to half of it the stroke applies fully.
    pub radius: f64,
    /// The stiffness, > 0; 1 is that of everything else, and erases.
    pub value: f64,
}

/// The anchor of a pin.
#[derive(Clone, Debug, PartialEq)]
pub enum Anchor {
    /// A point on a triangle.
    Surface {
        /// Node name.
        node: String,
        /// Index of the primitive in the node's mesh.
        primitive: usize,
        /// Index of the triangle.
        triangle: usize,
        /// Barycentric weights of its corners; they sum to 1.
        barycentric: [f64; 3],
        /// The point's position in its node at rest in metres, as stored when the pin was made.
        rest: Option<[f64; 3]>,
    },
    /// A point of the screen.
    Screen {
        /// Its position.
        at: ScreenPoint,
        /// The frame in which it is cast once onto the front-most unwarped surface, which it then follows.
        frame: Option<i32>,
    },
}

/// Unit of a pin's offsets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum OffsetUnit {
    /// Frame heights; metres where an offset has three numbers.
    #[default]
    Frame,
    /// Sizes of the lattice box.
    Box,
}

/// A key of a pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinKey {
    /// Its frame.
    pub frame: f64,
    /// Its goal.
    pub goal: Goal,
    /// Rotation in degrees; `None`: unconstrained, or in `rotate_keys`.
    pub rotate_degrees: Option<Rotation>,
    /// Scale; `None`: unconstrained, or in `scale_keys`.
    pub scale: Option<f64>,
    /// Easing of the segment that starts at this key.
    pub(crate) ease: Ease,
}

/// A key of one channel of a pin: of its rotation, in degrees, or of its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ChannelKey<V> {
    /// Its frame.
    pub frame: f64,
    /// The value.
    pub value: V,
    /// Easing of the segment that starts at this key.
    pub ease: Ease,
}

/// The goal of a pin at a key. All keys of a pin are of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// An offset from the projected anchor; in world layers at the anchor's depth.
    Offset(ScreenVector),
    /// An absolute position; in world layers at the anchor's depth.
    Target(ScreenPoint),
    /// World layers: an offset from the anchor in scene space, in metres (or box sizes along the axes of the box).
    SceneOffset([f64; 3]),
    /// World layers: a point in scene space, in metres.
    SceneTarget([f64; 3]),
}

/// A constrained rotation. All rotations of a pin are of one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotation {
    /// About the camera's view axis, counter-clockwise in the view.
    InView(f64),
    /// World layers: about x, then y, then z of the scene (or of the box, if offsets are in box sizes).
    Axes([f64; 3]),
}

/// The shape of a segment between keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Ease {
    /// Keeps the value until the next key.
    Hold,
    /// Linear interpolation.
    #[default]
    Linear,
    /// Slow in, slow out: 3t² − 2t³.
    Smooth,
    /// A CSS-like cubic curve through (0,0), (x1,y1), (x2,y2), (1,1); x1, x2 in 0..=1.
    Bezier([f64; 4]),
}

/// Keys of one lattice handle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HandleTrack {
    /// Column, row and layer; in screen space the layer is 0.
    pub index: [usize; 3],
    /// Keys with offsets in box sizes; frames strictly increasing.
    pub keys: Vec<HandleKey>,
}

/// A key of a handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HandleKey {
    /// Its frame.
    pub frame: f64,
    /// Offset from the rest position in box sizes along its axes; in screen space the third component is 0.
    pub offset: [f64; 3],
    /// Easing of the segment that starts at this key.
    pub ease: Ease,
}

/// The output files of a shot.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// `frame.####.exr` or `frame.%04d.exr`, resolved against the shot's folder.
    pub path: PathBuf,
    /// Channel groups.
    pub channels: Vec<ChannelGroup>,
    /// EXR compression.
    pub compression: Compression,
}

/// The keys evaluated at one time: one entry per pin and handle of the layer, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PinTargets {
    /// One per pin.
    pub pins: Vec<PinTarget>,
    /// One per handle: offset in box sizes along its axes (in screen space the third component is 0), strength applied.
    pub handles: Vec<[f64; 3]>,
}

/// The target of one pin at one time, with strength and step applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinTarget {
    /// Offset (in the pin's unit) or absolute target. Strength scales offsets; for targets the pipeline applies it:
    /// anchor + strength·(target − anchor).
    pub goal: Goal,
    /// Rotation in radians; `None`: unconstrained.
    pub rotation: Option<Rotation>,
    /// Natural logarithm of the scale; `None`: unconstrained.
    pub log_scale: Option<f64>,
}
