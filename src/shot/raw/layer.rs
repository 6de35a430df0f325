//! `[[layer]]` as written: its lattice, solver, pins and handles.
//!
//! In: checked TOML. Out: raw values; see [`super`].

use super::RawCut;
use crate::lattice::Basis;
use crate::shot::model::{Ease, OffsetUnit};
use crate::shot::selection::ColorChannel;
use crate::solve::{EdgeWeights, Energy, Guard, Regularizer, Topology};
use schemars::JsonSchema;
use serde::Deserialize;

/// Scene nodes that one lattice deforms.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawLayer {
    /// Name, unique in the shot; default: layer1, layer2...
    #[schemars(length(min = 1), example = &"body")]
    pub(in crate::shot) name: Option<String>,
    /// Patterns of node names with * and ?; each takes its subtree, with a ! before it takes it out. "rest": all that no other
    /// layer takes. A later layer takes what it names from those before. Default: all nodes.
    #[schemars(example = serde_json::json!(["Teapot*"]))]
    pub(in crate::shot) nodes: Option<super::RawNodes>,
    /// The part of the meshes of those nodes; default: all of them.
    #[serde(default)]
    pub(in crate::shot) select: super::RawSelect,
    /// The part of a plate that the layer moves: "alpha", a channel, ids, names of a Cryptomatte, or "none" for the whole
    /// picture; default: the layer's nodes where the shot has a scene, else the whole picture.
    #[schemars(example = &"alpha")]
    pub(in crate::shot) matte: Option<super::RawMatte>,
    /// The grid of handles.
    #[serde(default)]
    pub(in crate::shot) lattice: RawLattice,
    /// The solver.
    #[serde(default)]
    pub(in crate::shot) solve: RawSolve,
    /// Instead of pins and handles: lattices solved for another shot, laid over this layer.
    pub(in crate::shot) transfer: Option<RawTransfer>,
    /// As the shot's `step`, which it replaces.
    #[schemars(range(min = 1, max = 1000))]
    pub(in crate::shot) step: Option<u32>,
    /// As the shot's `strength`, by which it is multiplied.
    #[serde(default = "super::default_one")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub(in crate::shot) strength: f64,
    /// Parts that keep their shape more, or less, than the rest.
    #[serde(default)]
    pub(in crate::shot) stiffness: Vec<RawStiffness>,
    /// Points and where they go.
    #[serde(default)]
    pub(in crate::shot) pin: Vec<RawPin>,
    /// Handles moved by hand.
    #[serde(default)]
    pub(in crate::shot) handle: Vec<RawHandle>,
}

/// Parts that keep their shape more, or less, than the rest: one of nodes, material and vertex_color.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawStiffness {
    /// Patterns of node names with * and ?; each means its subtree.
    #[schemars(length(min = 1), inner(length(min = 1)), example = serde_json::json!(["Head*"]))]
    pub(in crate::shot) nodes: Option<Vec<String>>,
    /// Name of a material.
    #[schemars(length(min = 1), example = &"Metal")]
    pub(in crate::shot) material: Option<String>,
    /// Channel of the vertex colours: `value` where it is 1, as the rest where it is 0.
    #[schemars(example = &"r")]
    pub(in crate::shot) vertex_color: Option<ColorChannel>,
    /// How stiff, 1 is as the rest; where entries meet, their values multiply.
    #[schemars(range(min = 0.001, max = 1000.0), example = 4.0)]
    pub(in crate::shot) value: f64,
}

/// Lattices solved for another shot, laid over this layer.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawTransfer {
    /// The file, as `pinwarp export --to lattice-json` writes it, relative to the shot file.
    #[schemars(length(min = 1), example = &"teapot.lattice.json")]
    pub(in crate::shot) lattice: String,
    /// Layer of that file; default: its only one.
    #[schemars(length(min = 1), example = &"body")]
    pub(in crate::shot) layer: Option<String>,
    /// Where the lattices go.
    #[serde(default)]
    pub(in crate::shot) fit: RawFit,
    /// Frame of this shot that shows the first frame of the file; default: equal frame numbers.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) start: Option<i32>,
}

/// Where transferred lattices go.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(in crate::shot) enum RawFit {
    /// Their box becomes the box of this layer.
    #[default]
    Box,
    /// The same place on the screen.
    AsIs,
    /// Pairs of screen points, there and here, frame heights: they shift, turn and scale the lattices.
    Landmarks(#[schemars(length(min = 1), example = serde_json::json!([[[0.5, 0.5], [0.9, 0.4]]]))] Vec<[[f64; 2]; 2]>),
}

/// How many handles a grid has.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawDims {
    /// As many as the layer needs.
    Auto(RawAuto),
    /// On each axis.
    Counts(#[schemars(length(min = 2, max = 3), inner(range(min = 2, max = 64)))] Vec<usize>),
}

/// The word `auto`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawAuto {
    /// The program chooses.
    Auto,
}

/// By hand, so that the word stands beside the list in one list of choices.
impl JsonSchema for RawAuto {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RawAuto".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": "string", "enum": ["auto"] })
    }
}

/// The grid of handles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawLattice {
    /// Where the grid lies: on the screen, or in the scene, where it moves the meshes themselves.
    pub(in crate::shot) space: RawSpace,
    /// Handles across and up, in the scene along x, y and z; default: [10, 10], over whole plates [16, 16], in the scene [5, 5, 5].
    /// "auto": as many as the thinnest parts and the nearest pins of the layer need.
    #[schemars(example = serde_json::json!([10, 10]), example = serde_json::json!("auto"))]
    pub(in crate::shot) dims: Option<RawDims>,
    /// How handles are blended.
    pub(in crate::shot) basis: Basis,
    /// Which parts of a drawing or model share handles.
    pub(in crate::shot) topology: Topology,
    /// What separates parts that touch, for branching lattices: strokes across a picture, points in frame heights, or parts of a scene.
    #[schemars(example = serde_json::json!([[[0.62, 0.40], [0.62, 0.71]]]), example = serde_json::json!([{ "joints": ["LeftArm*"] }]))]
    pub(in crate::shot) cuts: Vec<RawCut>,
    /// What is joined by hand, for branching lattices of scenes: pairs of patterns of node names.
    #[schemars(inner(inner(length(min = 1))), example = serde_json::json!([["Sword", "Hand*"]]))]
    pub(in crate::shot) joins: Vec<[String; 2]>,
    /// How far islands (eyes, buttons, hair cards) may lie from what carries them, diagonals of the layer at rest; default: 0.1.
    #[schemars(range(min = 0.0, max = 10.0), example = 0.1)]
    pub(in crate::shot) island_radius: Option<f64>,
    /// Where the box of the grid comes from.
    #[serde(rename = "box")]
    pub(in crate::shot) bounds: RawBox,
}

/// Where the grid lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawSpace {
    /// On the screen: two axes.
    #[default]
    Screen,
    /// In the scene: three axes.
    World,
}

/// Where the box of the grid comes from.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawBox {
    /// It follows the layer.
    #[default]
    Follow,
    /// The whole frame (on the screen only).
    Frame,
    /// Always this: x and y of the lower left, x and y of the upper right corner, frame heights; in the scene x, y and
    /// z of the lower and of the upper corner, metres.
    Fixed(#[schemars(length(min = 4, max = 6), example = serde_json::json!([0.0, 0.0, 1.778, 1.0]))] Vec<f64>),
}

/// The solver: a preset, or its parts.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawSolve {
    /// All settings at once, instead of the other keys.
    #[schemars(example = &"paper")]
    pub(in crate::shot) preset: Option<RawPreset>,
    /// How distortion is measured; default: area.
    pub(in crate::shot) energy: Option<Energy>,
    /// What holds handles that nothing else holds; default: bend.
    pub(in crate::shot) regularizer: Option<Regularizer>,
    /// Weights of the edges, with energy = "edge" or "vertex"; default: uniform.
    pub(in crate::shot) weights: Option<EdgeWeights>,
    /// What happens where the lattice would fold: "report" tells, "limit" keeps what holds some of the layer from
    /// folding, and lets pins give way where that needs too much force; default: report.
    #[schemars(example = &"limit")]
    pub(in crate::shot) guard: Option<Guard>,
    /// Stretch up to which pins nearer than a span of the lattice hold exactly; where they ask for more they give way smoothly, and
    /// the report says by how much; default: 4.
    #[schemars(range(min = 1.1, max = 1000.0), example = 4.0)]
    pub(in crate::shot) max_stretch: Option<f64>,
    /// How smooth the warp is: more spreads the pull of a pin over the whole layer. Its cube multiplies the weight of the
    /// regulariser; default: 1.
    #[schemars(range(min = 0.1, max = 10.0), example = 2.0)]
    pub(in crate::shot) smoothness: Option<f64>,
    /// Temporal weight, frames: the frames of a layer are solved together, so that its shape never snaps from one frame to the
    /// next; more evens out slow sways, too. 0: each frame alone. Default: 0.3, with preset = "paper" 0.
    #[schemars(range(min = 0.0, max = 100.0), example = 0.3)]
    pub(in crate::shot) temporal: Option<f64>,
}

/// Settings by name.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in crate::shot) enum RawPreset {
    /// The default: area and bend.
    Default,
    /// Exactly the paper's: edge and rest.
    Paper,
}

/// A point and where it goes.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPin {
    /// Name, unique in its layer; default: pin1, pin2...
    #[schemars(length(min = 1), example = &"spout")]
    pub(in crate::shot) name: Option<String>,
    /// What it is attached to.
    #[schemars(example = serde_json::json!({ "screen": [0.9, 0.5], "frame": 1 }))]
    pub(in crate::shot) anchor: RawAnchor,
    /// Unit of the offsets.
    #[serde(default)]
    pub(in crate::shot) unit: OffsetUnit,
    /// The neighbourhood it takes along; default: its point alone.
    #[schemars(example = serde_json::json!({ "radius": 0.1, "rigidity": 1.0, "stiffness": 5.0 }))]
    pub(in crate::shot) region: Option<RawRegion>,
    /// How firmly it holds its point: 1 exactly; less gives way to the shape and to other pins, in powers of ten.
    #[serde(default = "super::default_one")]
    #[schemars(range(min = 0.0, max = 1.0), example = 0.4)]
    pub(in crate::shot) weight: f64,
    /// It does not act.
    #[serde(default)]
    #[schemars(example = true)]
    pub(in crate::shot) mute: bool,
    /// What lies in front where parts of a picture overlap: of the parts around two pins that of the greater order; default: 0.
    #[schemars(example = 1)]
    pub(in crate::shot) order: Option<RawOrder>,
    /// Where it goes, frames increasing; none: it holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(in crate::shot) keys: Vec<RawPinKey>,
}

/// An order, or one from each key on.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawOrder {
    /// In all frames.
    Always(#[schemars(range(min = -1000, max = 1000))] i32),
    /// Held from each key to the next, frames increasing; before the first key as at it.
    Keys(#[schemars(length(min = 1))] Vec<RawOrderKey>),
}

/// A key of an order.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawOrderKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// The order from there on.
    #[schemars(range(min = -1000, max = 1000), example = 1)]
    pub(in crate::shot) value: i32,
}

/// The neighbourhood that a pin takes along, fading out to its rim.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawRegion {
    /// Distance of the rim from the pin, frame heights (world layers: metres); with unit = "box" diagonals of the box.
    #[schemars(range(min = 0.00001, max = 100_000.0), example = 0.1)]
    pub(in crate::shot) radius: f64,
    /// How firmly it moves with the pin as one piece: 0 not at all, 1 rigidly.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0), example = 1.0)]
    pub(in crate::shot) rigidity: f64,
    /// Multiplies the stiffness of the model at the pin; 1 leaves it as it is.
    #[serde(default = "super::default_one")]
    #[schemars(range(min = 0.001, max = 1000.0), example = 5.0)]
    pub(in crate::shot) stiffness: f64,
}

/// A point of a surface (node, triangle, barycentric) or of the screen (screen).
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
    /// Surface: weights of the triangle's corners; they sum to 1.
    #[schemars(example = serde_json::json!([0.2, 0.5, 0.3]))]
    pub(in crate::shot) barycentric: Option<[f64; 3]>,
    /// Surface: the point's place in its node at rest, metres; tells when the scene has changed.
    #[schemars(example = serde_json::json!([0.0, 1.0, 0.0]))]
    pub(in crate::shot) rest: Option<[f64; 3]>,
    /// Screen: x and y, frame heights, y up.
    #[schemars(example = serde_json::json!([0.91, 0.52]))]
    pub(in crate::shot) screen: Option<[f64; 2]>,
    /// Screen: cast onto the surface seen there in this frame, which the pin then follows.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: Option<i32>,
}

/// A key of a pin.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawPinKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Added to the point's place, in `unit`; three numbers in world layers: along the scene's axes; default: [0, 0].
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.06, 0.03]))]
    pub(in crate::shot) offset: Option<Vec<f64>>,
    /// Instead of `offset`: a place on the screen, frame heights, y up; three numbers: of the scene, metres.
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.9, 0.5]))]
    pub(in crate::shot) target: Option<Vec<f64>>,
    /// Rotation held, degrees counter-clockwise; three numbers in world layers: about x, then y, then z; default: free,
    /// or 0 where another key has it.
    #[schemars(example = 20)]
    pub(in crate::shot) rotate: Option<RawRotation>,
    /// Scale held; default: free, or 1 where another key has it.
    #[schemars(range(min = 0.001, max = 1000.0), example = 1.2)]
    pub(in crate::shot) scale: Option<f64>,
    /// Shape of the segment that leaves this key; default: linear.
    #[serde(default)]
    #[schemars(example = &"smooth")]
    pub(in crate::shot) ease: Ease,
}

/// A rotation as seen, or about three axes.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::shot) enum RawRotation {
    /// As the camera sees it.
    InView(#[schemars(range(min = -36_000.0, max = 36_000.0))] f64),
    /// About x, then y, then z.
    Axes(#[schemars(inner(range(min = -36_000.0, max = 36_000.0)))] [f64; 3]),
}

/// A handle moved by hand.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawHandle {
    /// Column and row, from 0 at the lower left; in world layers three: along x, y and z.
    #[schemars(length(min = 2, max = 3), inner(range(min = 0, max = 63)), example = serde_json::json!([9, 4]))]
    pub(in crate::shot) index: Vec<usize>,
    /// Where it goes, frames increasing; none: it holds its place.
    #[serde(default)]
    #[schemars(example = serde_json::json!([{ "frame": 1, "offset": [0.0, 0.0] }]))]
    pub(in crate::shot) keys: Vec<RawHandleKey>,
}

/// A key of a handle.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::shot) struct RawHandleKey {
    /// When.
    #[schemars(range(min = -1_000_000, max = 1_000_000), example = 1)]
    pub(in crate::shot) frame: f64,
    /// Added to the handle's place at rest, sizes of the lattice's box.
    #[schemars(length(min = 2, max = 3), example = serde_json::json!([0.0, 0.1]))]
    pub(in crate::shot) offset: Vec<f64>,
    /// Shape of the segment that leaves this key; default: linear.
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
            topology: Topology::default(),
            cuts: Vec::new(),
            joins: Vec::new(),
            island_radius: None,
            bounds: RawBox::Follow,
        }
    }
}
