//! Writes the packed file of a scene with its deformed meshes, their clip, and the camera.
//!
//! In: the packed file, the baked scene. Out: the bytes of a .glb file.

use super::baked::{AddedCamera, BakedScene};
use super::buffer::push;
use super::container::packed_glb;
use super::{clip, mesh};
use crate::export::ExportError;
use crate::files::GENERATOR;
use crate::scene::{Lens, Packed};
use serde_json::{Value, json};

/// Returns the file with its deformed meshes and their clip.
///
/// # Errors
/// [`ExportError::TooLarge`] above 4 GiB, the limit of the format.
pub(crate) fn glb(mut packed: Packed, baked: &BakedScene<'_>) -> Result<Vec<u8>, ExportError> {
    for node in &baked.nodes {
        mesh::write(&mut packed, baked, node);
    }
    clip::write(&mut packed, baked);
    if let Some(camera) = &baked.camera {
        let node = add_camera(&mut packed.json, camera);
        clip::add_camera_motion(&mut packed, baked, (camera, node));
    }
    packed.json["asset"]["generator"] = json!(GENERATOR);
    packed_glb(packed)
}

/// Adds the camera on a new node; returns the node's index.
fn add_camera(json: &mut Value, camera: &AddedCamera) -> usize {
    let near = camera.near;
    let lens = match camera.lens {
        Lens::Perspective { yfov } => {
            json!({ "name": "pinwarp", "type": "perspective", "perspective": { "yfov": yfov, "znear": near } })
        }
        Lens::Orthographic { ymag } => json!({ "name": "pinwarp", "type": "orthographic",
            "orthographic": { "xmag": ymag, "ymag": ymag, "znear": near, "zfar": 1e6 } }),
    };
    let number = push(json, "cameras", lens);
    let matrix = camera.scene_from_camera.to_cols_array();
    let extras = json!({ "pinwarp_node": "added" });
    let mut node = json!({ "name": "pinwarp camera", "camera": number, "extras": extras });
    if camera.motion.is_empty() {
        node["matrix"] = json!(matrix);
    }
    let node = push(json, "nodes", node);
    let scene = json["scene"].as_u64().unwrap_or(0) as usize;
    if json["scenes"].get(scene).is_some() {
        push(&mut json["scenes"][scene], "nodes", json!(node));
    }
    node
}
