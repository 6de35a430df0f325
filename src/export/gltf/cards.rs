//! Exports a scene of pictures as a glTF file, for programs that only read scenes.
//!
//! In: the cards of a shot of pictures, and their pictures as PNG files. Out: a packed file with unlit textured cards,
//! and the camera in front of them.

use super::buffer::{add, add_bounded, push};
use crate::files::GENERATOR;
use crate::scene::{Camera, Lens, Node, Packed, Placement, Primitive, Scene};
use serde_json::{Value, json};

/// Distance of the camera's far plane; the cards lie closely behind each other.
const FAR: f32 = 100.0;

/// Returns the file of a scene made by `scene::picture_cards`; nodes keep their numbers. `pictures`: one per
/// mesh, a PNG file of the whole frame.
#[must_use]
pub(crate) fn packed_cards(scene: &Scene, aspect: f64, pictures: &[Vec<u8>]) -> Packed {
    let json = json!({
        "asset": { "version": "2.0", "generator": GENERATOR },
        "scene": 0,
        "scenes": [{ "nodes": (0..scene.nodes.len()).collect::<Vec<_>>() }],
        "extensionsUsed": ["KHR_materials_unlit"],
        "nodes": scene.nodes.iter().map(node).collect::<Vec<_>>(),
        "cameras": scene.cameras.iter().map(|camera| lens(camera, aspect)).collect::<Vec<_>>(),
        // The pictures end at the frame: clamp instead of repeating.
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
    });
    let mut packed = Packed { json, binary: Vec::new() };
    for (mesh, picture) in scene.meshes.iter().zip(pictures) {
        let material = material(&mut packed, &mesh.name, picture);
        let primitives: Vec<Value> =
            mesh.primitives.iter().map(|card| primitive(&mut packed, card, material)).collect();
        push(&mut packed.json, "meshes", json!({ "name": mesh.name, "primitives": primitives }));
    }
    packed
}

fn node(node: &Node) -> Value {
    let mut told = json!({ "name": node.name });
    match node.rest {
        Placement::Trs { translation, rotation, scale } => {
            told["translation"] = json!(translation);
            told["rotation"] = json!(rotation);
            told["scale"] = json!(scale);
        }
        Placement::Matrix(matrix) => told["matrix"] = json!(matrix.to_cols_array()),
    }
    if let Some(mesh) = node.mesh {
        told["mesh"] = json!(mesh);
    }
    if let Some(camera) = node.camera {
        told["camera"] = json!(camera);
    }
    told
}

fn lens(camera: &Camera, aspect: f64) -> Value {
    match camera.lens {
        Lens::Perspective { yfov } => {
            json!({ "type": "perspective", "perspective": { "yfov": yfov, "aspectRatio": aspect, "znear": camera.near } })
        }
        Lens::Orthographic { ymag } => {
            let xmag = f64::from(ymag) * aspect;
            let seen = json!({ "xmag": xmag, "ymag": ymag, "znear": camera.near, "zfar": FAR });
            json!({ "type": "orthographic", "orthographic": seen })
        }
    }
}

/// Adds an unlit material with a picture; returns its index.
fn material(packed: &mut Packed, name: &str, picture: &[u8]) -> usize {
    let start = packed.binary.len().next_multiple_of(4);
    packed.binary.resize(start, 0);
    packed.binary.extend_from_slice(picture);
    let view = json!({ "buffer": 0, "byteOffset": start, "byteLength": picture.len() });
    let view = push(&mut packed.json, "bufferViews", view);
    let image = json!({ "name": name, "mimeType": "image/png", "bufferView": view });
    let image = push(&mut packed.json, "images", image);
    let texture = push(&mut packed.json, "textures", json!({ "source": image, "sampler": 0 }));
    let look = json!({
        "name": name,
        "pbrMetallicRoughness": { "baseColorTexture": { "index": texture }, "metallicFactor": 0.0 },
        "alphaMode": "BLEND",
        "doubleSided": true,
        "extensions": { "KHR_materials_unlit": {} },
    });
    push(&mut packed.json, "materials", look)
}

fn primitive(packed: &mut Packed, card: &Primitive, material: usize) -> Value {
    let position = add_bounded(packed, &card.positions);
    let attributes = json!({
        "POSITION": position,
        "NORMAL": add(packed, &card.normals),
        "TEXCOORD_0": add(packed, &card.uvs[0]),
    });
    let indices = add(packed, card.triangles.as_flattened());
    json!({ "attributes": attributes, "indices": indices, "material": material, "mode": 4 })
}
