//! Normal maps: bumps point up in the image, with stored tangents and without, mirrored, skinned and morphed; on the CPU
//! and on Vulkan.

use super::support::{Studio, at};
use crate::internal::skip::skip;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Vec3, Vec4};
use pinwarp::image::{Frame, read_exr};
use pinwarp::raster::DeviceChoice;
use pinwarp::raster::vulkan::VulkanRaster;
use serde_json::{Value, json};
use std::io::Cursor;

/// A normal map that leans right and up in its image.
const LEAN: [f32; 3] = [0.5, 0.5, std::f32::consts::FRAC_1_SQRT_2];

/// Two squares side by side that share the vertices at x = 0; u runs away from there on both sides: mirrored UVs.
struct Mirror {
    json: Value,
    bytes: Vec<u8>,
}

impl Mirror {
    fn new() -> Self {
        let texel = LEAN.map(|axis| ((0.5 * axis + 0.5) * 255.0).round() as u8);
        let mut png = Cursor::new(Vec::new());
        image::RgbImage::from_pixel(1, 1, image::Rgb(texel)).write_to(&mut png, image::ImageFormat::Png).unwrap();
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1] }],
            "nodes": [{ "name": "Quad", "mesh": 0 }, { "name": "Cam", "camera": 0, "translation": [0, 0, 5] }],
            "cameras": [{ "type": "orthographic", "orthographic": { "xmag": 0.5, "ymag": 0.5, "znear": 0.5, "zfar": 9 } }],
            "images": [{ "uri": format!("data:image/png;base64,{}", STANDARD.encode(png.into_inner())) }],
            "textures": [{ "source": 0 }], "materials": [{ "normalTexture": { "index": 0 } }],
            "bufferViews": [], "accessors": [],
            "meshes": [{ "primitives": [{ "attributes": {}, "material": 0 }] }],
        });
        let mut mirror = Self { json, bytes: Vec::new() };
        let columns = [-0.4f32, 0.0, 0.4];
        let each = |of: fn(f32, f32) -> Vec<f32>| -> Vec<f32> {
            [-0.4f32, 0.4].iter().flat_map(|y| columns.iter().flat_map(move |x| of(*x, *y))).collect()
        };
        mirror.attribute("POSITION", "VEC3", &each(|x, y| vec![x, y, 0.0]));
        mirror.attribute("NORMAL", "VEC3", &each(|_, _| vec![0.0, 0.0, 1.0]));
        // v grows downwards in the image.
        mirror.attribute("TEXCOORD_0", "VEC2", &each(|x, y| vec![x.abs(), 0.5 - y]));
        let corners: [u8; 12] = [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4];
        let indices = mirror.accessor(&corners, 5121, "SCALAR", 12);
        mirror.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        mirror
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }));
        let view = views.len() - 1;
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }));
        accessors.len() - 1
    }

    fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = kind.strip_prefix("VEC").map_or(1, |width| width.parse().unwrap());
        self.accessor(bytemuck::cast_slice(values), 5126, kind, values.len() / width)
    }

    fn attribute(&mut self, name: &str, kind: &str, values: &[f32]) {
        let accessor = self.floats(kind, values);
        self.json["meshes"][0]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    /// Removes the right half, whose UVs are upright.
    fn halved(mut self) -> Self {
        let indices = self.accessor(&[1, 2, 5, 1, 5, 4], 5121, "SCALAR", 6);
        self.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        self
    }

    fn studio(&self) -> Studio {
        let mut json = self.json.clone();
        let uri = format!("data:;base64,{}", STANDARD.encode(&self.bytes));
        json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        Studio::of_json(&json, "[output]\nchannels = [\"beauty\", \"normal\", \"id\"]\n")
    }

    /// The frame by the CPU and, where there is one, by a Vulkan device.
    fn frames(&self) -> Vec<Frame> {
        let studio = self.studio();
        let mut frames = vec![studio.frame(1)];
        if VulkanRaster::open(&DeviceChoice::Vulkan, &studio.prepared().scene).is_ok() {
            let open = |prepared: &pinwarp::pipeline::PreparedShot| {
                VulkanRaster::open(&DeviceChoice::Vulkan, &prepared.scene).unwrap()
            };
            let (files, _device) = studio.files_by(&[1], open);
            frames.push(read_exr(&files[0]).unwrap());
        } else {
            assert!(std::env::var_os("PINWARP_REQUIRE_VULKAN").is_none(), "no Vulkan device");
            skip("no Vulkan device");
        }
        frames
    }
}

fn normal(frame: &Frame, x: i32, y: i32) -> Vec3 {
    Vec3::new(at(frame, "N.X", x, y), at(frame, "N.Y", x, y), at(frame, "N.Z", x, y))
}

/// The normal at two pixels of each half, one of them beside the seam at column 32.
fn check_halves(frame: &Frame, left: Vec3, right: Vec3) {
    for (x, expected) in [(20, left), (31, left), (32, right), (44, right)] {
        for y in [10, 19, 20, 30] {
            let found = normal(frame, x, y);
            assert!((found - expected).length() < 0.01, "{found} instead of {expected} at {x}, {y}");
        }
    }
}

const RIGHT: Vec3 = Vec3::from_array(LEAN);
const LEFT: Vec3 = Vec3::new(-LEAN[0], LEAN[1], LEAN[2]);

#[test]
fn bumps_lean_up_in_the_image_and_mirrored_uvs_mirror_them() {
    for frame in Mirror::new().frames() {
        check_halves(&frame, LEFT, RIGHT);
    }
}

#[test]
fn stored_tangents_give_the_same_picture_as_made_ones() {
    let made = Mirror::new().halved();
    let mut stored = Mirror::new().halved();
    stored.attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(6));
    for (made, stored) in made.frames().iter().zip(stored.frames()) {
        for channel in ["R", "G", "B", "N.X", "N.Y", "N.Z"] {
            let [made, stored] = [made, &stored].map(|frame| &frame.channel(channel).unwrap().samples);
            assert!(made.iter().zip(stored).all(|(a, b)| (a - b).abs() < 1e-6), "{channel}");
        }
        assert!((normal(made, 44, 20) - RIGHT).length() < 0.01);
    }
    // The comparison can fail: the other handedness is another picture.
    stored.attribute("TANGENT", "VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(6));
    assert!((normal(&stored.frames()[0], 44, 20) - RIGHT).length() > 0.5);
}

#[test]
fn skinned_and_morphed_meshes_turn_their_bumps_along() {
    let quarter = glam::Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let mut skinned = Mirror::new();
    let joints = skinned.accessor(&[0; 24], 5121, "VEC4", 6);
    skinned.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
    skinned.attribute("WEIGHTS_0", "VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(6));
    skinned.json["skins"] = json!([{ "joints": [2] }]);
    skinned.json["nodes"][0]["skin"] = json!(0);
    skinned.json["nodes"].as_array_mut().unwrap().push(json!({ "name": "Bone", "rotation": quarter.to_array() }));
    skinned.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let turned = |normal: Vec3| quarter * normal;
    for frame in skinned.frames() {
        // Columns have become rows: the right half lies above.
        for (y, expected) in [(10, turned(RIGHT)), (30, turned(LEFT))] {
            let found = normal(&frame, 32, y);
            assert!((found - expected).length() < 0.01, "{found} instead of {expected}");
        }
    }

    // A target that turns the mesh a quarter: every point goes from (x, y) to (-y, x).
    let mut morphed = Mirror::new();
    let by: Vec<f32> =
        [-0.4f32, 0.4].iter().flat_map(|y| [-0.4f32, 0.0, 0.4].map(|x| [-y - x, x - y, 0.0])).flatten().collect();
    let target = morphed.floats("VEC3", &by);
    morphed.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }]);
    morphed.json["meshes"][0]["weights"] = json!([1.0]);
    for frame in morphed.frames() {
        for (y, expected) in [(10, turned(RIGHT)), (30, turned(LEFT))] {
            let found = normal(&frame, 32, y);
            assert!((found - expected).length() < 0.01, "{found} instead of {expected}");
        }
    }
}

#[test]
fn only_the_vertices_of_the_seam_are_split() {
    let prepared = Mirror::new().studio().prepared();
    let primitive = &prepared.scene.meshes[0].primitives[0];
    assert_eq!(primitive.positions.len(), 8, "six, and two of the seam once more");
    assert_eq!(primitive.triangles.len(), 4);
    for (triangle, corners) in primitive.triangles.iter().enumerate() {
        let expected = if triangle < 2 { Vec4::new(-1.0, 0.0, 0.0, -1.0) } else { Vec4::new(1.0, 0.0, 0.0, 1.0) };
        for &corner in corners {
            assert!((primitive.tangents[corner as usize] - expected).length() < 1e-6, "triangle {triangle}");
        }
    }
}
