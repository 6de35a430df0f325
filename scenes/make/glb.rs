//! A small writer of glTF 2.0 binary files; it supports the part of the format that the scenes need.
//!
//! In: surfaces, nodes, materials, clips in f64. Out: the bytes of a .glb. All numbers are rounded to a millionth
//! before they become f32, so that the file does not depend on the platform's sine.

use glam::{DMat4, DVec2, DVec3};
use serde_json::{Value, json};

/// Triangles of one material, in the space of their node. Empty arrays are omitted from the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surface {
    /// #vertices, metres.
    pub(crate) positions: Vec<DVec3>,
    /// #vertices, unit length.
    pub(crate) normals: Vec<DVec3>,
    /// #vertices or empty.
    pub(crate) uvs: Vec<DVec2>,
    /// Linear RGB, #vertices or empty.
    pub(crate) colors: Vec<DVec3>,
    /// Four joints per vertex with their weights, #vertices or empty.
    pub(crate) joint_weights: Vec<[(u8, f64); 4]>,
    /// Corners, counter-clockwise from the front.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Index of the material.
    pub(crate) material: usize,
}

/// An animation of one property of one node.
pub(crate) struct Track {
    /// Index of the node.
    pub(crate) node: usize,
    /// `translation`, `rotation` or `scale`.
    pub(crate) path: &'static str,
    /// Times of the keys in seconds.
    pub(crate) times: Vec<f64>,
    /// Three or four numbers per key, consecutively.
    pub(crate) values: Vec<f64>,
}

/// A glTF file under construction.
#[derive(Default)]
pub(crate) struct Glb {
    accessors: Vec<Value>,
    views: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    roots: Vec<usize>,
    materials: Vec<Value>,
    images: Vec<Value>,
    cameras: Vec<Value>,
    lights: Vec<Value>,
    skins: Vec<Value>,
    clips: Vec<Value>,
    bin: Vec<u8>,
}

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const VERTEX_BUFFER: u32 = 34962;
const INDEX_BUFFER: u32 = 34963;

/// A number rounded as in the file.
pub(crate) fn rounded(value: f64) -> f32 {
    // Adding zero turns -0 into 0.
    ((value * 1e6).round() / 1e6 + 0.0) as f32
}

/// Numbers of a JSON array, rounded as in the binary part.
pub(crate) fn numbers(values: &[f64]) -> Value {
    values.iter().map(|value| json!((value * 1e6).round() / 1e6 + 0.0)).collect()
}

/// Weights as bytes with the sum 255; the first weight, which is the largest, absorbs the rounding error.
fn byte_shares(row: &[(u8, f64); 4]) -> [u8; 4] {
    let mut bytes = row.map(|(_, share)| (share * 255.0).round() as u8);
    bytes[0] = 255 - bytes[1..].iter().sum::<u8>();
    bytes
}

impl Glb {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bin.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds an accessor of floats with `width` numbers per element.
    fn floats(&mut self, rows: &[f64], width: usize, target: Option<u32>) -> usize {
        let data: Vec<f32> = rows.iter().copied().map(rounded).collect();
        let view = self.view(bytemuck::cast_slice(&data), target);
        let column = |at: usize| data.iter().skip(at).step_by(width).copied();
        let least: Vec<f32> = (0..width).map(|at| column(at).fold(f32::INFINITY, f32::min)).collect();
        let most: Vec<f32> = (0..width).map(|at| column(at).fold(f32::NEG_INFINITY, f32::max)).collect();
        let kind = match width {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        self.accessor(json!({
            "bufferView": view, "componentType": FLOAT, "count": data.len() / width, "type": kind,
            "min": least, "max": most,
        }))
    }

    fn bytes4(&mut self, rows: &[[u8; 4]], normalized: bool) -> usize {
        let view = self.view(bytemuck::cast_slice(rows), Some(VERTEX_BUFFER));
        self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_BYTE, "count": rows.len(), "type": "VEC4",
            "normalized": normalized,
        }))
    }

    fn primitive(&mut self, surface: &Surface) -> Value {
        let vertices = Some(VERTEX_BUFFER);
        let flat3 = |rows: &[DVec3]| rows.iter().flat_map(|row| row.to_array()).collect::<Vec<_>>();
        let mut attributes = json!({ "POSITION": self.floats(&flat3(&surface.positions), 3, vertices) });
        if !surface.normals.is_empty() {
            attributes["NORMAL"] = json!(self.floats(&flat3(&surface.normals), 3, vertices));
        }
        if !surface.uvs.is_empty() {
            let rows: Vec<f64> = surface.uvs.iter().flat_map(|row| row.to_array()).collect();
            attributes["TEXCOORD_0"] = json!(self.floats(&rows, 2, vertices));
        }
        if !surface.colors.is_empty() {
            attributes["COLOR_0"] = json!(self.floats(&flat3(&surface.colors), 3, vertices));
        }
        if !surface.joint_weights.is_empty() {
            let joints: Vec<[u8; 4]> = surface.joint_weights.iter().map(|row| row.map(|(joint, _)| joint)).collect();
            let shares: Vec<[u8; 4]> = surface.joint_weights.iter().map(byte_shares).collect();
            attributes["JOINTS_0"] = json!(self.bytes4(&joints, false));
            attributes["WEIGHTS_0"] = json!(self.bytes4(&shares, true));
        }
        let corners: Vec<u16> = surface.triangles.iter().flatten().map(|corner| *corner as u16).collect();
        let view = self.view(bytemuck::cast_slice(&corners), Some(INDEX_BUFFER));
        let indices = self.accessor(json!({
            "bufferView": view, "componentType": UNSIGNED_SHORT, "count": corners.len(), "type": "SCALAR",
        }));
        json!({ "attributes": attributes, "indices": indices, "material": surface.material })
    }

    /// Adds a mesh with one primitive per surface; returns its index.
    pub(crate) fn mesh(&mut self, name: &str, surfaces: &[Surface]) -> usize {
        let primitives: Vec<Value> = surfaces.iter().map(|surface| self.primitive(surface)).collect();
        self.meshes.push(json!({ "name": name, "primitives": primitives }));
        self.meshes.len() - 1
    }

    /// Adds a material given as glTF JSON; returns its index.
    pub(crate) fn material(&mut self, material: Value) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// Embeds a PNG file; returns the index of a texture that shows it (linear filter, mipmaps, clamped to the edge).
    pub(crate) fn texture(&mut self, name: &str, png: &[u8]) -> usize {
        let view = self.view(png, None);
        self.images.push(json!({ "name": name, "bufferView": view, "mimeType": "image/png" }));
        self.images.len() - 1
    }

    /// Adds a node given as glTF JSON; returns its index. It is a root until [`Self::child`] moves it.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.roots.push(self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// Adds a node below another; returns its index.
    pub(crate) fn child(&mut self, parent: usize, node: Value) -> usize {
        self.nodes.push(node);
        let index = self.nodes.len() - 1;
        match self.nodes[parent]["children"].as_array_mut() {
            Some(children) => children.push(json!(index)),
            None => self.nodes[parent]["children"] = json!([index]),
        }
        index
    }

    /// Adds a camera given as glTF JSON; returns its index.
    pub(crate) fn camera(&mut self, camera: Value) -> usize {
        self.cameras.push(camera);
        self.cameras.len() - 1
    }

    /// Adds a light and the node that aims it along `direction`.
    pub(crate) fn light(&mut self, name: &str, direction: DVec3, light: Value) {
        self.lights.push(light);
        let mut node = placed(DVec3::ZERO, direction);
        node["name"] = json!(name);
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": self.lights.len() - 1 } });
        self.node(node);
    }

    /// Adds a skin: joint nodes and their inverse bind matrices.
    pub(crate) fn skin(&mut self, joints: &[usize], joint_from_mesh: &[DMat4]) -> usize {
        let rows: Vec<f64> = joint_from_mesh.iter().flat_map(|matrix| matrix.to_cols_array()).collect();
        let matrices = self.floats(&rows, 16, None);
        self.skins.push(json!({ "joints": joints, "inverseBindMatrices": matrices }));
        self.skins.len() - 1
    }

    /// Adds a clip whose tracks are interpolated linearly.
    pub(crate) fn clip(&mut self, name: &str, tracks: &[Track]) {
        let mut samplers = Vec::new();
        let mut channels = Vec::new();
        for (sampler, track) in tracks.iter().enumerate() {
            let width = track.values.len() / track.times.len();
            let input = self.floats(&track.times, 1, None);
            let output = self.floats(&track.values, width, None);
            samplers.push(json!({ "input": input, "output": output, "interpolation": "LINEAR" }));
            channels.push(json!({ "sampler": sampler, "target": { "node": track.node, "path": track.path } }));
        }
        self.clips.push(json!({ "name": name, "samplers": samplers, "channels": channels }));
    }

    /// The complete file. `copyright` goes into its `asset` object.
    pub(crate) fn bytes(mut self, copyright: &str) -> Vec<u8> {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let mut text = self.document(copyright).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bin.len();
        let mut file = Vec::with_capacity(length);
        let word = |file: &mut Vec<u8>, value: usize| file.extend_from_slice(&(value as u32).to_le_bytes());
        file.extend_from_slice(b"glTF");
        word(&mut file, 2);
        word(&mut file, length);
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bin)] {
            word(&mut file, chunk.len());
            file.extend_from_slice(kind);
            file.extend_from_slice(chunk);
        }
        file
    }

    fn document(&self, copyright: &str) -> Value {
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "pinwarp make_scenes", "copyright": copyright },
            "scene": 0,
            "scenes": [{ "nodes": self.roots }],
            "nodes": self.nodes,
            "buffers": [{ "byteLength": self.bin.len() }],
            "bufferViews": self.views,
        });
        let textures: Vec<Value> =
            (0..self.images.len()).map(|image| json!({ "source": image, "sampler": 0 })).collect();
        let sampler = json!({ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 });
        let samplers = if textures.is_empty() { Vec::new() } else { vec![sampler] };
        let lists = [
            ("accessors", &self.accessors),
            ("meshes", &self.meshes),
            ("materials", &self.materials),
            ("images", &self.images),
            ("textures", &textures),
            ("samplers", &samplers),
            ("cameras", &self.cameras),
            ("skins", &self.skins),
            ("animations", &self.clips),
        ];
        // glTF forbids empty arrays.
        for (key, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
            document[key] = json!(list);
        }
        let mut used = Vec::new();
        if self.materials.iter().any(|material| material["extensions"]["KHR_materials_unlit"].is_object()) {
            used.push("KHR_materials_unlit");
        }
        if !self.lights.is_empty() {
            used.push("KHR_lights_punctual");
            document["extensions"] = json!({ "KHR_lights_punctual": { "lights": self.lights } });
        }
        if !used.is_empty() {
            document["extensionsUsed"] = json!(used);
        }
        document
    }
}

/// Translation and rotation of a node at `eye` that looks (or shines) along `direction`, with its top upwards.
pub(crate) fn placed(eye: DVec3, direction: DVec3) -> Value {
    json!({ "translation": numbers(&eye.to_array()), "rotation": numbers(&looking(direction).to_array()) })
}

/// The rotation from −z to `direction`, y upwards.
pub(crate) fn looking(direction: DVec3) -> glam::DQuat {
    let back = -direction.normalize();
    let right = DVec3::Y.cross(back).normalize();
    glam::DQuat::from_mat3(&glam::DMat3::from_cols(right, back.cross(right), back))
}
