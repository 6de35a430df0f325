//! `[[layer]]` as written in the shot file: its lattice, solver, pins and handles.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use super::{RawCut, RawJoin, RawOrder};
use crate::lattice::Basis;
use crate::shot::model::{Ease, OffsetUnit};
use crate::shot::selection::ColorChannel;
use crate::solve::{EdgeWeights, Energy, Guard, Regularizer, Topology};
use schemars::JsonSchema;
use serde::Deserialize;

/// A layer: the parts of a scene, picture or plate that one lattice deforms.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawLayer {
    /// Name, unique in the shot; default: layer1, layer2...
    #[schemars(length(min = 1), example = &"body")]
    pub(in crate::shot) name: Option<String>,
    /// Patterns of node names with * and ?. Each pattern includes the subtrees of its nodes; a pattern that starts with !
    /// excludes them. "rest": everything that no other layer claims. If several layers name the same node, the last of them gets
    /// it. Default: all nodes.
    #[schemars(example = serde_json::json!(["Teapot*"]))]
    pub(in crate::shot) nodes: Option<super::RawNodes>,
    /// Limits the layer to parts of the meshes of those nodes; default: whole meshes.
    #[serde(default)]
    pub(in crate::shot) select: super::RawSelect,
    /// Part of a plate that the layer moves: "alpha", a channel, ids, names of a Cryptomatte, or "none" for the whole picture;
    /// default: the layer's nodes if it moves a part of a scene, else the whole picture.
    #[schemars(example = &"alpha")]
    pub(in crate::shot) matte: Option<super::RawMatte>,
    /// The lattice: the grid of handles.
    #[serde(default)]
    pub(in crate::shot) lattice: RawLattice,
    /// The solver.
    #[serde(default)]
    pub(in crate::shot) solve: RawSolve,
    /// Uses lattices that were solved for another shot, instead of pins and handles.
    pub(in crate::shot) transfer: Option<RawTransfer>,
    /// Replaces the shot's `step` for this layer.
    #[schemars(range(min = 1, max = 1000))]
    pub(in crate::shot) step: Option<u32>,
    /// Multiplies the shot's `strength` for this layer.
    #[serde(default = "super::default_one")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(in crate::shot) strength: f64,
    /// The layer is at rest: its pins, handles and transferred lattices are ignored. It keeps the parts that it claims.
    #[serde(default)]
    pub(in crate::shot) mute: bool,
    /// Parts that keep their shape more, or less, than the rest of the layer.
    #[serde(default)]
    pub(in crate::shot) stiffness: Vec<RawStiffness>,
    /// Plane at which pins with `mirror` are reflected. Default: the layer's own plane of symmetry at rest.
    #[schemars(example = serde_json::json!({ "axis": "x", "at": 0.0 }))]
    pub(in crate::shot) symmetry: Option<RawSymmetry>,
    /// Pins: points of the layer and their animated targets.
    #[serde(default)]
    pub(in crate::shot) pin: Vec<RawPin>,
    /// Handles of the lattice that are moved by hand.
    #[serde(default)]
    pub(in crate::shot) handle: Vec<RawHandle>,
}

/// A part that keeps its shape more, or less, than the rest of the layer. Set one of nodes, material, vertex_color and stroke.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawStiffness {
    /// Patterns of node names with * and ?; each includes its subtree.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Head*"]))]
    pub(in crate::shot) nodes: Option<Vec<String>>,
    /// Name of a material.
    #[schemars(length(min = 1), example = &"Metal")]
    pub(in crate::shot) material: Option<String>,
    /// Channel of the vertex colours: `value` applies fully where it is 1, not at all where it is 0.
    #[schemars(example = &"r")]
    pub(in crate::shot) vertex_color: Option<ColorChannel>,
    /// Brush stroke over the surface, as the editor paints it. Later strokes of a layer paint over earlier ones: `value` 1 erases.
    #[schemars(example = serde_json::json!({ "radius": 0.1, "points": [[0.0, 1.2, 0.1], [0.1, 1.25, 0.1]] }))]
    pub(in crate::shot) stroke: Option<RawStroke>,
    /// Stiffness relative to the rest, which is 1. Where entries overlap, their values multiply.
    #[schemars(range(min = 0.001, max = 1000.0), example = 4.0)]
    pub(in crate::shot) value: f64,
}

/// A brush stroke over the surface of the model at rest.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawStroke {
    /// Patterns of the names of the nodes that it paints, with * and ?; default: all nodes of the layer.
    #[serde(default)]
    #[schemars(inner(length(min = 1)), example = serde_json::json!(["Body"]))]
    pub(in crate::shot) nodes: Vec<String>,
    /// Distance from the line through the points at which the stroke ends: metres, in pictures frame heights. Up to half of it
    /// `value` applies fully.
    #[schemars(range(min = 0.00001, max = 100_000.0), example = 0.1)]
    pub(in crate::shot) radius: f64,
    /// Points of its line: places in the scene at rest (without a clip), metres; in pictures frame heights, the third 0.
    #[schemars(length(min = 1), example = serde_json::json!([[0.0, 1.2, 0.1], [0.1, 1.25, 0.1]]))]
    pub(in crate::shot) points: Vec<[f64; 3]>,
}

/// Lattices that were solved for another shot and are applied to this layer.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawTransfer {
    /// Lattice file, as written by `pinwarp export --to lattice-json`, relative to the shot file.
    #[schemars(length(min = 1), example = &"teapot.lattice.json")]
    pub(in crate::shot) lattice: String,
    /// Layer in that file; default: the only one.
    #[schemars(length(min = 1), example = &"body")]
    pub(in crate::shot) layer: Option<String>,
    /// How the lattices are placed on this layer.
    #[serde(default)]
    pub(in crate::shot) fit: RawFit,
    /// Frame of this shot that shows the first frame of the lattice file; default: frame numbers match.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) start: Option<i32>,
}

/// The placement of transferred lattices.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(in crate::shot) enum RawFit {
    /// Maps the box of the lattice to the box of this layer.
    #[default]
    Box,
    /// Keeps the position on the screen.
    AsIs,
    /// Pairs of screen points [in the other shot, in this one] in frame heights: one pair shifts the lattices, two or more shift,
    /// rotate and scale them.
    Landmarks(#[schemars(length(min = 1), example = serde_json::json!([[[0.5, 0.5], [0.9, 0.4]]]))] Vec<[[f64; 2]; 2]>),
}

/// Number of handles of a lattice.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawDims {
    /// Chosen automatically for the layer.
    Auto(RawAuto),
    /// Number on each axis.
    Counts(#[schemars(length(min = 2, max = 3), inner(range(min = 2, max = 64)))] Vec<usize>),
}

/// The value `auto`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawAuto {
    /// The program chooses.
    Auto,
}

/// Written by hand, so that the value appears in the same list of alternatives as the array.
impl JsonSchema for RawAuto {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawAuto".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["auto"] })
    }
}

/// The lattice: the grid of handles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawLattice {
    /// Space of the lattice: the screen, or the scene, where it deforms the meshes themselves.
    pub(in crate::shot) space: RawSpace,
    /// Number of handles across and up; in the world along x, y and z. Default: [10, 10], for whole plates [16, 16], in the world
    /// [5, 5, 5]. "auto" chooses enough handles for the thinnest parts and the nearest pins of the layer.
    #[schemars(example = serde_json::json!([10, 10]), example = serde_json::json!("auto"))]
    pub(in crate::shot) dims: Option<RawDims>,
    /// Basis functions that blend the handles.
    pub(in crate::shot) basis: Basis,
    /// Which parts of a drawing or model share handles. Default: "branching" on the screen over a picture or a scene, where the
    /// layer's solve allows it; "plain" over lines and more than 100,000 triangles, and in the world.
    #[schemars(example = &"plain")]
    pub(in crate::shot) topology: Option<Topology>,
    /// For branching lattices: what separates parts that touch. Strokes across a picture (points in frame heights), or parts of a
    /// scene or picture.
    #[schemars(example = serde_json::json!([[[0.62, 0.40], [0.62, 0.71]]]), example = serde_json::json!([{ "joints": ["LeftArm*"] }]))]
    pub(in crate::shot) cuts: Vec<RawCut>,
    /// For branching lattices of scenes: pairs of patterns of node names; joins the two parts where they are nearest at rest,
    /// or at a place.
    #[schemars(example = serde_json::json!([["Sword", "Hand*"]]), example = serde_json::json!([{ "nodes": ["Arm", "Body"], "at": [0.3, 1.4, 0.0] }]))]
    pub(in crate::shot) joins: Vec<RawJoin>,
    /// For branching lattices: the greatest distance between an island (an eye, a button, a hair card) and the part that carries
    /// it, in diagonals of the layer at rest; default: 0.1.
    #[schemars(range(min = 0.0, max = 10.0), example = 0.1)]
    pub(in crate::shot) island_radius: Option<f64>,
    /// What the box turns with; default: nothing, on the screen it is upright.
    #[schemars(example = serde_json::json!({ "node": "Head" }), example = serde_json::json!({ "angle": 30.0 }))]
    pub(in crate::shot) frame: Option<RawBoxFrame>,
    /// The box that the lattice covers at rest.
    #[serde(rename = "box")]
    pub(in crate::shot) bounds: RawBox,
}

/// The coordinate frame of a lattice's box. Set node, angle or both.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawBoxFrame {
    /// Name of the node, or joint, that the box turns with.
    #[schemars(length(min = 1), example = &"Head")]
    pub(in crate::shot) node: Option<String>,
    /// Axis of the node that the box's vertical sides follow on the screen; default: y.
    pub(in crate::shot) axis: Option<RawAxis>,
    /// Angle in degrees by which the box is rotated on the screen, counter-clockwise; with a node in addition to its angle.
    #[schemars(range(min = -360.0, max = 360.0), example = 30.0)]
    pub(in crate::shot) angle: Option<f64>,
}

/// The space of a lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawSpace {
    /// The screen; the lattice has two axes.
    #[default]
    Screen,
    /// The scene; the lattice has three axes.
    World,
}

/// The box that a lattice covers at rest.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawBox {
    /// The bounds of the layer, padded and smoothed over frames.
    #[default]
    Follow,
    /// The whole frame (screen layers only).
    Frame,
    /// A fixed box: [left, bottom, right, top] in frame heights; in the world [x0, y0, z0, x1, y1, z1] in metres.
    Fixed(#[schemars(length(min = 4, max = 6), example = serde_json::json!([0.0, 0.0, 1.778, 1.0]))] Vec<f64>),
}

/// The solver: a preset, or individual settings.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSolve {
    /// Preset that sets everything at once; excludes the other keys.
    #[schemars(example = &"paper")]
    pub(in crate::shot) preset: Option<RawPreset>,
    /// How distortion is measured; default: area.
    pub(in crate::shot) energy: Option<Energy>,
    /// What constrains handles that neither pins nor the shape constrain; default: bend.
    pub(in crate::shot) regularizer: Option<Regularizer>,
    /// Weights of the edges, for energy = "edge" or "vertex" only; default: uniform.
    pub(in crate::shot) weights: Option<EdgeWeights>,
    /// Weights of the terms in units of the paper, as problem files have them; pins are then held by their weight.
    #[schemars(example = serde_json::json!({ "ml": 1.0, "mp": 100.0, "gp": 100.0, "gr": 0.01 }))]
    pub(in crate::shot) lambdas: Option<RawLambdas>,
    /// Number of plain iterations, without acceleration and whatever they reach; default: until nothing moves any more.
    #[schemars(range(min = 0, max = 100_000), example = 60)]
    pub(in crate::shot) iterations: Option<u32>,
    /// What happens where the lattice would fold. "report" reports the fold. "limit" prevents folds in cells that contain part of
    /// the layer; pins give way where this would take more force than they have. Default: limit on the screen; report in the scene,
    /// with basis = "bernstein", and with preset = "paper", `lambdas` or `iterations`.
    #[schemars(example = &"limit")]
    pub(in crate::shot) guard: Option<Guard>,
    /// Stretch up to which pins less than one lattice span apart are met exactly. Beyond it their difference yields smoothly, and
    /// the report names the error; default: 4.
    #[schemars(range(min = 1.1, max = 1000.0), example = 4.0)]
    pub(in crate::shot) max_stretch: Option<f64>,
    /// Smoothness of the warp: higher values spread the pull of a pin over the whole layer. The cube of this value scales the
    /// weight of the regulariser; default: 1.
    #[schemars(range(min = 0.1, max = 10.0), example = 2.0)]
    pub(in crate::shot) smoothness: Option<f64>,
    /// Temporal weight, frames. Above 0 the frames of a layer are solved together, so that its shape is continuous in time;
    /// higher values also even out slow sways. 0 solves each frame alone. Default: 0.3; 0 with preset = "paper".
    #[schemars(range(min = 0.0, max = 100.0), example = 0.3)]
    pub(in crate::shot) temporal: Option<f64>,
}

/// Weights of the terms of the energy (lp-FFD, equation 9).
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawLambdas {
    /// Weight of the distortion; default: 1.
    #[schemars(range(min = 0.0, max = 1e12), example = 1.0)]
    pub(in crate::shot) ml: Option<f64>,
    /// Weight of the pins; default: 100.
    #[schemars(range(min = 0.0, max = 1e12), example = 100.0)]
    pub(in crate::shot) mp: Option<f64>,
    /// Weight of moved handles; default: 100.
    #[schemars(range(min = 0.0, max = 1e12), example = 100.0)]
    pub(in crate::shot) gp: Option<f64>,
    /// Weight of the regulariser; default: 0.01, with "bend" and "affine" 0.001.
    #[schemars(range(min = 0.0, max = 1e12), example = 0.01)]
    pub(in crate::shot) gr: Option<f64>,
}

/// Presets of the solver.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawPreset {
    /// The default settings: area and bend.
    Default,
    /// lp-FFD exactly as published: edge and rest.
    Paper,
}

/// A pin: a point of the layer and its animated target.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPin {
    /// Name, unique in its layer; default: pin1, pin2...
    #[schemars(length(min = 1), example = &"spout")]
    pub(in crate::shot) name: Option<String>,
    /// Point of a surface or of the screen to which the pin is attached. Only pins with `mirror` may omit it.
    #[schemars(example = serde_json::json!({ "screen": [0.9, 0.5], "frame": 1 }))]
    pub(in crate::shot) anchor: Option<RawAnchor>,
    /// The pin on the other side of the model whose keys this pin takes, mirrored: its name, or layer and name. Without an
    /// `anchor` the pin is attached to the mirrored point.
    #[schemars(example = &"hand.L", example = serde_json::json!({ "layer": "arm.L", "pin": "hand" }))]
    pub(in crate::shot) mirror: Option<RawMirror>,
    /// Unit of the offsets.
    #[serde(default)]
    pub(in crate::shot) unit: OffsetUnit,
    /// Neighbourhood that moves with the pin; default: its point alone.
    #[schemars(example = serde_json::json!({ "radius": 0.1, "rigidity": 1.0, "stiffness": 5.0 }))]
    pub(in crate::shot) region: Option<RawRegion>,
    /// How firmly the pin holds its point. 1: exactly; lower values give way to the shape and to other pins, in powers of ten.
    /// Default: 1, with `mirror` that of the other pin.
    #[schemars(range(min = 0.0, max = 1.0), example = 0.4)]
    pub(in crate::shot) weight: Option<f64>,
    /// Mutes the pin: it is ignored.
    #[serde(default)]
    #[schemars(example = true)]
    pub(in crate::shot) mute: bool,
    /// Order in depth where parts of a picture overlap: the part around the pin with the greater order lies in front; default: 0.
    #[schemars(example = 1)]
    pub(in crate::shot) order: Option<RawOrder>,
    /// Keyframes of the pin, in order of frames. A pin without keys holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(in crate::shot) keys: Vec<RawPinKey>,
    /// Keyframes of the rotation alone, in order of frames, in place of `rotate` in `keys`; default: none.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "value": 0 }, { "frame": 9, "value": 20 }]))]
    pub(in crate::shot) rotate_keys: Vec<RawRotateKey>,
    /// Keyframes of the scale alone, in order of frames, in place of `scale` in `keys`; default: none.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "value": 1.0 }, { "frame": 9, "value": 1.2 }]))]
    pub(in crate::shot) scale_keys: Vec<RawScaleKey>,
}

/// The pin that a mirrored pin follows.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawMirror {
    /// Name of a pin of the same layer.
    Pin(#[schemars(length(min = 1))] String),
    /// A pin of another layer.
    Of(RawMirroredPin),
}

/// A pin of another layer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawMirroredPin {
    /// Name of the layer.
    #[schemars(length(min = 1), example = &"arm.L")]
    pub(in crate::shot) layer: String,
    /// Name of the pin.
    #[schemars(length(min = 1), example = &"hand")]
    pub(in crate::shot) pin: String,
}

/// The plane at which mirrored pins are reflected.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSymmetry {
    /// Axis of the scene at rest that is perpendicular to the plane; of pictures and plates the screen's.
    #[schemars(example = &"x")]
    pub(in crate::shot) axis: RawAxis,
    /// Position of the plane on that axis: metres, in pictures and plates frame heights.
    #[schemars(example = 0.0)]
    pub(in crate::shot) at: f64,
}

/// An axis.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawAxis {
    /// Left to right.
    X,
    /// Bottom to top.
    Y,
    /// Back to front.
    Z,
}

impl RawAxis {
    /// Returns its index: 0, 1, 2 for x, y, z.
    pub(in crate::shot) const fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// The neighbourhood that moves with a pin. Its effect falls to nothing at the rim.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawRegion {
    /// Distance from the pin to the rim at rest: frame heights, in the world metres; with unit = "box" diagonals of the lattice's
    /// box.
    #[schemars(range(min = 0.00001, max = 100_000.0), example = 0.1)]
    pub(in crate::shot) radius: f64,
    /// How firmly the neighbourhood moves with the pin as one piece: 0 not at all, 1 rigidly.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0), example = 1.0)]
    pub(in crate::shot) rigidity: f64,
    /// Multiplies the stiffness of the model at the pin; 1 does not change it.
    #[serde(default = "super::default_one")]
    #[schemars(range(min = 0.001, max = 1000.0), example = 5.0)]
    pub(in crate::shot) stiffness: f64,
}

/// The anchor of a pin: a point of a surface (node, triangle, barycentric) or of the screen (screen).
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawAnchor {
    /// Surface: name of the node.
    #[schemars(length(min = 1), example = &"Teapot")]
    pub(in crate::shot) node: Option<String>,
    /// Surface: number of the primitive in the node's mesh, from 0; default: 0.
    #[schemars(range(min = 0, max = 4_294_967_295u32))]
    pub(in crate::shot) primitive: Option<usize>,
    /// Surface: number of the triangle, from 0.
    #[schemars(range(min = 0, max = 4_294_967_295u32), example = 312)]
    pub(in crate::shot) triangle: Option<usize>,
    /// Surface: weights of the triangle's corners; they must sum to 1.
    #[schemars(example = serde_json::json!([0.2, 0.5, 0.3]))]
    pub(in crate::shot) barycentric: Option<[f64; 3]>,
    /// Surface: rest position of the point in its node, metres. It reveals when the scene has changed and the triangle has moved.
    #[schemars(example = serde_json::json!([0.0, 1.0, 0.0]))]
    pub(in crate::shot) rest: Option<[f64; 3]>,
    /// Screen: x and y in frame heights, y up.
    #[schemars(example = serde_json::json!([0.91, 0.52]))]
    pub(in crate::shot) screen: Option<[f64; 2]>,
    /// Screen: frame in which the point is cast onto the visible surface, which the pin then follows.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: Option<i32>,
}

/// A keyframe of a pin.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPinKey {
    /// Frame number of the key; it may lie between frames.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Added to the position of the anchor, in `unit`. World layers also accept three numbers, along the scene's axes. Default:
    /// [0, 0].
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.06, 0.03]))]
    pub(in crate::shot) offset: Option<Vec<f64>>,
    /// Position that replaces `offset`: on the screen in frame heights, y up; with three numbers in the scene, metres.
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.9, 0.5]))]
    pub(in crate::shot) target: Option<Vec<f64>>,
    /// Rotation that the pin holds, degrees counter-clockwise; in world layers also three angles, about x, then y, then z.
    /// Default: free, or 0 if only other keys of the pin set it.
    #[schemars(example = 20)]
    pub(in crate::shot) rotate: Option<RawRotation>,
    /// Scale that the pin holds; default: free, or 1 if only other keys of the pin set it.
    #[schemars(range(min = 0.001, max = 1000.0), example = 1.2)]
    pub(in crate::shot) scale: Option<f64>,
    /// Shape of the segment from this key to the next; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// A keyframe of a pin's rotation.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawRotateKey {
    /// Frame number of the key; it may lie between frames.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Rotation that the pin holds, degrees counter-clockwise; in world layers also three angles, about x, then y, then z.
    #[schemars(example = 20)]
    pub(in crate::shot) value: RawRotation,
    /// Shape of the segment from this key to the next; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// A keyframe of a pin's scale.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawScaleKey {
    /// Frame number of the key; it may lie between frames.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Scale that the pin holds.
    #[schemars(range(min = 0.001, max = 1000.0), example = 1.2)]
    pub(in crate::shot) value: f64,
    /// Shape of the segment from this key to the next; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// A rotation about the view axis, or about three axes.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawRotation {
    /// Counter-clockwise as seen by the camera.
    InView(#[schemars(range(min = -36_000.0, max = 36_000.0))] f64),
    /// About x, then y, then z.
    Axes(#[schemars(inner(range(min = -36_000.0, max = 36_000.0)))] [f64; 3]),
}

/// A handle of the lattice that is moved by hand.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawHandle {
    /// Column and row, from [0, 0] at the lower left; in world layers three numbers, along x, y and z.
    #[schemars(length(min = 2, max = 3), inner(range(min = 0, max = 63)), example = serde_json::json!([9, 4]))]
    pub(in crate::shot) index: Vec<usize>,
    /// Keyframes of the handle, in order of frames. A handle without keys holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(in crate::shot) keys: Vec<RawHandleKey>,
}

/// A keyframe of a handle.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawHandleKey {
    /// Frame number of the key; it may lie between frames.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Added to the rest position of the handle, in sizes of the lattice's box.
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.0, 0.1]))]
    pub(in crate::shot) offset: Vec<f64>,
    /// Shape of the segment from this key to the next; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

impl Default for RawLattice {
    fn default() -> Self {
        Self {
            space: RawSpace::Screen,
            dims: None,
            basis: Basis::default(),
            topology: None,
            cuts: Vec::new(),
            joins: Vec::new(),
            island_radius: None,
            frame: None,
            bounds: RawBox::Follow,
        }
    }
}
