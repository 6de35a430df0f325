//! Parses the container and its JSON, and checks them before anything else is read.
//!
//! In: the bytes of a .gltf or .glb file. Out: the JSON as typed data and the range of the binary chunk. Required
//! extensions are checked; harmless content that the typed reader would reject is removed with a warning.

use super::{SceneError, approximate, instances};
use crate::spelling::pluralised;
use gltf::json::{self, Root};
use serde_json::Value;
use std::ops::Range;
use std::path::Path;

/// Supported extensions.
const SUPPORTED: [&str; 6] = [
    instances::EXTENSION,
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

const GLB_MAGIC: u32 = u32::from_le_bytes(*b"glTF");
const CHUNK_JSON: u32 = u32::from_le_bytes(*b"JSON");
const CHUNK_BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// The contents of a file before its buffers are resolved.
pub(super) struct Parsed {
    /// The typed JSON; indices in it are not yet checked.
    pub(super) root: Root,
    /// The range of the binary chunk of a .glb in the file.
    pub(super) binary: Option<Range<usize>>,
}

/// Parses the container and the JSON of `bytes`; `warnings` receives what is ignored.
pub(super) fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<Parsed, SceneError> {
    let invalid = |what| SceneError::Invalid { path: path.to_owned(), what };
    let (text, binary) = split_container(path, bytes)?;
    let mut value = object(path, text)?;
    check_version(path, &value)?;
    check_extensions(path, &value, warnings)?;
    approximate::materials(&mut value);
    strip_foreign(&mut value);
    mend(&mut value, warnings);
    let root = json::deserialize::from_value(value.clone()).map_err(|error| invalid(locate(&value, &error)))?;
    Ok(Parsed { root, binary })
}

/// Parses the JSON of `bytes` without checks or repairs.
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(super) fn untouched(path: &Path, bytes: &[u8]) -> Result<Value, SceneError> {
    object(path, split_container(path, bytes)?.0)
}

fn object(path: &Path, text: &[u8]) -> Result<Value, SceneError> {
    let invalid = |what| SceneError::Invalid { path: path.to_owned(), what };
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let value: Value =
        serde_json::from_slice(text).map_err(|error| invalid(format!("its JSON does not parse: {error}")))?;
    if value.is_object() { Ok(value) } else { Err(invalid("its JSON is not an object".to_owned())) }
}

/// Returns the JSON text and, for a .glb, the range of the binary chunk.
fn split_container<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<Range<usize>>), SceneError> {
    if word(bytes, 0) != Some(GLB_MAGIC) {
        return Ok((bytes, None));
    }
    let invalid = |what: String| SceneError::Invalid { path: path.to_owned(), what };
    let short = || invalid(format!("the .glb ends inside its header ({} bytes); copy or export it again", bytes.len()));
    let version = word(bytes, 4).ok_or_else(short)?;
    if version != 2 {
        return Err(unsupported_version(path, &format!("{version}")));
    }
    let announced = word(bytes, 8).ok_or_else(short)? as usize;
    if announced > bytes.len() {
        return Err(invalid(format!(
            "the .glb is cut short: it announces {announced} bytes and has {}; copy or export it again",
            bytes.len()
        )));
    }
    let chunks = chunks(&bytes[..announced]).map_err(invalid)?;
    match chunks.first() {
        Some((CHUNK_JSON, text)) => {
            let binary = chunks.iter().skip(1).find(|(kind, _)| *kind == CHUNK_BIN);
            Ok((&bytes[text.clone()], binary.map(|(_, range)| range.clone())))
        }
        _ => Err(invalid("the .glb does not start with a JSON chunk".to_owned())),
    }
}

/// Returns type and data range of every chunk of a .glb.
fn chunks(bytes: &[u8]) -> Result<Vec<(u32, Range<usize>)>, String> {
    let mut found = Vec::new();
    let mut at = 12;
    while at < bytes.len() {
        let (Some(length), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(format!("the .glb ends inside the header of the chunk at byte {at}"));
        };
        let start = at + 8;
        let end = start.saturating_add(length as usize);
        if end > bytes.len() {
            let length = pluralised(length, "byte", "bytes");
            return Err(format!("the chunk at byte {at} of the .glb has {length}, more than the file"));
        }
        found.push((kind, start..end));
        // Chunks start at multiples of four; missing padding at the end is tolerated.
        at = end.next_multiple_of(4);
    }
    Ok(found)
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn unsupported_version(path: &Path, version: &str) -> SceneError {
    SceneError::Unsupported {
        path: path.to_owned(),
        what: format!("glTF version {version}"),
        hint: "export the scene as glTF 2.0".to_owned(),
    }
}

fn check_version(path: &Path, value: &Value) -> Result<(), SceneError> {
    let asset = &value["asset"];
    let needed = asset["minVersion"].as_str().or_else(|| asset["version"].as_str());
    match needed {
        None => Err(SceneError::Invalid { path: path.to_owned(), what: "`asset.version` is missing".to_owned() }),
        Some(version) if version == "2" || version.starts_with("2.0") => Ok(()),
        // A later minor version without `minVersion` promises to be readable by a 2.0 reader.
        Some(version) if version.starts_with("2.") && asset["minVersion"].is_null() => Ok(()),
        Some(version) => Err(unsupported_version(path, version)),
    }
}

fn check_extensions(path: &Path, value: &Value, warnings: &mut Vec<String>) -> Result<(), SceneError> {
    let is_unknown = |name: &&str| !SUPPORTED.contains(name);
    let required: Vec<&str> = names(&value["extensionsRequired"]).into_iter().filter(is_unknown).collect();
    if let Some(name) = required.iter().find(|name| !approximate::only_changes_shading(name)) {
        return Err(SceneError::Unsupported {
            path: path.to_owned(),
            what: format!("the glTF extension {name}"),
            hint: hint(name).to_owned(),
        });
    }
    let used = names(&value["extensionsUsed"]).into_iter().filter(is_unknown);
    let (mut approximated, ignored): (Vec<&str>, Vec<&str>) =
        used.chain(required).partition(|name| approximate::only_changes_shading(name));
    for name in ignored {
        warnings.push(format!("the optional glTF extension {name} is not supported and is ignored"));
    }
    approximated.sort_unstable();
    approximated.dedup();
    if !approximated.is_empty() {
        let names = approximated.join(", ");
        warnings.push(format!("materials and lights are approximated: {names} is beyond what is shaded here"));
    }
    Ok(())
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Returns what to do about an unsupported extension.
fn hint(name: &str) -> &'static str {
    match name {
        "KHR_draco_mesh_compression" => "export the scene again without Draco mesh compression",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "export the scene again without mesh compression",
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export the textures as PNG or JPEG"
        }
        "KHR_animation_pointer" => "bake the animation to nodes before exporting",
        _ => "export the scene again without it",
    }
}

/// Removes `extras` and the bodies of unsupported extensions, whose contents are arbitrary.
fn strip_foreign(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.remove("extras");
            if let Some(Value::Object(extensions)) = map.get_mut("extensions") {
                extensions.retain(|name, _| SUPPORTED.contains(&name.as_str()));
            }
            map.values_mut().for_each(strip_foreign);
        }
        Value::Array(list) => list.iter_mut().for_each(strip_foreign),
        _ => {}
    }
}

/// Repairs what the typed reader rejects although the format allows it (or it can be safely ignored).
fn mend(value: &mut Value, warnings: &mut Vec<String>) {
    for scene in elements(value, "scenes") {
        default_list(scene, "nodes");
    }
    for (index, clip) in elements(value, "animations").enumerate() {
        default_list(clip, "channels");
        default_list(clip, "samplers");
        if let Some(channels) = clip.get_mut("channels").and_then(Value::as_array_mut) {
            drop_foreign_channels(index, channels, warnings);
        }
    }
}

fn elements<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    value.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

fn default_list(value: &mut Value, key: &str) {
    if let Some(map) = value.as_object_mut() {
        map.entry(key).or_insert_with(|| Value::Array(Vec::new()));
    }
}

/// Removes channels that animate anything but the four properties of a node (KHR_animation_pointer, unknown targets).
fn drop_foreign_channels(clip: usize, channels: &mut Vec<Value>, warnings: &mut Vec<String>) {
    let before = channels.len();
    channels.retain(|channel| {
        let target = &channel["target"];
        let is_known = matches!(target["path"].as_str(), Some("translation" | "rotation" | "scale" | "weights"));
        is_known && !target["node"].is_null()
    });
    let dropped = before - channels.len();
    if dropped > 0 {
        warnings.push(format!(
            "animations[{clip}]: {dropped} of {} ignored, since what moves has to be a node's translation, rotation, \
             scale or weights",
            pluralised(before, "channel", "channels")
        ));
    }
}

/// Returns the name of the element at which typed reading failed, as far as it can be found.
fn locate(value: &Value, error: &json::Error) -> String {
    fn first_bad<T: serde::de::DeserializeOwned>(value: &Value, key: &str) -> Option<String> {
        let list = value.get(key)?.as_array()?;
        list.iter().enumerate().find_map(|(index, element)| {
            let error = serde_json::from_value::<T>(element.clone()).err()?;
            Some(format!("{key}[{index}]: {error}"))
        })
    }
    first_bad::<json::Accessor>(value, "accessors")
        .or_else(|| first_bad::<json::buffer::View>(value, "bufferViews"))
        .or_else(|| first_bad::<json::Buffer>(value, "buffers"))
        .or_else(|| first_bad::<json::Mesh>(value, "meshes"))
        .or_else(|| first_bad::<json::Node>(value, "nodes"))
        .or_else(|| first_bad::<json::Scene>(value, "scenes"))
        .or_else(|| first_bad::<json::Skin>(value, "skins"))
        .or_else(|| first_bad::<json::Animation>(value, "animations"))
        .or_else(|| first_bad::<json::Material>(value, "materials"))
        .or_else(|| first_bad::<json::Texture>(value, "textures"))
        .or_else(|| first_bad::<json::Image>(value, "images"))
        .or_else(|| first_bad::<json::Camera>(value, "cameras"))
        .unwrap_or_else(|| error.to_string())
}
