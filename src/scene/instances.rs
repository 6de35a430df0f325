//! EXT_mesh_gpu_instancing: expands an instanced mesh into one node per instance.
//!
//! In: nodes with the extension and its accessors. Out: child nodes with the mesh, appended to the file's nodes.

use super::SceneError;
use super::accessor::Integers;
use super::file::File;
use super::limits::{LARGEST, is_usable};
use super::nodes::{name, unit};
use crate::spelling::pluralised;
use glam::{Quat, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::Semantic;
use gltf::json::scene::UnitQuaternion;
use gltf::json::validation::Checked;
use gltf::json::{self, Index, Root};
use serde_json::Value;
#[cfg(any(test, feature = "cli", feature = "editor"))]
use serde_json::json;

/// Name of the extension.
pub(super) const EXTENSION: &str = "EXT_mesh_gpu_instancing";

/// Maximum number of instances of a file.
const MAX_INSTANCES: usize = 1 << 18;

/// Maximum number of vertices of all instances together, as each is posed separately.
const MAX_VERTICES: usize = 1 << 23;

/// The instances of one node.
pub(super) struct Instances {
    /// Index of the node in the file.
    node: usize,
    /// Its name.
    name: String,
    placements: Vec<InstancePlacement>,
}

/// node_from_instance.
#[derive(Clone, Copy)]
struct InstancePlacement {
    translation: Vec3,
    rotation: Quat,
    scale: Vec3,
}

impl Instances {
    /// Index of the node in the file.
    pub(super) const fn node(&self) -> usize {
        self.node
    }

    /// Returns the number of instances.
    pub(super) fn count(&self) -> usize {
        self.placements.len()
    }
}

/// Reads all instances of a file; `warnings` receives what is ignored.
pub(super) fn read(file: &File, warnings: &mut Vec<String>) -> Result<Vec<Instances>, SceneError> {
    let mut found = Vec::new();
    let (mut instances, mut vertices) = (0usize, 0usize);
    for (index, node) in file.root.nodes.iter().enumerate() {
        let Some(body) = body(node) else { continue };
        let name = name(file, index);
        let Some(mesh) = node.mesh else { continue };
        if node.skin.is_some() {
            warnings
                .push(format!("node \"{name}\": instances of a skinned mesh stand in one place and are drawn once"));
            continue;
        }
        let count = count(file, body, &name)?;
        instances = instances.saturating_add(count);
        vertices = vertices.saturating_add(count.saturating_mul(vertex_count(file, mesh.value())));
        if instances > MAX_INSTANCES || vertices > MAX_VERTICES {
            let count = pluralised(count, "instance", "instances");
            return Err(file.invalid(format!(
                "node \"{name}\" has {count}; with it the file asks for {instances} instances of {vertices} vertices, \
                 at most {MAX_INSTANCES} and {MAX_VERTICES} are drawn; export fewer"
            )));
        }
        let placements = placements(file, body, (&name, count))?;
        found.push(Instances { node: index, name, placements });
    }
    Ok(found)
}

fn body(node: &json::Node) -> Option<&Value> {
    node.extensions.as_ref()?.others.get(EXTENSION)
}

/// Returns the accessor of an attribute.
fn accessor(body: &Value, attribute: &str) -> Option<Index<json::Accessor>> {
    let number = body["attributes"][attribute].as_u64()?;
    u32::try_from(number).ok().map(Index::new)
}

/// Returns the number of instances, on which all attributes must agree.
fn count(file: &File, body: &Value, name: &str) -> Result<usize, SceneError> {
    let mut agreed: Option<(usize, &str)> = None;
    for attribute in body["attributes"].as_object().into_iter().flatten().map(|(attribute, _)| attribute) {
        let Some(accessor) = accessor(body, attribute) else {
            return Err(file.invalid(format!("node \"{name}\", {EXTENSION}: {attribute} names no accessor")));
        };
        let count = file.count(accessor, format_args!("node \"{name}\", {EXTENSION}, {attribute}"))?;
        match agreed {
            Some((other, first)) if other != count => {
                let what = format!("{first} has {other} elements and {attribute} {count}");
                return Err(file.invalid(format!("node \"{name}\", {EXTENSION}: {what}")));
            }
            _ => agreed = Some((count, attribute)),
        }
    }
    Ok(agreed.map_or(0, |(count, _)| count))
}

/// Returns the number of posed vertices of a mesh: triangles without normals share none.
fn vertex_count(file: &File, mesh: usize) -> usize {
    let count =
        |accessor: Index<json::Accessor>| file.root.get(accessor).map_or(0, |accessor| accessor.count.0 as usize);
    let of_primitive = |primitive: &json::mesh::Primitive| {
        let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions)).map_or(0, |&at| count(at));
        positions.max(primitive.indices.map_or(0, count))
    };
    let primitives = file.root.meshes.get(mesh).into_iter().flat_map(|mesh| &mesh.primitives);
    primitives.map(of_primitive).fold(0, usize::saturating_add)
}

fn placements(file: &File, body: &Value, (name, count): (&str, usize)) -> Result<Vec<InstancePlacement>, SceneError> {
    let read = |attribute: &str, kind: Type, integers: Integers| {
        let Some(accessor) = accessor(body, attribute) else { return Ok(None) };
        let what = format_args!("node \"{name}\", {EXTENSION}, {attribute}");
        let floats = file.floats(accessor, &[kind], integers, what)?;
        match floats.values.iter().position(|value| !is_usable(*value)) {
            Some(value) => {
                let instance = value / floats.width;
                let what = format!("{attribute} of instance {instance} is not a finite number, or beyond {LARGEST:e}");
                Err(file.invalid(format!("node \"{name}\": {what}")))
            }
            None => Ok(Some(floats)),
        }
    };
    let translations = read("TRANSLATION", Type::Vec3, Integers::AsFlagged)?.map(|floats| floats.map(Vec3::from_array));
    let rotations = read("ROTATION", Type::Vec4, Integers::Normalized)?.map(|floats| floats.map(Quat::from_array));
    let scales = read("SCALE", Type::Vec3, Integers::AsFlagged)?.map(|floats| floats.map(Vec3::from_array));
    let placement = |instance: usize| InstancePlacement {
        translation: translations.as_ref().map_or(Vec3::ZERO, |list| list[instance]),
        rotation: rotations.as_ref().map_or(Quat::IDENTITY, |list| unit(list[instance])),
        scale: scales.as_ref().map_or(Vec3::ONE, |list| list[instance]),
    };
    Ok((0..count).map(placement).collect())
}

/// Appends a node per instance to the file's nodes, as a child of the original node, which loses its mesh.
pub(super) fn add_nodes(root: &mut Root, instances: &[Instances]) {
    for Instances { node, name, placements } in instances {
        let first = root.nodes.len() as u32;
        let template = json::Node {
            mesh: root.nodes[*node].mesh,
            weights: root.nodes[*node].weights.clone(),
            ..json::Node::default()
        };
        root.nodes.extend(placements.iter().enumerate().map(|(number, placement)| json::Node {
            name: Some(instance_name(name, number)),
            translation: Some(placement.translation.to_array()),
            rotation: Some(UnitQuaternion(placement.rotation.to_array())),
            scale: Some(placement.scale.to_array()),
            ..template.clone()
        }));
        let node = &mut root.nodes[*node];
        node.mesh = None;
        node.children.get_or_insert_default().extend((0..placements.len() as u32).map(|k| Index::new(first + k)));
    }
}

/// Does the same in a file's JSON, in the same order.
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(super) fn add_json_nodes(root: &mut Value, instances: &[Instances]) {
    let Some(nodes) = root.get_mut("nodes").and_then(Value::as_array_mut) else { return };
    for Instances { node, name, placements } in instances {
        let first = nodes.len();
        let [mesh, weights] = ["mesh", "weights"].map(|key| nodes[*node].get(key).cloned());
        nodes.extend(placements.iter().enumerate().map(|(number, placement)| {
            let mut instance = json!({
                "name": instance_name(name, number),
                "translation": placement.translation.to_array(),
                "rotation": placement.rotation.to_array(),
                "scale": placement.scale.to_array(),
                "mesh": mesh,
            });
            if let Some(weights) = &weights {
                instance["weights"] = weights.clone();
            }
            instance
        }));
        let children = (first..first + placements.len()).map(|child| json!(child));
        let node = &mut nodes[*node];
        if let Some(node) = node.as_object_mut() {
            node.remove("mesh");
            node.remove("weights");
            if let Some(extensions) = node.get_mut("extensions").and_then(Value::as_object_mut) {
                extensions.remove(EXTENSION);
            }
            if let Some(list) = node.entry("children").or_insert_with(|| json!([])).as_array_mut() {
                list.extend(children);
            }
        }
    }
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(names) = root.get_mut(list).and_then(Value::as_array_mut) {
            names.retain(|name| name != EXTENSION);
        }
        // The format allows no empty list here.
        if root.get(list).and_then(Value::as_array).is_some_and(Vec::is_empty) {
            root.as_object_mut().and_then(|root| root.remove(list));
        }
    }
}

fn instance_name(node: &str, number: usize) -> String {
    format!("{node}[{number}]")
}
