//! A skinned model of a million vertices: a bumpy ball that two joints bend to and fro.
//!
//! In: the number of rings and of vertices on each. Out: a binary glTF file with one mesh, a skin, a clip of a second and a
//! camera.

use serde_json::{Value, json};
use std::f32::consts::{PI, TAU};

/// The parts of the buffer.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends values and declares them; returns the index of their accessor.
    fn add(&mut self, bytes: &[u8], mut accessor: Value) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        accessor["bufferView"] = (self.views.len() - 1).into();
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], (kind, count): (&str, usize)) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.add(&bytes, json!({ "componentType": 5126, "count": count, "type": kind }))
    }
}

/// A point of the ball and its direction from the centre.
fn point(down: f32, around: f32) -> ([f32; 3], [f32; 3]) {
    let way = [down.sin() * around.cos(), down.cos(), down.sin() * around.sin()];
    let radius = 1.0 + 0.05 * (9.0 * down).sin() * (7.0 * around).cos();
    (way.map(|x| x * radius), way)
}

/// Writes the model.
pub(crate) fn ball(rings: u32, around: u32) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let places = || (0..rings).flat_map(move |ring| (0..around).map(move |step| (ring, step)));
    let at =
        |(ring, step): (u32, u32)| point(PI * (ring as f32 + 0.5) / rings as f32, TAU * step as f32 / around as f32);
    let count = (rings * around) as usize;
    let positions: Vec<f32> = places().flat_map(|place| at(place).0).collect();
    let normals: Vec<f32> = places().flat_map(|place| at(place).1).collect();
    // The upper joint moves the upper half.
    let share = |place: (u32, u32)| ((at(place).0[1] + 0.5).clamp(0.0, 1.0) * 255.0) as u8;
    let weights: Vec<u8> = places().flat_map(|place| [255 - share(place), share(place), 0, 0]).collect();
    let joints: Vec<u8> = (0..count).flat_map(|_| [0, 1, 0, 0]).collect();
    let quad = |(ring, step): (u32, u32)| {
        let corner = |down: u32, right: u32| (ring + down) * around + (step + right) % around;
        let [a, b, c, d] = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
        [a, b, c, a, c, d]
    };
    let corners: Vec<u32> = places().filter(|(ring, _)| ring + 1 < rings).flat_map(quad).collect();
    let indices: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
    let position = buffer.floats(&positions, ("VEC3", count));
    buffer.accessors[position]["min"] = json!([-1.05, -1.05, -1.05]);
    buffer.accessors[position]["max"] = json!([1.05, 1.05, 1.05]);
    let normal = buffer.floats(&normals, ("VEC3", count));
    let bytes =
        |normalized: bool| json!({ "componentType": 5121, "count": count, "type": "VEC4", "normalized": normalized });
    let weights = buffer.add(&weights, bytes(true));
    let joints = buffer.add(&joints, bytes(false));
    let indices = buffer.add(&indices, json!({ "componentType": 5125, "count": corners.len(), "type": "SCALAR" }));
    let times = buffer.floats(&[0.0, 0.5, 1.0], ("SCALAR", 3));
    buffer.accessors[times]["min"] = json!([0.0]);
    buffer.accessors[times]["max"] = json!([1.0]);
    let bent = |angle: f32| [0.0, 0.0, (0.5 * angle).sin(), (0.5 * angle).cos()];
    let turns = buffer.floats(&[bent(-0.3), bent(0.3), bent(-0.3)].concat(), ("VEC4", 3));
    let attributes = json!({ "POSITION": position, "NORMAL": normal, "WEIGHTS_0": weights, "JOINTS_0": joints });
    let scene = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0, 1, 3] }],
        "nodes": [
            { "name": "Ball", "mesh": 0, "skin": 0 },
            { "name": "Lower", "children": [2] },
            { "name": "Upper" },
            { "name": "Camera", "camera": 0, "translation": [0.0, 0.0, 4.0] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "zfar": 100.0 } }],
        "meshes": [{ "name": "Ball", "primitives": [{ "attributes": attributes, "indices": indices }] }],
        "skins": [{ "joints": [1, 2] }],
        "animations": [{
            "name": "Sway",
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }],
            "samplers": [{ "input": times, "output": turns }],
        }],
        "buffers": [{ "byteLength": buffer.bytes.len() }],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    });
    binary(&scene, &buffer.bytes)
}

/// Joins JSON and buffer to a binary glTF file.
fn binary(scene: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut text = scene.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let chunks = [chunk(b"JSON", &text), chunk(b"BIN\0", buffer)].concat();
    [&b"glTF"[..], &2_u32.to_le_bytes(), &(12 + chunks.len() as u32).to_le_bytes(), &chunks].concat()
}
