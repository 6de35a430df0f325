//! Writes the meshes of deformed nodes as morph targets, one per frame.
//!
//! In: a packed file and shapes in the space of a node. Out: a separate mesh for the node in the file.

use super::baked::{BakedNode, BakedPart, BakedScene, BakedShape};
use super::buffer::{add, add_bounded, push};
use crate::scene::{Packed, Primitive};
use glam::{Vec3, Vec4};
use serde_json::{Map, Value, json};

/// Normals and tangents that change by less than this in all frames get no target.
const MIN_CHANGE: f32 = 1e-6;

/// Gives a node its own mesh with one target per frame, and removes its skin, whose effect is included in the targets.
pub(super) fn write(packed: &mut Packed, baked: &BakedScene<'_>, node: &BakedNode) {
    let number = baked.scene.file_from_scene[node.node];
    let Some(mesh) = packed.json["nodes"][number]["mesh"].as_u64() else { return };
    let mut json = packed.json["meshes"][mesh as usize].clone();
    let source = baked.scene.nodes[node.node].mesh.map(|mesh| &baked.scene.meshes[mesh]);
    for part in &node.parts {
        let primitive = source.map(|mesh| &mesh.primitives[part.primitive]);
        let (Some(primitive), Some(json)) = (primitive, json["primitives"].get_mut(part.primitive)) else { continue };
        Editor { packed, primitive, part }.edit(json);
    }
    let is_deformed = |place: usize| node.parts.iter().any(|part| part.primitive == place);
    let others = json["primitives"].as_array_mut().into_iter().flatten().enumerate();
    for (_, other) in others.filter(|(place, _)| !is_deformed(*place)) {
        hold_still(packed, other, baked.frames.len());
    }
    json["weights"] = json!(vec![0.0; baked.frames.len()]);
    let names: Vec<String> = baked.frames.iter().map(|frame| format!("frame_{frame:04}")).collect();
    json["extras"] = json!({ "targetNames": names });
    let mesh = push(&mut packed.json, "meshes", json);
    if let Some(node) = packed.json["nodes"][number].as_object_mut() {
        node.insert("mesh".into(), json!(mesh));
        node.remove("skin");
        node.remove("weights");
    }
}

/// Adds zero targets to a primitive that is not deformed (points), because all primitives of a mesh need the same number.
fn hold_still(packed: &mut Packed, primitive: &mut Value, count: usize) {
    let Some(position) = primitive["attributes"]["POSITION"].as_u64() else { return };
    let vertices = packed.json["accessors"][position as usize]["count"].as_u64().unwrap_or(0);
    let zeros = add_bounded(packed, &vec![Vec3::ZERO; vertices as usize]);
    primitive["targets"] = json!(vec![json!({ "POSITION": zeros }); count]);
}

struct Editor<'a> {
    packed: &'a mut Packed,
    primitive: &'a Primitive,
    part: &'a BakedPart,
}

impl Editor<'_> {
    fn edit(&mut self, json: &mut Value) {
        let Some(mut attributes) = json["attributes"].as_object().cloned() else { return };
        // Missing normals were generated on vertices that triangles do not share.
        let is_unshared = !attributes.contains_key("NORMAL") && !self.primitive.triangles.is_empty();
        if is_unshared {
            attributes = self.all_attributes();
            json["indices"] = json!(add(self.packed, self.primitive.triangles.as_flattened()));
            json["mode"] = json!(4);
        }
        attributes.retain(|name, _| !name.starts_with("JOINTS_") && !name.starts_with("WEIGHTS_"));
        let BakedShape { positions, normals, tangents } = &self.part.base;
        attributes.insert("POSITION".into(), json!(add_bounded(self.packed, positions)));
        if !self.primitive.triangles.is_empty() {
            attributes.insert("NORMAL".into(), json!(add(self.packed, normals)));
        }
        attributes.remove("TANGENT");
        if !tangents.is_empty() {
            attributes.insert("TANGENT".into(), json!(add(self.packed, tangents)));
        }
        json["attributes"] = Value::Object(attributes);
        json["targets"] = self.targets();
    }

    /// Returns the attributes of vertices that differ from those of the file.
    fn all_attributes(&mut self) -> Map<String, Value> {
        let mut attributes = Map::new();
        for (set, uvs) in self.primitive.uvs.iter().enumerate().filter(|(_, uvs)| !uvs.is_empty()) {
            attributes.insert(format!("TEXCOORD_{set}"), json!(add(self.packed, uvs)));
        }
        if !self.primitive.colors.is_empty() {
            attributes.insert("COLOR_0".into(), json!(add(self.packed, &self.primitive.colors)));
        }
        attributes
    }

    /// Returns one target per frame: the differences from the base.
    fn targets(&mut self) -> Value {
        let base = &self.part.base;
        let turns = !self.primitive.triangles.is_empty() && self.any_moves(|shape| by(&shape.normals, &base.normals));
        let twists = self.any_moves(|shape| by_tangents(shape, base));
        let targets = self.part.shapes.iter().map(|shape| {
            let mut target = Map::new();
            let moved = by(&shape.positions, &base.positions);
            target.insert("POSITION".into(), json!(add_bounded(self.packed, &moved)));
            if turns {
                target.insert("NORMAL".into(), json!(add(self.packed, &by(&shape.normals, &base.normals))));
            }
            if twists {
                target.insert("TANGENT".into(), json!(add(self.packed, &by_tangents(shape, base))));
            }
            Value::Object(target)
        });
        Value::Array(targets.collect())
    }

    fn any_moves(&self, by: impl Fn(&BakedShape) -> Vec<Vec3>) -> bool {
        self.part.shapes.iter().any(|shape| by(shape).iter().any(|by| by.abs().max_element() > MIN_CHANGE))
    }
}

/// Returns the differences between two lists.
fn by(to: &[Vec3], from: &[Vec3]) -> Vec<Vec3> {
    to.iter().zip(from).map(|(to, from)| to - from).collect()
}

/// Returns the differences between tangents; targets do not change the handedness.
fn by_tangents(to: &BakedShape, from: &BakedShape) -> Vec<Vec3> {
    to.tangents.iter().zip(&from.tangents).map(|(to, from): (&Vec4, &Vec4)| (to - from).truncate()).collect()
}
