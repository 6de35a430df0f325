//! Every way a file may store vertices.

use super::build::{Doc, F32, I8, I16, U8, U16, U32, le, le16};
use glam::{Vec2, Vec3, Vec4};
use pinwarp::scene::{Influence, Scene};
use serde_json::json;

fn primitive(scene: &Scene) -> &pinwarp::scene::Primitive {
    &scene.meshes[0].primitives[0]
}

fn close(found: f32, expected: f32) -> bool {
    (found - expected).abs() < 1e-6
}

#[test]
fn every_index_type_gives_the_same_triangles() {
    for (bytes, component) in [
        (vec![0, 1, 2, 0, 2, 3], U8),
        (le16(&[0, 1, 2, 0, 2, 3]), U16),
        ([0u32, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()).collect(), U32),
    ] {
        let mut doc = Doc::square();
        let indices = doc.accessor(&bytes, component, "SCALAR", 6);
        doc.primitive()["indices"] = json!(indices);
        assert_eq!(primitive(&doc.scene()).triangles, [[0, 1, 2], [0, 2, 3]], "component type {component}");
    }
}

#[test]
fn strips_and_fans_unroll_with_the_winding_of_the_format() {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    let mut doc = Doc::points(&points);
    doc.attribute("NORMAL", "VEC3", &[0.0, 0.0, 1.0].repeat(5));
    doc.primitive()["mode"] = json!(5);
    assert_eq!(primitive(&doc.scene()).triangles, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    doc.primitive()["mode"] = json!(6);
    assert_eq!(primitive(&doc.scene()).triangles, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
}

#[test]
fn points_leave_an_empty_primitive_and_a_warning() {
    let mut doc = Doc::square();
    doc.primitive()["mode"] = json!(0);
    let scene = doc.scene();
    assert!(!primitive(&scene).is_visible());
    let has_warning = |part: &str| scene.warnings.iter().any(|warning| warning.contains(part));
    assert!(has_warning("\"Shape\", primitive 0") && has_warning("no triangles"), "{:?}", scene.warnings);
}

#[test]
fn lines_of_every_mode_become_polylines_of_an_unlit_material() {
    for (mode, wanted) in [(2, vec![0, 1, 2, 0, 2, 3, 0]), (3, vec![0, 1, 2, 0, 2, 3])] {
        let mut doc = Doc::square();
        doc.primitive()["mode"] = json!(mode);
        let scene = doc.scene();
        let found = primitive(&scene);
        assert_eq!(found.lines, [wanted]);
        assert!(found.triangles.is_empty() && found.is_visible());
        let material = &scene.materials[found.material];
        assert!(material.unlit && material.double_sided);
        assert_eq!((found.normals.len(), &scene.warnings), (4, &Vec::new()));
    }
}

#[test]
fn segments_join_where_two_of_them_meet() {
    let mut doc = Doc::square();
    let indices = doc.accessor(&[2, 3, 0, 1, 1, 2], U8, "SCALAR", 6);
    doc.primitive()["indices"] = json!(indices);
    doc.primitive()["mode"] = json!(1);
    assert_eq!(primitive(&doc.scene()).lines, [[0, 1, 2, 3]]);
}

#[test]
fn missing_normals_become_flat_and_vertices_unshared() {
    let mut doc = Doc::points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let indices = doc.accessor(&[0, 1, 2, 0, 2, 3], U8, "SCALAR", 6);
    doc.primitive()["indices"] = json!(indices);
    doc.attribute("TEXCOORD_0", "VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.5, 0.5]);
    let scene = doc.scene();
    let found = primitive(&scene);
    assert_eq!(found.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(found.positions[5], Vec3::Z);
    assert_eq!(found.uvs[0][5], Vec2::splat(0.5));
    assert_eq!(found.normals[..3], [Vec3::Z; 3]);
    assert_eq!(found.normals[3..], [Vec3::X; 3]);
}

#[test]
fn normalized_uvs_colors_and_quantized_positions_are_scaled() {
    let mut doc = Doc::triangle();
    doc.attribute("NORMAL", "VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let bytes = doc.normalized(&[0, 255, 51, 102, 255, 0], U8, "VEC2", 3);
    let shorts = doc.normalized(&le16(&[0, 65535, 13107, 0, 0, 0]), U16, "VEC2", 3);
    let colors = doc.normalized(&[255, 0, 51, 0, 255, 0, 0, 0, 255], U8, "VEC3", 3);
    doc.primitive()["attributes"]["TEXCOORD_0"] = json!(bytes);
    doc.primitive()["attributes"]["TEXCOORD_1"] = json!(shorts);
    doc.primitive()["attributes"]["COLOR_0"] = json!(colors);
    let scene = doc.scene();
    let found = primitive(&scene);
    assert!(close(found.uvs[0][0].y, 1.0) && close(found.uvs[0][1].x, 0.2) && close(found.uvs[0][1].y, 0.4));
    assert!(close(found.uvs[1][0].y, 1.0) && close(found.uvs[1][1].x, 0.2));
    assert!((found.colors[0] - Vec4::new(1.0, 0.0, 0.2, 1.0)).length() < 1e-6);
    assert_eq!(found.normals, [Vec3::Z; 3], "normals are brought to unit length");
}

#[test]
fn rgba_colors_of_16_bits_keep_their_alpha() {
    let mut doc = Doc::triangle();
    let colors = doc.normalized(&le16(&[65535, 0, 0, 13107].repeat(3)), U16, "VEC4", 3);
    doc.primitive()["attributes"]["COLOR_0"] = json!(colors);
    assert!((primitive(&doc.scene()).colors[2] - Vec4::new(1.0, 0.0, 0.0, 0.2)).length() < 1e-6);
}

#[test]
fn required_mesh_quantization_is_read() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let raw: Vec<u8> = [0i16, -1, 300, 0, 1000, 0, -32768, 7, 7].iter().flat_map(|value| value.to_le_bytes()).collect();
    let plain = doc.accessor(&raw, I16, "VEC3", 3);
    doc.primitive()["attributes"]["POSITION"] = json!(plain);
    assert_eq!(primitive(&doc.scene()).positions[0], Vec3::new(0.0, -1.0, 300.0));
    assert_eq!(primitive(&doc.scene()).positions[2], Vec3::new(-32768.0, 7.0, 7.0));

    let bytes = doc.normalized(&[0, 127, 129, 128, 0, 64, 0, 0, 0], I8, "VEC3", 3);
    let normals = doc.normalized(&[0, 0, 127].repeat(3), I8, "VEC3", 3);
    doc.primitive()["attributes"]["POSITION"] = json!(bytes);
    doc.primitive()["attributes"]["NORMAL"] = json!(normals);
    let scene = doc.scene();
    let found = primitive(&scene);
    assert_eq!(found.positions[0], Vec3::new(0.0, 1.0, -1.0));
    assert_eq!(found.positions[1].x, -1.0, "-128 is clamped");
    assert_eq!(found.normals[0], Vec3::Z);
}

#[test]
fn interleaved_attributes_are_taken_apart() {
    let mut doc = Doc::triangle();
    let mut bytes = Vec::new();
    for corner in 0..3u8 {
        bytes.extend(le(&[f32::from(corner), 2.0, 3.0]));
        bytes.extend([corner * 51, 255, 0, 0]);
    }
    // The last element may end before its stride does.
    bytes.truncate(bytes.len() - 2);
    let view = doc.view(&bytes);
    doc.json["bufferViews"][view]["byteStride"] = json!(16);
    let position = json!({ "bufferView": view, "componentType": F32, "type": "VEC3", "count": 3 });
    let uv = json!({
        "bufferView": view, "byteOffset": 12, "componentType": U8, "type": "VEC2", "count": 3, "normalized": true
    });
    let position = doc.push("accessors", position);
    let uv = doc.push("accessors", uv);
    doc.primitive()["attributes"] = json!({ "POSITION": position, "TEXCOORD_0": uv });
    let scene = doc.scene();
    assert_eq!(primitive(&scene).positions[2], Vec3::new(2.0, 2.0, 3.0));
    assert!((primitive(&scene).uvs[0][2] - Vec2::new(0.4, 1.0)).length() < 1e-6);
}

#[test]
fn sparse_accessors_work_with_and_without_a_base() {
    for has_base in [true, false] {
        let mut doc = Doc::triangle();
        let indices = doc.view(&le16(&[1, 2]));
        let values = doc.view(&le(&[5.0, 6.0, 7.0, 0.0, 9.0, 0.0]));
        let accessor = &mut doc.json["accessors"][0];
        accessor["sparse"] = json!({
            "count": 2,
            "indices": { "bufferView": indices, "componentType": U16 },
            "values": { "bufferView": values },
        });
        if !has_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
        }
        let found = primitive(&doc.scene()).positions.clone();
        assert_eq!(found, [Vec3::ZERO, Vec3::new(5.0, 6.0, 7.0), Vec3::new(0.0, 9.0, 0.0)]);
    }
}

#[test]
fn two_joint_sets_give_eight_influences_that_sum_to_one() {
    let mut doc = Doc::triangle();
    let low = doc.accessor(&[0, 1, 2, 3].repeat(3), U8, "VEC4", 3);
    let high = doc.accessor(&le16(&[4, 5, 6, 300].repeat(3)), U16, "VEC4", 3);
    let weights = doc.normalized(&[51, 51, 51, 51].repeat(3), U8, "VEC4", 3);
    let more = doc.floats("VEC4", &[0.1, 0.1, 0.0, 0.0].repeat(3));
    doc.primitive()["attributes"]["JOINTS_0"] = json!(low);
    doc.primitive()["attributes"]["JOINTS_1"] = json!(high);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    doc.primitive()["attributes"]["WEIGHTS_1"] = json!(more);
    let scene = doc.scene();
    let found = primitive(&scene).influences[1];
    assert!(close(found.iter().map(|one| one.weight).sum(), 1.0));
    assert_eq!(found.map(|one| one.joint), [0, 1, 2, 3, 4, 5, 0, 0], "a joint without weight means nothing");
    assert!(close(found[0].weight, 0.2) && close(found[4].weight, 0.1), "{found:?}");
}

#[test]
fn vertices_without_weights_follow_their_first_joint() {
    let mut doc = Doc::triangle();
    let joints = doc.accessor(&[1, 1, 1, 1].repeat(3), U8, "VEC4", 3);
    let weights = doc.floats("VEC4", &[0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, f32::NAN, -3.0, 1.0, 0.0]);
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    let scene = doc.scene();
    let found = &primitive(&scene).influences;
    assert_eq!(found[0][0], Influence { joint: 0, weight: 1.0 });
    assert_eq!(found[1][0], Influence { joint: 1, weight: 1.0 });
    assert_eq!(found[2][2], Influence { joint: 1, weight: 1.0 });
    assert!(scene.warnings.iter().any(|warning| warning.contains("1 vertex without weights follows its first joint")));
}

#[test]
fn all_zero_morph_targets_move_nothing() {
    let mut doc = Doc::triangle();
    let zeros = doc.push("accessors", json!({ "componentType": F32, "type": "VEC3", "count": 3 }));
    doc.primitive()["targets"] = json!([{ "POSITION": zeros }]);
    let scene = doc.scene();
    assert!(primitive(&scene).targets[0].positions.is_empty());
    assert_eq!(scene.nodes[0].weights, [0.0]);
}
