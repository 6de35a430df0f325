//! A scene with some meshes deformed frame by frame: the input of the glTF writer.
//!
//! In: filled by the pipeline. Out: plain data.

use crate::scene::{Lens, Scene};
use glam::{Mat4, Vec3, Vec4};

/// A scene with the vertices of its warped meshes at each frame.
#[derive(Clone, Debug)]
pub(crate) struct BakedScene<'a> {
    /// The scene as it was loaded.
    pub scene: &'a Scene,
    /// The clip to export; others are dropped.
    pub clip: Option<usize>,
    /// Frames, increasing, at least one.
    pub frames: Vec<i32>,
    /// One per frame: time in the file, in seconds, increasing, ≥ 0.
    pub times_secs: Vec<f64>,
    /// Animation of the nodes.
    pub(crate) motion: NodeMotion,
    /// Nodes whose meshes are deformed.
    pub nodes: Vec<BakedNode>,
    /// A camera to add to the file.
    pub(crate) camera: Option<AddedCamera>,
}

/// Animation of the nodes of an exported scene.
#[derive(Clone, Debug)]
pub(crate) enum NodeMotion {
    /// The keys of the clip, shifted in time.
    Keys {
        /// Shift in seconds, ≥ 0.
        shift_secs: f64,
    },
    /// One key per frame, for programs whose interpolation differs from that of glTF.
    Sampled(Vec<SampledNode>),
}

/// The transform of an animated node, frame by frame.
#[derive(Clone, Debug)]
pub(crate) struct SampledNode {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// One per frame.
    pub translations: Vec<Vec3>,
    /// One per frame; neighbours lie in the same hemisphere.
    pub rotations: Vec<Vec4>,
    /// One per frame.
    pub scales: Vec<Vec3>,
    /// #targets per frame; empty without morph targets.
    pub weights: Vec<f32>,
}

/// The deformed mesh of a node.
#[derive(Clone, Debug)]
pub(crate) struct BakedNode {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// One per deformed primitive.
    pub parts: Vec<BakedPart>,
}

/// A deformed primitive, in the space of its node.
#[derive(Clone, Debug)]
pub(crate) struct BakedPart {
    /// Index into the mesh's primitives.
    pub primitive: usize,
    /// Undeformed vertices at the first frame.
    pub base: BakedShape,
    /// One per frame.
    pub shapes: Vec<BakedShape>,
}

/// The vertices of a primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BakedShape {
    /// #vertices.
    pub positions: Vec<Vec3>,
    /// #vertices, unit length.
    pub normals: Vec<Vec3>,
    /// #vertices, or empty; w = handedness.
    pub tangents: Vec<Vec4>,
}

/// A camera to add to the file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AddedCamera {
    /// Placement of the camera, which looks along −z.
    pub scene_from_camera: Mat4,
    /// Lens of the camera.
    pub lens: Lens,
    /// Distance of the near plane, in metres.
    pub near: f32,
    /// scene_from_camera, one per frame; empty if the camera does not move.
    pub motion: Vec<Mat4>,
}
