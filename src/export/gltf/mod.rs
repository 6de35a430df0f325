//! Writes the warped scene as a .glb file: deformed meshes become morph targets, one per frame; everything else is kept.
//!
//! In: the packed file of a scene, and its deformed meshes. Out: the bytes of a .glb file (glTF 2.0, section 4).

mod baked;
mod buffer;
mod cards;
mod clip;
mod mesh;

pub(crate) use baked::{AddedCamera, NodeMotion, SampledNode};
pub(crate) use baked::{BakedNode, BakedPart, BakedScene, BakedShape};

pub(crate) use cards::packed_cards;

use super::ExportError;
use crate::files::GENERATOR;
use crate::scene::{Lens, Packed};
use buffer::push;
use serde_json::{Value, json};

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
/// Sizes in bytes of the file header and of a chunk header.
const HEADERS: [usize; 2] = [12, 8];

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
    container(packed)
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

/// Returns a packed file as it is.
///
/// # Errors
/// As [`glb`].
pub(crate) fn packed_glb(packed: Packed) -> Result<Vec<u8>, ExportError> {
    container(packed)
}

/// Assembles the header, the JSON chunk padded with spaces, and the binary chunk padded with zeros.
fn container(mut packed: Packed) -> Result<Vec<u8>, ExportError> {
    packed.binary.resize(packed.binary.len().next_multiple_of(4), 0);
    packed.json["buffers"] = json!([{ "byteLength": packed.binary.len() }]);
    let mut text = packed.json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = HEADERS[0] + 2 * HEADERS[1] + text.len() + packed.binary.len();
    let length = u32::try_from(total).map_err(|_| ExportError::TooLarge { bytes: total })?;
    let mut bytes = Vec::with_capacity(total);
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&length.to_le_bytes());
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &packed.binary)] {
        bytes.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        bytes.extend_from_slice(kind);
        bytes.extend_from_slice(chunk);
    }
    Ok(bytes)
}
