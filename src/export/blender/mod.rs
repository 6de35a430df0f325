//! Writes a Python script that rebuilds the warp in Blender: as lattice objects where the lattices are equivalent,
//! otherwise as shape keys.
//!
//! In: lattices placed in the scene, or the reason why a layer is baked into the .glb beside the script. Out: the
//! script. docs/EXPORT.md derives why the lattices agree.

use crate::files::GENERATOR;
use crate::scene::{Lens, Packed, Scene};
use crate::space::FrameSize;
use glam::DMat4;
use serde_json::{Value, json};

/// Template of the script, around the data.
const SCRIPT: &str = include_str!("script.py");

/// Custom property in which objects store the number of their node.
const NODE_KEY: &str = "pinwarp_node";

/// Contents of the script.
#[derive(Clone, Debug)]
pub(crate) struct BlenderScene {
    /// Name of the .glb file beside the script.
    pub scene_file: String,
    /// Frame rate, in frames per second.
    pub rate: f64,
    /// First and last frame of the shot.
    pub frames: [i32; 2],
    /// Number of frames by which frame numbers in the file exceed those of the shot.
    pub frame_offset: i32,
    /// Size of the frame in pixels.
    pub size: FrameSize,
    /// Node and lens of the camera.
    pub camera: (CameraNode, Lens),
    /// The layers that are warped.
    pub layers: Vec<BlenderLayer>,
}

/// The node of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CameraNode {
    /// Index into [`Scene::nodes`].
    OfScene(usize),
    /// The camera node that the export adds.
    Added,
}

/// A layer, and how it is exported.
#[derive(Clone, Debug)]
pub(crate) struct BlenderLayer {
    /// Name of the layer.
    pub name: String,
    /// How it is exported.
    pub method: BlenderMethod,
}

/// How a layer is exported.
#[derive(Clone, Debug)]
pub(crate) enum BlenderMethod {
    /// As a lattice object.
    Lattice(LatticeObject),
    /// As shape keys of its vertices; contains the reason.
    Baked(String),
}

/// A lattice placed in the scene.
#[derive(Clone, Debug)]
pub(crate) struct LatticeObject {
    /// Nodes whose meshes it deforms.
    pub nodes: Vec<usize>,
    /// Number of points per axis.
    pub dims: [usize; 3],
    /// Interpolation of the points.
    pub blend: LatticeBlend,
    /// One pose per frame, increasing.
    pub frames: Vec<LatticePose>,
}

/// The interpolation types of Blender that match our bases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LatticeBlend {
    /// Uniform cubic B-spline.
    Bspline,
    /// Trilinear cells.
    Linear,
}

/// A lattice at one frame.
#[derive(Clone, Debug)]
pub(crate) struct LatticePose {
    /// Frame of the shot.
    pub frame: i32,
    /// scene_from_lattice; points rest evenly between −1/2 and 1/2 on each axis that has more than one.
    pub scene_from_lattice: DMat4,
    /// #points, x fastest: displacement from rest, in lattice space.
    pub moved: Vec<[f64; 3]>,
}

/// Returns the whole number of frames per second that a file uses for a rate.
#[must_use]
pub(crate) fn nominal_rate(rate: f64) -> f64 {
    rate.round().max(1.0)
}

/// Stores its number in every node of a file, so that the script finds the objects whatever their names.
pub(crate) fn number_nodes(packed: &mut Packed, scene: &Scene) {
    for (number, &place) in scene.file_from_scene.iter().enumerate() {
        let node = &mut packed.json["nodes"][place];
        if !node["extras"].is_object() {
            node["extras"] = json!({});
        }
        node["extras"][NODE_KEY] = json!(number);
    }
}

/// Returns the text of the script.
#[must_use]
pub(crate) fn script(scene: &BlenderScene) -> String {
    let told = scene.layers.iter().map(|layer| match &layer.method {
        BlenderMethod::Lattice(lattice) => {
            let [x, y, z] = lattice.dims;
            format!(
                "  {}: a lattice object, {x} x {y} x {z} points; vertices as pinwarp's, but for single precision\n",
                layer.name
            )
        }
        BlenderMethod::Baked(why) => {
            format!("  {}: NO lattice but baked shape keys of its vertices, because {why}\n", layer.name)
        }
    });
    // Layer names are free text: they must not terminate the string literal that contains them.
    let told: String = told.collect::<String>().replace('\\', "/").replace('"', "'");
    let data = data(scene).to_string().replace('\'', "\\u0027");
    SCRIPT
        .replace("@GENERATOR@", GENERATOR)
        .replace("@SCENE@", &scene.scene_file)
        .replace("@LAYERS@", &told)
        .replace("@DATA@", &data)
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
        "first": scene.frames[0] + scene.frame_offset,
        "last": scene.frames[1] + scene.frame_offset,
        "size": [scene.size.width, scene.size.height],
        "pixel_aspect": scene.size.pixel_aspect,
        "camera": match scene.camera.0 {
            CameraNode::OfScene(node) => json!(node),
            CameraNode::Added => json!("added"),
        },
        "yfov": yfov,
        "ymag": ymag,
        "layers": scene.layers.iter().map(|layer| layer_data(layer, scene.frame_offset)).collect::<Vec<_>>(),
    })
}

fn layer_data(layer: &BlenderLayer, frame_offset: i32) -> Value {
    let lattice = match &layer.method {
        BlenderMethod::Baked(why) => return json!({ "name": layer.name, "baked": why }),
        BlenderMethod::Lattice(lattice) => lattice,
    };
    let frames = lattice.frames.iter().map(|pose| {
        let rows = pose.scene_from_lattice.transpose().to_cols_array();
        let moved = pose.moved.as_flattened();
        json!({ "frame": pose.frame + frame_offset, "shot_frame": pose.frame, "scene_from_lattice": rows, "moved": moved })
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
