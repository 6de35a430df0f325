//! Writes small glTF files for the tests.

use pinwarp::scene::{Scene, SceneError, load};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Component types of accessors by their numbers in the format.
pub(crate) const I8: u32 = 5120;
pub(crate) const U8: u32 = 5121;
pub(crate) const I16: u32 = 5122;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A glTF file in the making: one node with one mesh of one primitive, and one buffer.
pub(crate) struct Doc {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Doc {
    /// A node without a mesh.
    pub(crate) fn empty() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "name": "Thing" }],
            "bufferViews": [], "accessors": [],
        });
        Self { json, bytes: Vec::new() }
    }

    /// A mesh "Shape" of the given points.
    pub(crate) fn points(points: &[[f32; 3]]) -> Self {
        let mut doc = Self::empty();
        let position = doc.floats("VEC3", points.as_flattened());
        doc.json["nodes"][0]["mesh"] = json!(0);
        doc.json["meshes"] = json!([{ "name": "Shape", "primitives": [{ "attributes": { "POSITION": position } }] }]);
        doc
    }

    /// A right triangle in the xy plane.
    pub(crate) fn triangle() -> Self {
        Self::points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }

    /// A unit square of four vertices and the corners of two triangles.
    pub(crate) fn square() -> Self {
        let mut doc = Self::points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        let indices = doc.accessor(&[0, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
        doc.primitive()["indices"] = json!(indices);
        doc.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(4));
        doc
    }

    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Adds bytes as a buffer view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len().next_multiple_of(4);
        self.bytes.resize(offset, 0);
        self.bytes.extend_from_slice(bytes);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    /// Adds an element to a list of the JSON and returns its number.
    pub(crate) fn push(&mut self, list: &str, element: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().unwrap();
        list.push(element);
        list.len() - 1
    }

    /// Adds an accessor over its own view.
    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    /// Adds an accessor of normalised integers.
    pub(crate) fn normalized(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let accessor = self.accessor(bytes, component, kind, count);
        self.json["accessors"][accessor]["normalized"] = json!(true);
        accessor
    }

    /// Adds an accessor of floats.
    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(&le(values), F32, kind, values.len() / width)
    }

    /// Adds an attribute of floats to the primitive.
    pub(crate) fn attribute(&mut self, name: &str, kind: &str, values: &[f32]) {
        let accessor = self.floats(kind, values);
        self.primitive()["attributes"][name] = json!(accessor);
    }

    /// Adds a clip that moves one property of one node.
    pub(crate) fn clip(&mut self, node: usize, path: &str, interpolation: &str, keys: (&[f32], &str, &[f32])) {
        let input = self.floats("SCALAR", keys.0);
        let output = self.floats(keys.1, keys.2);
        self.push(
            "animations",
            json!({
                "channels": [{ "sampler": 0, "target": { "node": node, "path": path } }],
                "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            }),
        );
    }

    /// The JSON with its buffer as a data URI.
    pub(crate) fn with_data_uri(&self) -> Value {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        }
        json
    }

    /// The file as .glb.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let length = 12 + 8 + text.len() + 8 + binary.len();
        let mut out = b"glTF".to_vec();
        out.extend([2, length as u32, text.len() as u32].iter().flat_map(|word| word.to_le_bytes()));
        out.extend(b"JSON");
        out.extend(text);
        out.extend((binary.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(binary);
        out
    }

    /// Loads the file with its buffer inside.
    pub(crate) fn load(&self) -> Result<Scene, SceneError> {
        load_bytes(self.with_data_uri().to_string().as_bytes())
    }

    /// Loads a file that must be good.
    pub(crate) fn scene(&self) -> Scene {
        self.load().unwrap_or_else(|error| panic!("{error}"))
    }

    /// The message of a file that must be refused.
    pub(crate) fn fault(&self) -> String {
        match self.load() {
            Ok(_) => panic!("the file was taken"),
            Err(error) => error.to_string(),
        }
    }
}

/// Loads bytes as a file.
pub(crate) fn load_bytes(bytes: &[u8]) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    load(&write(folder.path(), "scene.gltf", bytes))
}

pub(crate) fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Floats as a file stores them.
pub(crate) fn le(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// 16-bit integers as a file stores them.
pub(crate) fn le16(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    use base64::Engine as _;
    base64::engine::general_purpose::STANDARD.encode(bytes)
}
