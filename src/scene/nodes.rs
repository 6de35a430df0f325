//! Reads the node hierarchy, skins, cameras and lights.
//!
//! In: the JSON. Out: the nodes of the default scene, parents first, and the objects that they refer to, renumbered.

use super::file::File;
use super::limits::{LARGEST, is_usable};
use super::{Camera, Lens, Light, LightKind, Node, Placement, SceneError};
use glam::{Mat4, Quat, Vec3};
use gltf::json::camera::Type as CameraType;
use gltf::json::extensions::scene::khr_lights_punctual::Type as LightType;
use gltf::json::validation::Checked;
use gltf::json::{self, Index};
use std::collections::HashMap;

/// The nodes of the scene, and their order.
pub(super) struct Tree {
    /// #nodes of the scene: index in the file; parents first.
    pub(super) file_from_scene: Vec<usize>,
    /// Index of the parent among the scene's nodes.
    parents: Vec<Option<usize>>,
    /// #nodes of the file: index in the scene.
    pub(super) scene_from_file: Vec<Option<usize>>,
}

/// The elements of one kind that are in use, numbered in order of first use.
#[derive(Default)]
pub(super) struct Used {
    /// Index in the file per scene element.
    pub(super) file_from_scene: Vec<usize>,
    scene_from_file: HashMap<usize, usize>,
}

impl Used {
    /// Returns the scene index of an element of the file.
    fn of(&mut self, file_index: usize) -> usize {
        *self.scene_from_file.entry(file_index).or_insert_with(|| {
            self.file_from_scene.push(file_index);
            self.file_from_scene.len() - 1
        })
    }
}

/// The elements that nodes refer to.
#[derive(Default)]
pub(super) struct References {
    pub(super) meshes: Used,
    pub(super) skins: Used,
    pub(super) cameras: Used,
    pub(super) lights: Used,
}

/// Returns the name of a node, or a substitute.
pub(super) fn name(file: &File, index: usize) -> String {
    let given = file.root.nodes.get(index).and_then(|node| node.name.clone());
    given.filter(|name| !name.is_empty()).unwrap_or_else(|| format!("node_{index}"))
}

/// Walks the default scene (else the first; without scenes: all roots).
pub(super) fn tree(file: &File) -> Result<Tree, SceneError> {
    let parent_of = parents(file)?;
    let roots = roots(file, &parent_of)?;
    let count = file.root.nodes.len();
    let mut tree = Tree { file_from_scene: Vec::new(), parents: Vec::new(), scene_from_file: vec![None; count] };
    let mut pending: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
    while let Some((index, parent)) = pending.pop() {
        if tree.scene_from_file[index].is_some() {
            return Err(file.invalid(format!("node \"{}\" occurs twice in the scene", name(file, index))));
        }
        let place = tree.file_from_scene.len();
        tree.scene_from_file[index] = Some(place);
        tree.file_from_scene.push(index);
        tree.parents.push(parent);
        pending.extend(children(file, index).rev().map(|child| (child, Some(place))));
    }
    Ok(tree)
}

fn children(file: &File, index: usize) -> impl DoubleEndedIterator<Item = usize> {
    file.root.nodes[index].children.iter().flatten().map(Index::value)
}

/// Returns the parent of every node of the file; rejects cycles and second parents.
fn parents(file: &File) -> Result<Vec<Option<usize>>, SceneError> {
    let count = file.root.nodes.len();
    let mut parents = vec![None; count];
    for index in 0..count {
        for child in children(file, index) {
            let Some(parent) = parents.get_mut(child) else {
                return Err(file.invalid(format!("node \"{}\" has a child that does not exist", name(file, index))));
            };
            if parent.replace(index).is_some() {
                return Err(file.invalid(format!("node \"{}\" is a child twice", name(file, child))));
            }
        }
    }
    // Every node has at most one parent, so a walk upwards ends either at a root or in a cycle.
    let mut is_rooted = vec![false; count];
    for start in 0..count {
        let mut chain = Vec::new();
        let mut at = Some(start);
        while let Some(index) = at.filter(|&index| !is_rooted[index]) {
            if chain.len() > count {
                return Err(file.invalid(format!("node \"{}\" is its own ancestor", name(file, start))));
            }
            chain.push(index);
            at = parents[index];
        }
        chain.into_iter().for_each(|index| is_rooted[index] = true);
    }
    Ok(parents)
}

fn roots(file: &File, parents: &[Option<usize>]) -> Result<Vec<usize>, SceneError> {
    let root = &file.root;
    let scene = match root.scene {
        Some(index) => Some(root.get(index).ok_or_else(|| file.invalid("the default scene does not exist"))?),
        None => root.scenes.first(),
    };
    let Some(scene) = scene else {
        return Ok((0..parents.len()).filter(|&index| parents[index].is_none()).collect());
    };
    let roots: Vec<usize> = scene.nodes.iter().map(Index::value).collect();
    match roots.iter().find(|&&index| index >= parents.len()) {
        Some(index) => Err(file.invalid(format!("the scene names nodes[{index}], which does not exist"))),
        None => Ok(roots),
    }
}

/// Reads the scene's nodes; `used` receives the elements they refer to. Morph weights are those of the nodes alone.
pub(super) fn load(file: &File, tree: &Tree, used: &mut References) -> Result<Vec<Node>, SceneError> {
    let pairs = tree.file_from_scene.iter().zip(&tree.parents);
    pairs.map(|(&index, &parent)| load_node(file, index, parent, used)).collect()
}

fn load_node(file: &File, index: usize, parent: Option<usize>, used: &mut References) -> Result<Node, SceneError> {
    let node = &file.root.nodes[index];
    let name = name(file, index);
    let light = node.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    let lights = light_list(file).len();
    let check = |number: usize, count: usize, kind: &str| {
        let what = format!("node \"{name}\" names {kind}[{number}], which does not exist");
        if number < count { Ok(number) } else { Err(file.invalid(what)) }
    };
    let root = &file.root;
    let mesh = node.mesh.map(|mesh| check(mesh.value(), root.meshes.len(), "meshes")).transpose()?;
    let skin = node.skin.map(|skin| check(skin.value(), root.skins.len(), "skins")).transpose()?;
    let camera = node.camera.map(|camera| check(camera.value(), root.cameras.len(), "cameras")).transpose()?;
    let light = light.map(|light| check(light.light.value(), lights, "lights")).transpose()?;
    Ok(Node {
        parent,
        rest: placement(node).ok_or_else(|| {
            file.invalid(format!("the placement of node \"{name}\" is not finite, or beyond {LARGEST:e}"))
        })?,
        mesh: mesh.map(|mesh| used.meshes.of(mesh)),
        // A skin without a mesh has no effect.
        skin: skin.filter(|_| mesh.is_some()).map(|skin| used.skins.of(skin)),
        camera: camera.map(|camera| used.cameras.of(camera)),
        light: light.map(|light| used.lights.of(light)),
        weights: node.weights.clone().unwrap_or_default(),
        name,
    })
}

/// Returns the transform of a node; `None` if a number is not finite or too large.
fn placement(node: &json::Node) -> Option<Placement> {
    if let Some(columns) = node.matrix {
        let matrix = Mat4::from_cols_array(&columns);
        return columns.into_iter().all(is_usable).then_some(Placement::Matrix(matrix));
    }
    let translation = Vec3::from(node.translation.unwrap_or_default());
    let rotation = Quat::from_array(node.rotation.unwrap_or_default().0);
    let scale = node.scale.map_or(Vec3::ONE, Vec3::from);
    let are_usable = [translation, scale].into_iter().all(|by| by.to_array().into_iter().all(is_usable));
    (are_usable && rotation.is_finite()).then(|| Placement::Trs { translation, rotation: unit(rotation), scale })
}

/// Returns the rotation of a quaternion of any length; the identity for the zero quaternion.
pub(super) fn unit(rotation: Quat) -> Quat {
    let length = rotation.length();
    if length.is_finite() && length > 0.0 { rotation / length } else { Quat::IDENTITY }
}

/// Reads the cameras in use.
pub(super) fn cameras(file: &File, used: &Used) -> Result<Vec<Camera>, SceneError> {
    used.file_from_scene.iter().map(|&index| camera(file, index)).collect()
}

fn camera(file: &File, index: usize) -> Result<Camera, SceneError> {
    let camera = &file.root.cameras[index];
    let fault = |text: &str| file.invalid(format!("cameras[{index}] {text}"));
    let (lens, near) = match (camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(CameraType::Perspective), Some(lens), _) => {
            let is_good = lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI && lens.znear > 0.0;
            is_good.then_some((Lens::Perspective { yfov: lens.yfov }, lens.znear))
        }
        (Checked::Valid(CameraType::Orthographic), _, Some(lens)) => {
            // A negative magnification is discouraged but legal in old files; its sign is ignored.
            let ymag = lens.ymag.abs();
            (ymag > 0.0).then_some((Lens::Orthographic { ymag }, lens.znear))
        }
        _ => return Err(fault("lacks the lens that its type names")),
    }
    .ok_or_else(|| fault("has a field of view, size or near distance outside the possible"))?;
    if !near.is_finite() {
        return Err(fault("has a near distance that is not finite"));
    }
    Ok(Camera { name: camera.name.clone().unwrap_or_default(), lens, near })
}

type JsonLight = json::extensions::scene::khr_lights_punctual::Light;

fn light_list(file: &File) -> &[JsonLight] {
    let extension = file.root.extensions.as_ref().and_then(|extensions| extensions.khr_lights_punctual.as_ref());
    extension.map_or(&[], |extension| extension.lights.as_slice())
}

/// Reads the lights in use.
pub(super) fn lights(file: &File, used: &Used) -> Result<Vec<Light>, SceneError> {
    let list = light_list(file);
    used.file_from_scene.iter().map(|&index| light(&list[index], index, file)).collect()
}

fn light(light: &JsonLight, index: usize, file: &File) -> Result<Light, SceneError> {
    let kind = match light.type_ {
        Checked::Valid(LightType::Directional) => LightKind::Directional,
        Checked::Valid(LightType::Point) => LightKind::Point,
        Checked::Valid(LightType::Spot) => {
            let spot = light.spot.clone().unwrap_or_default();
            // The crate's own default for the outer angle is 0 if the whole spot is omitted.
            let outer = if light.spot.is_none() { std::f32::consts::FRAC_PI_4 } else { spot.outer_cone_angle };
            // Renderers divide by the width of the cosine fall-off; cones out of range are clamped to the legal range.
            let outer = outer.clamp(0.0, std::f32::consts::FRAC_PI_2);
            LightKind::Spot { inner: spot.inner_cone_angle.clamp(0.0, outer), outer }
        }
        Checked::Invalid => return Err(file.invalid(format!("lights[{index}] has an unknown type"))),
    };
    let color = Vec3::from(light.color) * light.intensity;
    if !color.is_finite() {
        return Err(file.invalid(format!("lights[{index}] has a colour that is not finite")));
    }
    let range = light.range.filter(|range| *range > 0.0).unwrap_or(f32::INFINITY);
    Ok(Light { kind, color, range })
}
