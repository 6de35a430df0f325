//! Reads skins, and checks that meshes and skins are consistent.
//!
//! In: the JSON and the placed nodes. Out: joints as scene nodes with their rest matrices.

use super::accessor::Integers;
use super::file::File;
use super::nodes::{self, Tree, Used};
use super::{Node, Scene, SceneError, Skin};
use crate::spelling::pluralised;
use glam::Mat4;
use gltf::json::accessor::Type;

/// Reads the skins in use.
pub(super) fn load(file: &File, tree: &Tree, used: &Used) -> Result<Vec<Skin>, SceneError> {
    used.file_from_scene.iter().map(|&index| load_skin(file, tree, index)).collect()
}

fn load_skin(file: &File, tree: &Tree, index: usize) -> Result<Skin, SceneError> {
    let skin = &file.root.skins[index];
    let mut joints = Vec::with_capacity(skin.joints.len());
    for joint in &skin.joints {
        let place = tree.scene_from_file.get(joint.value()).copied().flatten();
        joints.push(place.ok_or_else(|| {
            let name = nodes::name(file, joint.value());
            file.invalid(format!("skins[{index}]: its joint \"{name}\" is not part of the scene"))
        })?);
    }
    if joints.is_empty() {
        return Err(file.invalid(format!("skins[{index}] has no joints")));
    }
    let joint_from_mesh = match skin.inverse_bind_matrices {
        None => vec![Mat4::IDENTITY; joints.len()],
        Some(accessor) => {
            let what = format_args!("skins[{index}], inverse bind matrices");
            let matrices = file.floats(accessor, &[Type::Mat4], Integers::AsFlagged, what)?;
            matrices.map(|columns| Mat4::from_cols_array(&columns))
        }
    };
    if joint_from_mesh.len() < joints.len() {
        let have = pluralised(joint_from_mesh.len(), "inverse bind matrix", "inverse bind matrices");
        let need = pluralised(joints.len(), "joint", "joints");
        return Err(file.invalid(format!("skins[{index}] has {have} for {need}")));
    }
    if let Some(joint) = joint_from_mesh.iter().position(|matrix| !matrix.is_finite()) {
        return Err(file.invalid(format!("skins[{index}]: the inverse bind matrix of joint {joint} is not finite")));
    }
    Ok(Skin { joint_from_mesh: joint_from_mesh[..joints.len()].to_vec(), joints })
}

/// Rejects meshes whose vertices refer to joints that their skin lacks.
pub(super) fn check_influences(file: &File, scene: &Scene) -> Result<(), SceneError> {
    scene.nodes.iter().try_for_each(|node| check_node(file, scene, node))
}

fn check_node(file: &File, scene: &Scene, node: &Node) -> Result<(), SceneError> {
    let (Some(mesh), Some(skin)) = (node.mesh, node.skin) else { return Ok(()) };
    let joints = scene.skins[skin].joints.len();
    let mesh = &scene.meshes[mesh];
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let is_outside = |vertex: &[super::Influence; 8]| vertex.iter().any(|one| usize::from(one.joint) >= joints);
        if let Some(vertex) = primitive.influences.iter().position(is_outside) {
            return Err(file.invalid(format!(
                "mesh \"{}\", primitive {number}, vertex {vertex} follows a joint that the skin of node \"{}\" ({}) lacks",
                mesh.name,
                node.name,
                pluralised(joints, "joint", "joints")
            )));
        }
    }
    Ok(())
}
