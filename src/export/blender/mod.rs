//! A Python script that rebuilds the warp in Blender: lattice objects where Blender's lattice is ours, else shape keys.
//!
//! In: lattices placed in the scene, or the reason why a layer is baked into the .glb beside the script. Out: the
//! script. docs/EXPORT.md derives why both lattices agree.

use crate::scene::{Lens, Packed, Scene};
use crate::space::FrameSize;
use glam::DMat4;
use serde_json::{Value, json};

/// The script around the data.
const SCRIPT: &str = include_str!("script.py");

/// Key under which objects carry the number of their node.
const NODE_KEY: &str = "pinwarp_node";

/// What the script builds.
#[derive(Clone, Debug)]
pub struct BlenderScene {
    /// Name of the .glb file beside the script.
    pub scene_file: String,
    /// Frames a second.
    pub rate: f64,
    /// First and last frame of the shot.
    pub frames: [i32; 2],
    /// How many frames the file is later than the shot.
    pub later: i32,
    /// The frame in pixels.
    pub size: FrameSize,
    /// Name of the camera's node, and its lens.
    pub camera: (CameraNode, Lens),
    /// The layers that are warped.
    pub layers: Vec<BlenderLayer>,
}

/// Which node is the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraNode {
    /// Index into [`Scene::nodes`].
    OfScene(usize),
    /// The one that the export adds.
    Added,
}

/// A layer and the way it travels.
#[derive(Clone, Debug)]
pub struct BlenderLayer {
    /// Its name.
    pub name: String,
    /// How.
    pub way: BlenderWay,
}

/// How a layer travels.
#[derive(Clone, Debug)]
pub enum BlenderWay {
    /// As a lattice object.
    Lattice(LatticeObject),
    /// As shape keys of its vertices; why.
    Baked(String),
}

/// A lattice that stands in the scene.
#[derive(Clone, Debug)]
pub struct LatticeObject {
    /// Nodes whose meshes it deforms.
    pub nodes: Vec<usize>,
    /// Points an axis.
    pub dims: [usize; 3],
    /// How its points are blended.
    pub blend: LatticeBlend,
    /// One a frame, increasing.
    pub frames: Vec<LatticePose>,
}

/// Blender's ways of blending that are ours, too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatticeBlend {
    /// Uniform cubic B-spline.
    Bspline,
    /// Trilinear cells.
    Linear,
}

/// A lattice in one frame.
#[derive(Clone, Debug)]
pub struct LatticePose {
    /// Frame of the shot.
    pub frame: i32,
    /// scene_from_lattice, where the points rest evenly between −1/2 and 1/2 on each axis that has more than one.
    pub scene_from_lattice: DMat4,
    /// #points, x fastest: how far each is from its rest, in lattice space.
    pub moved: Vec<[f64; 3]>,
}

/// Whole frames a second that a file counts for a rate.
#[must_use]
pub fn nominal_rate(rate: f64) -> f64 {
    rate.round().max(1.0)
}

/// Writes into every node of a file its number, by which the script finds the objects, whatever they are called.
pub fn number_nodes(packed: &mut Packed, scene: &Scene) {
    for (number, &place) in scene.file_from_scene.iter().enumerate() {
        let node = &mut packed.json["nodes"][place];
        if !node["extras"].is_object() {
            node["extras"] = json!({});
        }
        node["extras"][NODE_KEY] = json!(number);
    }
}

/// The text of the script.
#[must_use]
pub fn script(scene: &BlenderScene) -> String {
    let told = scene.layers.iter().map(|layer| match &layer.way {
        BlenderWay::Lattice(lattice) => {
            let [x, y, z] = lattice.dims;
            format!(
                "  {}: a lattice object, {x} x {y} x {z} points; vertices as pinwarp's, but for single precision\n",
                layer.name
            )
        }
        BlenderWay::Baked(why) => {
            format!("  {}: NO lattice but baked shape keys of its vertices, because {why}\n", layer.name)
        }
    });
    // Names of layers are free text: nothing in them may end the string that they stand in.
    let told: String = told.collect::<String>().replace('\\', "/").replace('"', "'");
    let data = data(scene).to_string().replace('\'', "\\u0027");
    SCRIPT.replace("@SCENE@", &scene.scene_file).replace("@LAYERS@", &told).replace("@DATA@", &data)
}

fn data(scene: &BlenderScene) -> Value {
    let [yfov, ymag] = match scene.camera.1 {
        Lens::Perspective { yfov } => [yfov, 1.0],
        Lens::Orthographic { ymag } => [1.0, ymag],
    };
    json!({
        "scene": scene.scene_file,
        "rate": scene.rate,
        "nominal": nominal_rate(scene.rate) as u32,
        "first": scene.frames[0] + scene.later,
        "last": scene.frames[1] + scene.later,
        "size": [scene.size.width, scene.size.height],
        "pixel_aspect": scene.size.pixel_aspect,
        "camera": match scene.camera.0 {
            CameraNode::OfScene(node) => json!(node),
            CameraNode::Added => json!("added"),
        },
        "yfov": yfov,
        "ymag": ymag,
        "layers": scene.layers.iter().map(|layer| layer_data(layer, scene.later)).collect::<Vec<_>>(),
    })
}

fn layer_data(layer: &BlenderLayer, later: i32) -> Value {
    let lattice = match &layer.way {
        BlenderWay::Baked(why) => return json!({ "name": layer.name, "baked": why }),
        BlenderWay::Lattice(lattice) => lattice,
    };
    let frames = lattice.frames.iter().map(|pose| {
        let rows = pose.scene_from_lattice.transpose().to_cols_array();
        let moved = pose.moved.as_flattened();
        json!({ "frame": pose.frame + later, "shot_frame": pose.frame, "scene_from_lattice": rows, "moved": moved })
    });
    json!({
        "name": layer.name,
        "baked": null,
        "nodes": lattice.nodes,
        "dims": lattice.dims,
        "interpolation": match lattice.blend {
            LatticeBlend::Bspline => "KEY_BSPLINE",
            LatticeBlend::Linear => "KEY_LINEAR",
        },
        "frames": frames.collect::<Vec<_>>(),
    })
}
