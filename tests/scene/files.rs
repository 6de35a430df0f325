//! Containers, buffers, extensions, node trees: what a file may be made of, and what must be refused.

use super::build::{Doc, F32, U8, base64, load_bytes, write};
use glam::Vec3;
use pinwarp::pose::{ClipChoice, pose};
use pinwarp::scene::{FindError, SceneError, load};
use serde_json::{Value, json};
use std::path::Path;

#[test]
fn glb_data_uris_and_external_buffers_give_the_same_scene() {
    let doc = Doc::square();
    let expected = doc.scene().meshes[0].primitives[0].positions.clone();
    let folder = tempfile::tempdir().unwrap();
    let glb = load(&write(folder.path(), "a.glb", &doc.glb())).unwrap();
    assert_eq!(glb.meshes[0].primitives[0].positions, expected);
    assert_eq!(glb.path, folder.path().join("a.glb"));

    write(folder.path(), "my data ü.bin", &doc.bytes);
    for uri in ["my%20data%20%C3%BC.bin", "my data ü.bin", "./my%20data%20ü.bin"] {
        let mut json = doc.json.clone();
        json["buffers"] = json!([{ "byteLength": doc.bytes.len(), "uri": uri }]);
        let scene = load(&write(folder.path(), "a.gltf", json.to_string().as_bytes())).unwrap();
        assert_eq!(scene.meshes[0].primitives[0].positions, expected, "{uri}");
    }
    let unpadded = base64(&doc.bytes).trim_end_matches('=').to_owned();
    let mut json = doc.json.clone();
    json["buffers"] = json!([{ "byteLength": doc.bytes.len(), "uri": format!("data:;base64,{unpadded}") }]);
    assert!(load_bytes(json.to_string().as_bytes()).is_ok());
}

#[test]
fn a_missing_buffer_is_an_io_error_that_names_the_file() {
    let doc = Doc::triangle();
    let mut json = doc.json.clone();
    json["buffers"] = json!([{ "byteLength": doc.bytes.len(), "uri": "gone.bin" }]);
    let error = load_bytes(json.to_string().as_bytes()).unwrap_err();
    assert!(matches!(&error, SceneError::Io { path, .. } if path.ends_with("gone.bin")), "{error}");
    json["buffers"] = json!([{ "byteLength": doc.bytes.len(), "uri": "https://example.com/a.bin" }]);
    let error = load_bytes(json.to_string().as_bytes()).unwrap_err();
    assert!(matches!(error, SceneError::Unsupported { .. }), "{error}");
    json["buffers"] = json!([{ "byteLength": doc.bytes.len() }]);
    let error = load_bytes(json.to_string().as_bytes()).unwrap_err();
    assert!(error.to_string().contains("buffers[0] has no uri"), "{error}");
    json["buffers"] = json!([{ "byteLength": 9999, "uri": "data:;base64,AAAA" }]);
    let error = load_bytes(json.to_string().as_bytes()).unwrap_err();
    assert!(error.to_string().contains("must have 9999 bytes and has 3"), "{error}");
    assert!(matches!(load(Path::new("no such file.glb")), Err(SceneError::Io { .. })));
}

#[test]
fn a_glb_that_is_cut_short_says_so() {
    let bytes = Doc::triangle().glb();
    let error = load_bytes(&bytes[..bytes.len() - 5]).unwrap_err();
    assert!(error.to_string().contains("cut short"), "{error}");
    for length in 0..bytes.len() {
        assert!(load_bytes(&bytes[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn unsupported_required_extensions_are_named_and_optional_ones_are_warnings() {
    let mut doc = Doc::triangle();
    doc.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression", "KHR_materials_variants"]);
    let scene = doc.scene();
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert!(scene.warnings[1].contains("KHR_materials_variants"));
    doc.json["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_draco_mesh_compression"]);
    let error = doc.load().unwrap_err();
    assert!(matches!(&error, SceneError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("KHR_draco_mesh_compression"), "{error}");
    assert!(error.to_string().contains("without Draco"), "{error}");
    doc.json["extensionsRequired"] = json!([]);
    doc.json["asset"]["version"] = json!("1.0");
    assert!(doc.fault().contains("glTF version 1.0"));
}

#[test]
fn optional_extensions_with_strange_bodies_do_no_harm() {
    let mut doc = Doc::triangle();
    doc.primitive()["extensions"] = json!({ "KHR_materials_variants": { "mappings": 7 } });
    doc.json["extensions"] = json!({ "KHR_materials_variants": "no" });
    doc.json["extras"] = json!({ "any": [1, 2] });
    doc.json["nodes"][0]["extras"] = json!("text");
    assert_eq!(doc.scene().meshes.len(), 1);
}

#[test]
fn damaged_geometry_is_refused_by_name() {
    let mut far = Doc::square();
    let indices = far.accessor(&[0, 1, 9], U8, "SCALAR", 3);
    far.primitive()["indices"] = json!(indices);
    assert!(far.fault().contains("mesh \"Shape\", primitive 0: index 2 asks for vertex 9 of 4"));

    let broken = Doc::points(&[[0.0; 3], [1.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]]);
    assert!(broken.fault().contains("mesh \"Shape\", primitive 0: the position of vertex 1 is not a finite number"));
    let endless = Doc::points(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]]);
    assert!(endless.fault().contains("vertex 2"));

    let mut long = Doc::triangle();
    long.json["accessors"][0]["count"] = json!(4);
    assert!(long.fault().contains("accessors[0] reaches past the end of its buffer view (4 elements)"));
    let mut huge = Doc::triangle();
    huge.json["accessors"][0]["count"] = json!(u64::MAX);
    assert!(huge.fault().contains("accessors[0]"));
    let mut zeros = Doc::triangle();
    zeros.json["accessors"][0] = json!({ "componentType": F32, "type": "VEC3", "count": 4_000_000_000u64 });
    assert!(zeros.fault().contains("more zeros than are allowed"));
    let mut view = Doc::triangle();
    view.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX);
    assert!(view.fault().contains("bufferViews[0] reaches past the end of buffers[0]"));
    let mut stride = Doc::triangle();
    stride.json["bufferViews"][0]["byteStride"] = json!(8);
    assert!(stride.fault().contains("stride 8"));
    let mut kind = Doc::triangle();
    kind.json["accessors"][0]["type"] = json!("VEC2");
    assert!(kind.fault().contains("is a Vec2 where [Vec3] is expected"));
    let mut uneven = Doc::square();
    uneven.attribute("TEXCOORD_0", "VEC2", &[0.0; 6]);
    assert!(uneven.fault().contains("TexCoords(0) has 3 elements for 4 vertices"));
}

#[test]
fn damaged_sparse_parts_are_refused() {
    let sparse = |index: u8, count: u32| {
        let mut doc = Doc::triangle();
        let indices = doc.view(&[index]);
        let values = doc.view(&[0; 12]);
        doc.json["accessors"][0]["sparse"] = json!({
            "count": count,
            "indices": { "bufferView": indices, "componentType": U8 },
            "values": { "bufferView": values },
        });
        doc
    };
    assert!(sparse(2, 1).load().is_ok());
    assert!(sparse(3, 1).fault().contains("replaces element 3 of 3"));
    assert!(sparse(0, 2).fault().contains("sparse part of its accessor reaches past the end"));
}

#[test]
fn references_to_nothing_are_refused() {
    let with = |path: &str, value: Value| {
        let mut doc = Doc::triangle();
        *doc.json.pointer_mut(path).unwrap() = value;
        doc.fault()
    };
    assert!(with("/nodes/0/mesh", json!(7)).contains("node \"Thing\" names meshes[7]"));
    assert!(with("/scene", json!(3)).contains("default scene"));
    assert!(with("/scenes/0/nodes", json!([5])).contains("nodes[5]"));
    assert!(with("/meshes/0/primitives/0/attributes/POSITION", json!(8)).contains("accessors[8]"));
    assert!(with("/bufferViews/0/buffer", json!(2)).contains("buffers[2]"));
    assert!(with("/meshes", json!([{ "name": "x" }])).contains("meshes[0]: missing field"));
    assert!(with("/nodes", json!([{ "mesh": 0, "rotation": [1] }])).contains("nodes[0]"));
    assert!(with("/nodes", json!([{ "mesh": 0, "skin": 0 }])).contains("skins[0]"));
    assert!(with("/nodes", json!([{ "mesh": 0, "camera": 0 }])).contains("cameras[0]"));
    assert!(with("/nodes", json!([{ "translation": [1e39, 0, 0] }])).contains("not finite"));
}

#[test]
fn only_the_default_scene_is_read_and_parents_come_first() {
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([
        { "name": "Leaf", "mesh": 0, "translation": [1, 0, 0] },
        { "name": "Other", "mesh": 0 },
        { "name": "Root", "children": [3, 0], "translation": [10, 0, 0] },
        { "name": "Left" },
    ]);
    doc.json["scenes"] = json!([{ "nodes": [1] }, { "nodes": [2] }]);
    doc.json["scene"] = json!(1);
    let scene = doc.scene();
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["Root", "Left", "Leaf"]);
    assert_eq!(scene.nodes.iter().map(|node| node.parent).collect::<Vec<_>>(), [None, Some(0), Some(0)]);
    let posed = pose(&scene, ClipChoice::default(), 0.0);
    assert_eq!(posed.parts.len(), 1);
    assert_eq!(posed.parts[0].positions[0].0, Vec3::X * 11.0);
    assert_eq!(scene.subtree(0), [0, 1, 2]);
    assert_eq!(scene.subtree(2), [2]);
    assert!(scene.subtree(9).is_empty());
    assert_eq!(scene.matching("Le*"), [1, 2]);
    assert_eq!(scene.node_named("Leaf"), Some(2));

    doc.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(doc.scene().nodes[0].name, "Other", "the first scene");
    doc.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(doc.scene().nodes.len(), 4, "all roots");
    doc.json["scenes"] = json!([{ "name": "empty" }]);
    let empty = doc.scene();
    assert!(empty.nodes.is_empty() && empty.warnings.len() == 1, "a scene without nodes loads");
}

#[test]
fn cycles_and_second_parents_are_refused() {
    let mut doc = Doc::triangle();
    doc.json["nodes"] = json!([{ "name": "A", "children": [1] }, { "name": "B", "children": [0] }]);
    assert!(doc.fault().contains("is its own ancestor"));
    doc.json["nodes"] = json!([{ "name": "A", "children": [0] }]);
    assert!(doc.fault().contains("is its own ancestor"));
    doc.json["nodes"] = json!([{ "children": [2] }, { "children": [2] }, { "name": "C" }]);
    assert!(doc.fault().contains("node \"C\" is a child twice"));
    doc.json["nodes"] = json!([{ "children": [1] }, { "name": "B" }]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    assert!(doc.fault().contains("node \"B\" occurs twice in the scene"));
}

#[test]
fn deep_trees_do_not_overflow_the_stack() {
    let mut doc = Doc::empty();
    let count = 100_000;
    let node = |index: usize| if index + 1 < count { json!({ "children": [index + 1] }) } else { json!({}) };
    doc.json["nodes"] = (0..count).map(node).collect();
    assert_eq!(doc.scene().nodes.len(), count);
}

#[test]
fn cameras_and_clips_are_found_by_name_or_the_nearest_is_offered() {
    let mut doc = Doc::triangle();
    assert_eq!(doc.scene().find_camera(None), Err(FindError::NoCamera));
    assert_eq!(doc.scene().find_clip(None, None), Ok(None));
    doc.json["cameras"] = json!([
        { "type": "perspective", "name": "Lens", "perspective": { "yfov": 0.5, "znear": 0.1 } },
        { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 2, "zfar": 10, "znear": 0 } },
    ]);
    doc.json["nodes"] = json!([{ "mesh": 0 }, { "name": "ShotCam", "camera": 0 }, { "name": "Top", "camera": 1 }]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    doc.clip(0, "translation", "STEP", (&[0.0], "VEC3", &[0.0; 3]));
    doc.json["animations"][0]["name"] = json!("Walk");
    let scene = doc.scene();
    assert_eq!(scene.find_camera(None), Ok(1));
    assert_eq!(scene.find_camera(Some("Top")), Ok(2));
    assert_eq!(scene.find_camera(Some("Lens")), Ok(1));
    let error = scene.find_camera(Some("shotcam")).unwrap_err();
    assert!(error.to_string().contains("did you mean \"ShotCam\"?"), "{error}");
    let error = scene.find_camera(Some("zzzz")).unwrap_err();
    assert!(error.to_string().contains("there are: ShotCam"), "{error}");
    assert_eq!(scene.find_clip(None, None), Ok(Some(0)));
    assert_eq!(scene.find_clip(Some("Walk"), None), Ok(Some(0)));
    assert_eq!(scene.find_clip(None, Some(1)), Err(FindError::ClipOutOfRange { index: 1, count: 1 }));
    let error = scene.find_clip(Some("walk"), None).unwrap_err();
    assert!(error.to_string().contains("did you mean \"Walk\"?"), "{error}");
}

#[test]
fn impossible_cameras_are_refused() {
    for lens in [json!({ "yfov": 0, "znear": 0.1 }), json!({ "yfov": 1, "znear": 0 }), json!({ "yfov": 4, "znear": 1 })]
    {
        let mut doc = Doc::triangle();
        doc.json["cameras"] = json!([{ "type": "perspective", "perspective": lens }]);
        doc.json["nodes"][0]["camera"] = json!(0);
        assert!(doc.fault().contains("cameras[0]"));
    }
}
