//! Stage 2: a [`Scene`] at one time becomes a [`Pose`]: skinned, morphed, placed in scene space.

use crate::scene::{LightKind, Scene};
use crate::space::{ScenePoint, SceneVector};
use glam::{Mat4, Vec3, Vec4};

/// The scene at one time. Everything is in scene space.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// scene_from_node, one a scene node.
    pub scene_from_node: Vec<Mat4>,
    /// One a (node, primitive) that has triangles, in node order then primitive order: the same list at every time.
    pub parts: Vec<PosedPart>,
    /// The scene's lights, placed.
    pub lights: Vec<PosedLight>,
}

/// A primitive placed by its node.
#[derive(Clone, Debug, Default)]
pub struct PosedPart {
    /// Index into [`Scene::nodes`].
    pub node: usize,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Index into the mesh's primitives.
    pub primitive: usize,
    /// #vertices.
    pub positions: Vec<ScenePoint>,
    /// #vertices, unit length.
    pub normals: Vec<SceneVector>,
    /// #vertices or empty; w = handedness.
    pub tangents: Vec<Vec4>,
    /// The node mirrors the part (negative determinant): front and back swap.
    pub is_mirrored: bool,
}

/// A light in scene space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedLight {
    /// Kind and cone.
    pub kind: LightKind,
    /// Linear RGB times intensity.
    pub color: Vec3,
    /// Where it stands.
    pub position: ScenePoint,
    /// Unit vector along which it shines.
    pub direction: SceneVector,
    /// Distance at which it ends, metres.
    pub range: f32,
}

/// Which clip moves the scene, and how time runs in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClipChoice {
    /// Index into [`Scene::clips`]; `None`: the rest pose.
    pub clip: Option<usize>,
    /// The clip repeats past its end instead of holding.
    pub is_looped: bool,
}

/// The scene at `seconds` of the chosen clip.
#[must_use]
pub fn pose(scene: &Scene, choice: ClipChoice, seconds: f64) -> Pose {
    let _ = (scene, choice, seconds);
    Pose::default()
}
