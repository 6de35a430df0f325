//! Extensions: what only changes shading is approximated, instances become nodes, flat normals follow the pose.

use super::assets::shared;
use super::build::{Doc, F32, I8, I16};
use glam::{Quat, Vec3, Vec4};
use pinwarp::pose::{ClipChoice, Pose, pose};
use pinwarp::scene::{AlphaMode, FileAccess, Scene, load, pack};
use serde_json::{Value, json};

const REST: ClipChoice = ClipChoice { clip: None, is_looped: false };

/// A square whose material has an extension that the file requires.
fn shaded(name: &str, body: Value) -> Doc {
    let mut doc = Doc::square();
    doc.json["extensionsUsed"] = json!([name]);
    doc.json["extensionsRequired"] = json!([name]);
    doc.json["materials"] = json!([{ "extensions": { name: body } }]);
    doc.primitive()["material"] = json!(0);
    doc
}

#[test]
fn required_extensions_that_only_change_shading_are_approximated_with_one_note() {
    let names = [
        "transmission",
        "variants",
        "pbrSpecularGlossiness",
        "clearcoat",
        "sheen",
        "ior",
        "iridescence",
        "anisotropy",
        "dispersion",
        "volume",
        "specular",
        "diffuse_transmission",
    ];
    for name in names.map(|name| format!("KHR_materials_{name}")) {
        for body in [json!({}), json!({ "anything": 7 }), json!("no object")] {
            let scene = shaded(&name, body).scene();
            assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
            assert!(scene.warnings[0].contains(&name) && scene.warnings[0].contains("approximated"));
            assert_eq!(scene.meshes[0].primitives[0].triangles.len(), 2);
        }
    }
    let mut all = Doc::square();
    let names = names.map(|name| format!("KHR_materials_{name}"));
    all.json["extensionsUsed"] = json!(names);
    all.json["extensionsRequired"] = json!(names);
    let scene = all.scene();
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(names.iter().all(|name| scene.warnings[0].contains(name)), "{:?}", scene.warnings);
    assert!(shaded("KHR_materials_emissive_strength", json!({})).scene().warnings.is_empty());
    assert!(shaded("KHR_node_visibility", json!({})).fault().contains("KHR_node_visibility"));
}

#[test]
fn specular_glossiness_becomes_metallic_roughness() {
    let name = "KHR_materials_pbrSpecularGlossiness";
    let factors = |diffuse: [f32; 4], specular: [f32; 3], glossiness: f32| {
        let body = json!({ "diffuseFactor": diffuse, "specularFactor": specular, "glossinessFactor": glossiness });
        shaded(name, body).scene().materials[0].clone()
    };
    let plastic = factors([0.8, 0.4, 0.2, 1.0], [0.04; 3], 0.7);
    assert!((plastic.metallic, plastic.roughness) == (0.0, 1.0 - 0.7), "{plastic:?}");
    assert!((plastic.base_color - Vec4::new(0.8, 0.4, 0.2, 1.0)).length() < 1e-6);
    let gold = factors([0.0, 0.0, 0.0, 1.0], [1.0, 0.77, 0.34], 0.9);
    assert!(gold.metallic > 0.95, "{gold:?}");
    assert!((gold.base_color - Vec4::new(1.0, 0.77, 0.34, 1.0)).length() < 0.1, "{gold:?}");
    let mut own = shaded(name, json!({ "diffuseFactor": [1, 0, 0, 1] }));
    own.json["materials"][0]["pbrMetallicRoughness"] = json!({ "metallicFactor": 0.25 });
    assert_eq!(own.scene().materials[0].metallic, 0.25, "the file's own approximation counts");
}

#[test]
fn glass_lets_what_is_behind_it_through() {
    let name = "KHR_materials_transmission";
    let glass = shaded(name, json!({ "transmissionFactor": 1.0 })).scene().materials[0].clone();
    assert_eq!(glass.alpha, AlphaMode::Blend);
    assert!((0.05..0.3).contains(&glass.base_color.w), "{glass:?}");
    let textured = json!({ "transmissionFactor": 1.0, "transmissionTexture": { "index": 0 } });
    assert_eq!(shaded(name, textured).scene().materials[0].alpha, AlphaMode::Opaque);
    assert_eq!(shaded(name, json!({})).scene().materials[0].alpha, AlphaMode::Opaque);
}

/// A triangle drawn three times below a moving node.
fn instanced() -> Doc {
    let mut doc = Doc::triangle();
    let moves = doc.floats("VEC3", &[0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0, 0.0]);
    let quarter = (32767.0 * 0.5f64.sqrt()).round() as i16;
    let turns = [[0, 0, 0, 32767], [0, 0, quarter, quarter], [0, 0, 0, 32767i16]];
    let raw: Vec<u8> = turns.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
    let turns = doc.normalized(&raw, I16, "VEC4", 3);
    let scales = doc.floats("VEC3", &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let attributes = json!({ "TRANSLATION": moves, "ROTATION": turns, "SCALE": scales });
    doc.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    doc.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    doc.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    doc.clip(0, "translation", "LINEAR", (&[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 5.0]));
    doc
}

/// The second corner, at (1, 0, 0) in its node, of every part.
fn second_corners(posed: &Pose) -> Vec<Vec3> {
    posed.parts.iter().map(|part| part.positions[1].0).collect()
}

#[test]
fn instances_are_nodes_below_their_node_and_move_with_it() {
    let scene = instanced().scene();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["Thing", "Thing[0]", "Thing[1]", "Thing[2]"]);
    assert_eq!(scene.matching("Thing*").len(), 4);
    assert_eq!(scene.subtree(0).len(), 4, "a pattern of the node claims its instances");
    let expected = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 1.0, 0.0), Vec3::new(2.0, 3.0, 0.0)];
    for (seconds, lift) in [(0.0, 0.0), (0.5, 2.5)] {
        let posed = pose(&scene, ClipChoice { clip: Some(0), is_looped: false }, seconds);
        for (found, expected) in second_corners(&posed).into_iter().zip(expected) {
            assert!((found - expected - Vec3::Z * lift).length() < 1e-4, "{found} is not {expected}");
        }
    }
}

#[test]
fn instances_become_nodes_of_the_packed_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = super::build::write(folder.path(), "a.glb", &instanced().glb());
    let packed = pack(&path, FileAccess::default()).unwrap();
    let scene = load(&path).unwrap();
    for (node, &number) in scene.nodes.iter().zip(&scene.file_from_scene) {
        let json = &packed.json["nodes"][number];
        assert_eq!(json["name"], json!(node.name));
        assert_eq!(json["mesh"].is_null(), node.mesh.is_none(), "{json}");
    }
    let text = packed.json.to_string();
    assert!(!text.contains("EXT_mesh_gpu_instancing"), "{text}");
}

#[test]
fn broken_and_endless_instances_are_refused_by_name() {
    let broken = |edit: fn(&mut Doc)| {
        let mut doc = instanced();
        edit(&mut doc);
        doc.fault()
    };
    let uneven = broken(|doc| {
        let two = doc.floats("VEC3", &[1.0; 6]);
        doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(two);
    });
    assert!(uneven.contains("node \"Thing\"") && uneven.contains("elements"), "{uneven}");
    let missing = broken(|doc| {
        doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(99);
    });
    assert!(missing.contains("accessors[99]"), "{missing}");
    let wrong = broken(|doc| {
        doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!("x");
    });
    assert!(wrong.contains("SCALE"), "{wrong}");
    let endless = broken(|doc| {
        let count = doc.json["accessors"].as_array().unwrap().len();
        let zeros = json!({ "componentType": F32, "type": "VEC3", "count": 4_000_000 });
        doc.push("accessors", zeros);
        doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = json!({ "attributes": { "SCALE": count } });
    });
    assert!(endless.contains("4000000 instances") && endless.contains("at most"), "{endless}");
    let infinite = broken(|doc| {
        let three = doc.floats("VEC3", &[1.0, 1.0, 1.0, f32::NAN, 1.0, 1.0, 1.0, 1.0, 1.0]);
        doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(three);
    });
    assert!(infinite.contains("instance 1 is not a finite number"), "{infinite}");
}

#[test]
fn byte_rotations_of_instances_are_normalised() {
    let mut doc = instanced();
    let raw =
        [[0i8, 0, 0, 127], [0, 0, 90, 90], [0, 0, 127, 0]].as_flattened().iter().map(|v| *v as u8).collect::<Vec<_>>();
    let turns = doc.normalized(&raw, I8, "VEC4", 3);
    doc.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({ "ROTATION": turns });
    let posed = pose(&doc.scene(), REST, 0.0);
    let expected = [Vec3::X, Quat::from_rotation_z(std::f32::consts::FRAC_PI_2) * Vec3::X, Vec3::NEG_X];
    for (found, expected) in second_corners(&posed).into_iter().zip(expected) {
        assert!((found - expected).length() < 1e-5, "{found} is not {expected}");
    }
}

/// Greatest angle between a normal and that of its triangle as posed, degrees.
fn worst_flat_normal(scene: &Scene, posed: &Pose) -> f32 {
    let mut worst = 0.0f32;
    for part in &posed.parts {
        for triangle in &scene.meshes[part.mesh].primitives[part.primitive].triangles {
            let [a, b, c] = triangle.map(|corner| part.positions[corner as usize].0.as_dvec3());
            let Some(face) = (b - a).cross(c - a).try_normalize() else { continue };
            for &corner in triangle {
                let angle = face.as_vec3().angle_between(part.normals[corner as usize].0);
                worst = worst.max(angle.to_degrees());
            }
        }
    }
    worst
}

#[test]
fn flat_normals_are_those_of_the_posed_triangles() {
    // Two triangles; the joints of their corners turn against each other.
    let mut doc = Doc::points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]]);
    let indices = doc.accessor(&[0, 1, 2, 0, 2, 3], super::build::U8, "SCALAR", 6);
    doc.primitive()["indices"] = json!(indices);
    let lift = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.0, -0.5, 0.3, 0.2, 0.1]);
    let turned = doc.floats("VEC3", &[0.0, 1.0, 0.0].repeat(4));
    doc.primitive()["targets"] = json!([{ "POSITION": lift, "NORMAL": turned }]);
    doc.json["meshes"][0]["weights"] = json!([0.0]);
    let unmorphed = doc.scene();
    assert!(worst_flat_normal(&unmorphed, &pose(&unmorphed, REST, 0.0)) < 0.1);
    for weight in [0.5, 1.0, 2.0] {
        doc.json["meshes"][0]["weights"] = json!([weight]);
        let scene = doc.scene();
        let worst = worst_flat_normal(&scene, &pose(&scene, REST, 0.0));
        assert!(worst < 0.1, "morphed by {weight}: {worst} degrees");
    }
    let joints = doc.accessor(
        [[0u8, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0]].as_flattened(),
        super::build::U8,
        "VEC4",
        4,
    );
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.attribute(
        "WEIGHTS_0",
        "VEC4",
        &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0],
    );
    doc.json["skins"] = json!([{ "joints": [1, 2] }]);
    doc.json["nodes"][0]["skin"] = json!(0);
    let bent = Quat::from_rotation_y(1.0).to_array();
    doc.json["nodes"]
        .as_array_mut()
        .unwrap()
        .extend([json!({ "name": "A" }), json!({ "name": "B", "rotation": bent })]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    let scene = doc.scene();
    let worst = worst_flat_normal(&scene, &pose(&scene, REST, 0.0));
    assert!(worst < 0.1, "skinned and morphed: {worst} degrees");
    // A mirrored rig shows the outside, too.
    doc.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    doc.json["nodes"][2]["scale"] = json!([-1, 1, 1]);
    let scene = doc.scene();
    let posed = pose(&scene, REST, 0.0);
    assert!(posed.parts[0].is_mirrored);
    assert!(worst_flat_normal(&scene, &posed) > 179.9, "the normals of a mirrored mesh face against its winding");
}

#[test]
fn the_fox_has_the_normals_of_its_posed_triangles() {
    let Some(path) = shared("gltf-samples/Fox.glb") else { return };
    let scene = load(&path).unwrap();
    for clip in 0..scene.clips.len() {
        let posed = pose(&scene, ClipChoice { clip: Some(clip), is_looped: false }, 0.3);
        let worst = worst_flat_normal(&scene, &posed);
        assert!(worst < 0.5, "clip {clip}: {worst} degrees");
    }
}
