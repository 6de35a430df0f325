//! Nodes and lights in scene space.
//!
//! In: transforms relative to parents. Out: scene_from_node, in f64 so that long chains of joints stay exact.

use super::PosedLight;
use super::sample::Moved;
use crate::scene::Scene;
use crate::space::{ScenePoint, SceneVector};
use glam::{DMat4, DVec3};

/// Returns scene_from_node per node; parents come before their children.
pub(super) fn scene_from_nodes(scene: &Scene, moved: &Moved) -> Vec<DMat4> {
    let mut placed: Vec<DMat4> = Vec::with_capacity(scene.nodes.len());
    for (node, parent_from_node) in scene.nodes.iter().zip(&moved.parent_from_node) {
        let scene_from_parent = node.parent.map_or(DMat4::IDENTITY, |parent| placed[parent]);
        placed.push(scene_from_parent * *parent_from_node);
    }
    placed
}

/// Returns the lights, in node order.
pub(super) fn lights(scene: &Scene, scene_from_node: &[DMat4]) -> Vec<PosedLight> {
    let placed = scene.nodes.iter().zip(scene_from_node);
    placed.filter_map(|(node, scene_from_node)| light(scene, node.light?, scene_from_node)).collect()
}

fn light(scene: &Scene, index: usize, scene_from_light: &DMat4) -> Option<PosedLight> {
    let light = scene.lights.get(index)?;
    let direction = scene_from_light.transform_vector3(DVec3::NEG_Z).try_normalize().unwrap_or(DVec3::NEG_Z);
    Some(PosedLight {
        kind: light.kind,
        color: light.color,
        position: ScenePoint(scene_from_light.w_axis.truncate().as_vec3()),
        direction: SceneVector(direction.as_vec3()),
        range: light.range,
    })
}
