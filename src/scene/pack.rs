//! A glTF file as one JSON value and one buffer, for exports that edit it.
//!
//! In: the path of a .gltf or .glb file. Out: its JSON unchanged, with extras and unsupported extensions, except that
//! every buffer and picture is moved into a single buffer.

use super::file::File;
use super::{FileAccess, SceneError, access, instances, json};
use serde_json::{Value, json};
use std::path::Path;

/// A file without references to other files.
#[derive(Clone, Debug)]
pub(crate) struct Packed {
    /// The JSON; all buffer views are in buffer 0, and `buffers` is omitted.
    pub json: Value,
    /// Buffer 0.
    pub binary: Vec<u8>,
}

/// Reads a glTF 2.0 file with all buffers and pictures it refers to. A picture that cannot be read remains a reference;
/// GPU instances become nodes.
///
/// # Errors
/// [`SceneError`] if the file or a buffer cannot be read, violates the format, or requires an unsupported extension.
#[cfg_attr(not(any(test, feature = "cli")), expect(dead_code, reason = "only exports call it"))]
pub(crate) fn pack(path: &Path, access: FileAccess) -> Result<Packed, SceneError> {
    let bytes = access::read_scene_file(path)?;
    let parsed = json::parse(path, &bytes, &mut Vec::new())?;
    let mut packed = Packed { json: json::untouched(path, &bytes)?, binary: Vec::new() };
    let file = File::resolve((path, access), parsed.root, bytes, parsed.binary)?;
    instances::add_json_nodes(&mut packed.json, &instances::read(&file, &mut Vec::new())?);
    let starts: Vec<usize> = file.buffers().iter().map(|buffer| append(&mut packed.binary, buffer)).collect();
    for view in list(&mut packed.json, "bufferViews") {
        let start = view["buffer"].as_u64().and_then(|buffer| starts.get(buffer as usize));
        let start = *start.ok_or_else(|| file.invalid("a buffer view names a buffer that does not exist"))?;
        view["byteOffset"] = json!(start as u64 + view["byteOffset"].as_u64().unwrap_or(0));
        view["buffer"] = json!(0);
        // Optional compression extensions of a view refer to the original buffers.
        view.as_object_mut().and_then(|view| view.remove("extensions"));
    }
    if let Some(root) = packed.json.as_object_mut() {
        root.remove("buffers");
    }
    take_in_images(&file, &mut packed);
    Ok(packed)
}

/// Moves pictures in separate files and data URIs into the buffer.
fn take_in_images(file: &File, packed: &mut Packed) {
    let mut views = packed.json["bufferViews"].as_array().map_or(0, Vec::len);
    let mut taken = Vec::new();
    for image in list(&mut packed.json, "images") {
        let Some(bytes) = image["uri"].as_str().and_then(|uri| file.read_uri(uri).ok()) else { continue };
        let Some(kind) = mime_type(&bytes) else { continue };
        let start = append(&mut packed.binary, &bytes);
        taken.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }));
        if let Some(image) = image.as_object_mut() {
            image.remove("uri");
            image.insert("mimeType".into(), json!(kind));
            image.insert("bufferView".into(), json!(views));
        }
        views += 1;
    }
    if taken.is_empty() {
        return;
    }
    if packed.json["bufferViews"].is_null() {
        packed.json["bufferViews"] = json!([]);
    }
    packed.json["bufferViews"].as_array_mut().into_iter().for_each(|views| views.append(&mut taken));
}

/// Returns the MIME type of the two picture formats that glTF allows.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, ..] => Some("image/jpeg"),
        _ => None,
    }
}

/// Appends bytes to the buffer at a multiple of four; returns the offset.
fn append(binary: &mut Vec<u8>, bytes: &[u8]) -> usize {
    binary.resize(binary.len().next_multiple_of(4), 0);
    let start = binary.len();
    binary.extend_from_slice(bytes);
    start
}

fn list<'a>(json: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    json.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}
