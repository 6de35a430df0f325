//! Tiny glTF scenes that tests write themselves: flat unlit parts, so that every pixel can be told in advance.
//!
//! In: parts and a camera. Out: glTF as JSON (data-URI buffers), which a test may damage before it is written.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Triangles of one colour on a node of their own.
#[derive(Clone)]
pub(crate) struct Part {
    /// Of node and mesh.
    pub(crate) name: &'static str,
    /// Metres.
    pub(crate) positions: Vec<[f32; 3]>,
    /// Counter-clockwise.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Linear, unlit.
    pub(crate) color: [f32; 3],
    /// Of the node.
    pub(crate) place: [f32; 3],
    /// Metres a second, from time 0 on for 100 s.
    pub(crate) velocity: [f32; 3],
}

/// How the camera at [0, 0, 5] sees, looking along -z.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lens {
    /// One metre is one frame height.
    Parallel,
    /// Vertical field of view, radians.
    Perspective(f32),
}

/// A scene of parts and one camera.
#[derive(Clone)]
pub(crate) struct Tiny {
    pub(crate) parts: Vec<Part>,
    pub(crate) lens: Lens,
    pub(crate) camera_velocity: [f32; 3],
}

/// A rectangle facing the camera, cut into `cells` x `cells` pairs of triangles.
pub(crate) fn grid(name: &'static str, [x0, y0, x1, y1]: [f32; 4], cells: u32) -> Part {
    let side = cells + 1;
    let at = |low: f32, high: f32, k: u32| low + (high - low) * k as f32 / cells as f32;
    let positions = (0..side * side).map(|k| [at(x0, x1, k % side), at(y0, y1, k / side), 0.0]).collect();
    let cell = |k: u32| {
        let corner = k % cells + k / cells * side;
        [[corner, corner + 1, corner + side + 1], [corner, corner + side + 1, corner + side]]
    };
    let triangles = (0..cells * cells).flat_map(cell).collect();
    Part { name, positions, triangles, color: [0.5, 0.25, 0.125], place: [0.0; 3], velocity: [0.0; 3] }
}

impl Tiny {
    pub(crate) fn of(parts: Vec<Part>) -> Self {
        Self { parts, lens: Lens::Parallel, camera_velocity: [0.0; 3] }
    }

    /// The scene as JSON. Accessors 2k and 2k + 1 are positions and indices of part k; its buffer is k.
    pub(crate) fn json(&self) -> Value {
        let mut scene = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": (0..=self.parts.len()).collect::<Vec<_>>() }],
            "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": [], "buffers": [],
            "cameras": [self.camera()],
            "extensionsUsed": ["KHR_materials_unlit"],
        });
        self.parts.iter().enumerate().for_each(|(index, part)| add_part(&mut scene, index, part));
        let camera = json!({ "name": "Cam", "camera": 0, "translation": [0.0, 0.0, 5.0] });
        push(&mut scene, "nodes", camera);
        self.add_clip(&mut scene);
        scene
    }

    fn camera(&self) -> Value {
        match self.lens {
            Lens::Parallel => json!({ "type": "orthographic",
                "orthographic": { "xmag": 0.5, "ymag": 0.5, "znear": 0.5, "zfar": 100.0 } }),
            Lens::Perspective(yfov) => {
                json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": 0.5, "zfar": 100.0 } })
            }
        }
    }

    /// A clip for everything that moves: two keys, 100 s apart.
    fn add_clip(&self, scene: &mut Value) {
        let camera = (self.parts.len(), [0.0, 0.0, 5.0], self.camera_velocity);
        let parts = self.parts.iter().enumerate().map(|(node, part)| (node, part.place, part.velocity));
        let moving: Vec<_> = parts.chain([camera]).filter(|(_, _, velocity)| *velocity != [0.0; 3]).collect();
        if moving.is_empty() {
            return;
        }
        let mut clip = json!({ "name": "Move", "channels": [], "samplers": [] });
        for (node, place, velocity) in moving {
            let end: Vec<f32> = (0..3).map(|axis| place[axis] + 100.0 * velocity[axis]).collect();
            let numbers: Vec<f32> = [0.0, 100.0].into_iter().chain(place).chain(end).collect();
            let (buffer, bytes) = (count(scene, "buffers"), bytemuck::cast_slice(&numbers));
            add_buffer(scene, bytes);
            let input = count(scene, "accessors");
            push(scene, "bufferViews", json!({ "buffer": buffer, "byteLength": bytes.len() }));
            let view = count(scene, "bufferViews") - 1;
            push(
                scene,
                "accessors",
                json!({ "bufferView": view, "componentType": 5126, "count": 2,
                "type": "SCALAR", "min": [0.0], "max": [100.0] }),
            );
            push(
                scene,
                "accessors",
                json!({ "bufferView": view, "byteOffset": 8, "componentType": 5126, "count": 2,
                "type": "VEC3" }),
            );
            let sampler = count(&clip, "samplers");
            push(&mut clip, "samplers", json!({ "input": input, "output": input + 1 }));
            let channel = json!({ "sampler": sampler, "target": { "node": node, "path": "translation" } });
            push(&mut clip, "channels", channel);
        }
        scene["animations"] = json!([clip]);
    }
}

fn add_part(scene: &mut Value, index: usize, part: &Part) {
    let positions: &[u8] = bytemuck::cast_slice(&part.positions);
    let indices: &[u8] = bytemuck::cast_slice(&part.triangles);
    add_buffer(scene, &[positions, indices].concat());
    push(scene, "bufferViews", json!({ "buffer": index, "byteLength": positions.len() }));
    let view = json!({ "buffer": index, "byteOffset": positions.len(), "byteLength": indices.len() });
    push(scene, "bufferViews", view);
    let axis = |axis: usize| part.positions.iter().map(move |point| point[axis]);
    let least: Vec<f32> = (0..3).map(|k| axis(k).fold(f32::INFINITY, f32::min)).collect();
    let most: Vec<f32> = (0..3).map(|k| axis(k).fold(f32::NEG_INFINITY, f32::max)).collect();
    push(
        scene,
        "accessors",
        json!({ "bufferView": 2 * index, "componentType": 5126,
        "count": part.positions.len(), "type": "VEC3", "min": least, "max": most }),
    );
    push(
        scene,
        "accessors",
        json!({ "bufferView": 2 * index + 1, "componentType": 5125,
        "count": 3 * part.triangles.len(), "type": "SCALAR" }),
    );
    let [r, g, b] = part.color;
    push(
        scene,
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorFactor": [r, g, b, 1.0] },
        "extensions": { "KHR_materials_unlit": {} } }),
    );
    push(
        scene,
        "meshes",
        json!({ "name": part.name, "primitives": [
        { "attributes": { "POSITION": 2 * index }, "indices": 2 * index + 1, "material": index }] }),
    );
    push(scene, "nodes", json!({ "name": part.name, "mesh": index, "translation": part.place }));
}

fn add_buffer(scene: &mut Value, bytes: &[u8]) {
    let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
    push(scene, "buffers", json!({ "byteLength": bytes.len(), "uri": uri }));
}

fn push(scene: &mut Value, list: &str, item: Value) {
    scene[list].as_array_mut().expect("a list of the scene").push(item);
}

fn count(scene: &Value, list: &str) -> usize {
    scene[list].as_array().map_or(0, Vec::len)
}
