//! Stage 2: a [`Scene`] at one time becomes a [`Pose`]: skinned, morphed, placed in scene space.
//!
//! In: the scene, a clip and seconds. Out: positions, normals and lights in scene space.

mod deform;
mod hierarchy;
mod sample;

use crate::scene::{Clip, LightKind, Scene};
use crate::space::{ScenePoint, SceneVector};
use glam::{DMat4, Mat4, Vec3, Vec4};
use sample::Moved;

/// The posed scene at one time, in scene space.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// #nodes of the scene: scene_from_node.
    pub scene_from_node: Vec<Mat4>,
    /// One part per (node, primitive) with triangles or lines, in node order, then primitive order: the same list at every time.
    pub parts: Vec<PosedPart>,
    /// The scene's lights, placed in scene space.
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
    /// Whether the node's transform mirrors the part (negative determinant), which swaps front and back.
    pub is_mirrored: bool,
}

/// A light in scene space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedLight {
    /// Kind and cone.
    pub kind: LightKind,
    /// Linear RGB times intensity.
    pub color: Vec3,
    /// Its position.
    pub position: ScenePoint,
    /// Unit vector along which it shines.
    pub direction: SceneVector,
    /// Distance at which its light ends, in metres.
    pub range: f32,
}

/// The clip that animates the scene, and whether it loops.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClipChoice {
    /// Index into [`Scene::clips`]; `None`: the rest pose.
    pub clip: Option<usize>,
    /// Whether the clip repeats after its end instead of holding.
    pub is_looped: bool,
}

/// Poses the scene at `seconds` of the chosen clip. Clips hold their first and last keys, or repeat from 0 to their
/// end. A clip index out of range gives the rest pose.
///
/// ```
/// use pinwarp::{pose, scene::Scene};
/// let posed = pose::pose(&Scene::default(), pose::ClipChoice::default(), 0.5);
/// assert!(posed.parts.is_empty());
/// ```
#[must_use]
pub fn pose(scene: &Scene, choice: ClipChoice, seconds: f64) -> Pose {
    posed(scene, choice, seconds, Detail::Surface)
}

/// Poses as [`pose`] does, without normals and tangents: for bounds.
#[must_use]
pub(crate) fn pose_positions(scene: &Scene, choice: ClipChoice, seconds: f64) -> Pose {
    posed(scene, choice, seconds, Detail::Positions)
}

/// What is computed of every vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detail {
    /// Positions alone.
    Positions,
    /// Positions, normals, and tangents if there are some.
    Surface,
}

fn posed(scene: &Scene, choice: ClipChoice, seconds: f64, detail: Detail) -> Pose {
    let moved = moved(scene, choice, seconds);
    let scene_from_node = hierarchy::scene_from_nodes(scene, &moved);
    Pose {
        parts: deform::parts(scene, (&moved, &scene_from_node), detail),
        lights: hierarchy::lights(scene, &scene_from_node),
        scene_from_node: scene_from_node.iter().map(DMat4::as_mat4).collect(),
    }
}

/// Whether the pose of a scene is the same at all times.
#[must_use]
pub(crate) fn is_still(scene: &Scene, choice: ClipChoice) -> bool {
    choice.clip.and_then(|index| scene.clips.get(index)).is_none_or(|clip| clip.tracks.is_empty())
}

/// Places the nodes of a scene as [`pose`] does, without its parts and lights.
#[must_use]
pub(crate) fn placed_nodes(scene: &Scene, choice: ClipChoice, seconds: f64) -> Pose {
    let scene_from_node = hierarchy::scene_from_nodes(scene, &moved(scene, choice, seconds));
    Pose { scene_from_node: scene_from_node.iter().map(DMat4::as_mat4).collect(), ..Pose::default() }
}

/// Samples the chosen clip.
fn moved(scene: &Scene, choice: ClipChoice, seconds: f64) -> Moved {
    let clip = choice.clip.and_then(|index| scene.clips.get(index));
    sample::sample(scene, clip, clip.map_or(0.0, |clip| clip_seconds(clip, choice.is_looped, seconds)))
}

/// The nodes of a scene at one time, relative to their parents.
#[cfg(any(test, feature = "cli"))]
#[derive(Clone, Debug, Default)]
pub(crate) struct LocalPose {
    /// #nodes: parent_from_node.
    pub(crate) parent_from_node: Vec<DMat4>,
    /// #nodes: morph weights.
    pub(crate) weights: Vec<Vec<f64>>,
}

/// Returns the node transforms at `seconds` of the chosen clip, without meshes; time as in [`pose`].
#[cfg(any(test, feature = "cli"))]
#[must_use]
pub(crate) fn local_pose(scene: &Scene, choice: ClipChoice, seconds: f64) -> LocalPose {
    let moved = moved(scene, choice, seconds);
    LocalPose { parent_from_node: moved.parent_from_node, weights: moved.weights }
}

/// Returns the time within the clip.
fn clip_seconds(clip: &Clip, is_looped: bool, seconds: f64) -> f64 {
    let end = f64::from(clip.end_secs);
    if is_looped && end > 0.0 { seconds.rem_euclid(end) } else { seconds }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn positions_alone_are_those_of_the_surface() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/walker/walker.glb");
        let scene = crate::scene::load(&path).expect("a bundled scene");
        let choice = ClipChoice { clip: Some(0), is_looped: true };
        let (whole, positions) = (pose(&scene, choice, 0.3), pose_positions(&scene, choice, 0.3));
        assert!(!whole.parts.is_empty() && whole.scene_from_node == positions.scene_from_node);
        for (whole, alone) in whole.parts.iter().zip(&positions.parts) {
            assert_eq!(whole.positions, alone.positions);
            assert!(!whole.normals.is_empty() && alone.normals.is_empty() && alone.tangents.is_empty());
        }
    }
}
