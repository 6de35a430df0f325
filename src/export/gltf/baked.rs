//! A scene with some of its meshes deformed frame by frame: what the glTF writer wants to know.
//!
//! In: the pipeline fills it. Out: plain data.

use crate::scene::{Lens, Scene};
use glam::{Mat4, Vec3, Vec4};

/// A scene whose warped meshes are told anew for some frames.
#[derive(Clone, Debug)]
pub struct BakedScene<'a> {
    /// The scene as it was loaded.
    pub scene: &'a Scene,
    /// Its clip in use; other clips are left out.
    pub clip: Option<usize>,
    /// Frames, increasing, at least one.
    pub frames: Vec<i32>,
    /// One a frame: its time in the file, seconds, increasing, ≥ 0.
    pub times_secs: Vec<f64>,
    /// How the nodes move.
    pub motion: NodeMotion,
    /// Nodes whose meshes are deformed.
    pub nodes: Vec<BakedNode>,
    /// A camera that the file does not have.
    pub camera: Option<AddedCamera>,
}

/// How the nodes of an exported scene move.
#[derive(Clone, Debug)]
pub enum NodeMotion {
    /// By the keys of the clip, this many seconds later.
    Keys {
        /// Seconds, ≥ 0.
        shift_secs: f64,
    },
    /// By a key a frame, for programs that run between keys otherwise than glTF says.
    Sampled(Vec<SampledNode>),
}

/// The placement of a moving node, frame by frame.
#[derive(Clone, Debug)]
pub struct SampledNode {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// One a frame.
    pub translations: Vec<Vec3>,
    /// One a frame; neighbours on the same half of the sphere.
    pub rotations: Vec<Vec4>,
    /// One a frame.
    pub scales: Vec<Vec3>,
    /// #targets a frame; none where nothing is morphed.
    pub weights: Vec<f32>,
}

/// The deformed mesh of a node.
#[derive(Clone, Debug)]
pub struct BakedNode {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// One a primitive that is deformed.
    pub parts: Vec<BakedPart>,
}

/// A deformed primitive, in the space of its node.
#[derive(Clone, Debug)]
pub struct BakedPart {
    /// Index into the mesh's primitives.
    pub primitive: usize,
    /// Before the warp, in the first frame.
    pub base: BakedShape,
    /// One a frame.
    pub shapes: Vec<BakedShape>,
}

/// The vertices of a primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakedShape {
    /// #vertices.
    pub positions: Vec<Vec3>,
    /// #vertices, unit length.
    pub normals: Vec<Vec3>,
    /// #vertices or none; w = handedness.
    pub tangents: Vec<Vec4>,
}

/// A camera to add.
#[derive(Clone, Debug, PartialEq)]
pub struct AddedCamera {
    /// Where it stands; it looks along −z.
    pub scene_from_camera: Mat4,
    /// Its lens.
    pub lens: Lens,
    /// Distance of its near plane, metres.
    pub near: f32,
    /// One per frame where it moves, else empty: scene_from_camera.
    pub motion: Vec<Mat4>,
}
