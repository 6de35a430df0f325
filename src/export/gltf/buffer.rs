//! Adds accessors to a packed glTF file.
//!
//! In: arrays. Out: accessor indices; the arrays are appended to the file's buffer.

use crate::scene::Packed;
use bytemuck::Pod;
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// An element type of accessors.
pub(super) trait Element: Pod {
    /// Its glTF type and component type.
    const KIND: (&'static str, u32);
}

impl Element for f32 {
    const KIND: (&'static str, u32) = ("SCALAR", FLOAT);
}

impl Element for u32 {
    const KIND: (&'static str, u32) = ("SCALAR", UNSIGNED_INT);
}

impl Element for Vec2 {
    const KIND: (&'static str, u32) = ("VEC2", FLOAT);
}

impl Element for Vec3 {
    const KIND: (&'static str, u32) = ("VEC3", FLOAT);
}

impl Element for Vec4 {
    const KIND: (&'static str, u32) = ("VEC4", FLOAT);
}

/// Adds a list of elements; returns the accessor's index.
pub(super) fn add<T: Element>(packed: &mut Packed, elements: &[T]) -> usize {
    let start = packed.binary.len().next_multiple_of(4);
    packed.binary.resize(start, 0);
    let bytes: &[u8] = bytemuck::cast_slice(elements);
    packed.binary.extend_from_slice(bytes);
    let view = json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() });
    let view = push(&mut packed.json, "bufferViews", view);
    let (kind, component) = T::KIND;
    let accessor = json!({ "bufferView": view, "componentType": component, "count": elements.len(), "type": kind });
    push(&mut packed.json, "accessors", accessor)
}

/// Adds positions with the bounds that the format requires; returns the accessor's index.
pub(super) fn add_bounded<const N: usize, T: Element + Into<[f32; N]>>(packed: &mut Packed, places: &[T]) -> usize {
    let accessor = add(packed, places);
    let all = || places.iter().map(|&place| -> [f32; N] { place.into() });
    let fold = |start: f32, pick: fn(f32, f32) -> f32| -> Vec<f32> {
        (0..N).map(|axis| all().map(|place| place[axis]).fold(start, pick)).collect()
    };
    if !places.is_empty() {
        packed.json["accessors"][accessor]["min"] = json!(fold(f32::INFINITY, f32::min));
        packed.json["accessors"][accessor]["max"] = json!(fold(f32::NEG_INFINITY, f32::max));
    }
    accessor
}

/// Adds times with their bounds; returns the accessor's index.
pub(super) fn add_times(packed: &mut Packed, times: &[f32]) -> usize {
    let accessor = add(packed, times);
    if let (Some(first), Some(last)) = (times.first(), times.last()) {
        packed.json["accessors"][accessor]["min"] = json!([first]);
        packed.json["accessors"][accessor]["max"] = json!([last]);
    }
    accessor
}

/// Appends an item to a list of the file; returns its index.
pub(super) fn push(json: &mut Value, list: &str, item: Value) -> usize {
    if !json[list].is_array() {
        json[list] = json!([]);
    }
    let list = json[list].as_array_mut().expect("it was just made one");
    list.push(item);
    list.len() - 1
}
