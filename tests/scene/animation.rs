//! Tracks, clips and what they move.

use super::build::{Doc, I16, U8};
use glam::{Quat, Vec3};
use pinwarp::pose::{ClipChoice, Pose, pose};
use pinwarp::scene::{Scene, TrackValues};
use serde_json::json;

const HELD: ClipChoice = ClipChoice { clip: Some(0), is_looped: false };
const LOOPED: ClipChoice = ClipChoice { clip: Some(0), is_looped: true };

fn place(scene: &Scene, choice: ClipChoice, seconds: f64) -> Vec3 {
    pose(scene, choice, seconds).scene_from_node[0].w_axis.truncate()
}

fn near(found: Vec3, expected: Vec3) -> bool {
    (found - expected).length() < 1e-5
}

fn corner(posed: &Pose, vertex: usize) -> Vec3 {
    posed.parts[0].positions[vertex].0
}

#[test]
fn clips_hold_at_their_ends_or_repeat() {
    let mut doc = Doc::triangle();
    doc.clip(0, "translation", "LINEAR", (&[0.0, 2.0], "VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]));
    let scene = doc.scene();
    assert_eq!(scene.clips[0].end_secs, 2.0);
    assert_eq!(scene.clips[0].name, "clip_0");
    for (seconds, held, looped) in [(-0.5, 0.0, 3.0), (0.5, 1.0, 1.0), (2.5, 4.0, 1.0), (9.0, 4.0, 2.0)] {
        assert!(near(place(&scene, HELD, seconds), Vec3::X * held), "held at {seconds}");
        assert!(near(place(&scene, LOOPED, seconds), Vec3::X * looped), "looped at {seconds}");
    }
    assert!(near(place(&scene, ClipChoice::default(), 1.0), Vec3::ZERO), "no clip: the rest pose");
    let beyond = ClipChoice { clip: Some(7), is_looped: false };
    assert!(near(place(&scene, beyond, 1.0), Vec3::ZERO), "no such clip: the rest pose");
}

#[test]
fn step_and_spline_keys_are_followed() {
    let mut doc = Doc::triangle();
    doc.clip(0, "translation", "STEP", (&[0.0, 1.0], "VEC3", &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]));
    let scene = doc.scene();
    assert!(near(place(&scene, HELD, 0.99), Vec3::X));
    assert!(near(place(&scene, HELD, 1.0), Vec3::X * 2.0));

    let mut doc = Doc::triangle();
    #[rustfmt::skip]
    let values = [
        0.0, 0.0, 0.0,  1.0, 0.0, 0.0,  3.0, 0.0, 0.0,
        6.0, 0.0, 0.0,  5.0, 0.0, 0.0,  0.0, 0.0, 0.0,
    ];
    doc.clip(0, "translation", "CUBICSPLINE", (&[0.0, 2.0], "VEC3", &values));
    let scene = doc.scene();
    // Half way: (p0 + p1) / 2 + span * (out - in) / 8.
    assert!(near(place(&scene, HELD, 1.0), Vec3::X * (3.0 + 2.0 * (3.0 - 6.0) / 8.0)));
}

#[test]
fn rotations_of_normalized_shorts_turn_the_short_way() {
    let mut doc = Doc::triangle();
    let input = doc.floats("SCALAR", &[0.0, 1.0]);
    // None, and a quarter turn about z with the sign of the other half of the sphere.
    let quarter = (32767.0 * 0.5f64.sqrt()).round() as i16;
    let raw: Vec<u8> = [0i16, 0, 0, 32767, 0, 0, -quarter, -quarter].iter().flat_map(|v| v.to_le_bytes()).collect();
    let output = doc.normalized(&raw, I16, "VEC4", 2);
    doc.json["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "rotation" } }],
        "samplers": [{ "input": input, "output": output }],
    }]);
    let scene = doc.scene();
    let expected = Quat::from_rotation_z(std::f32::consts::FRAC_PI_8 * 2.0) * Vec3::X;
    let found = corner(&pose(&scene, HELD, 0.5), 1);
    assert!((found - expected).length() < 1e-4, "{found} is not {expected}");
}

#[test]
fn weights_move_morph_targets() {
    let mut doc = Doc::square();
    let up = doc.floats("VEC3", &[0.0, 0.0, 2.0].repeat(4));
    let right = doc.floats("VEC3", &[1.0, 0.0, 0.0].repeat(4));
    doc.primitive()["targets"] = json!([{ "POSITION": up }, { "POSITION": right }]);
    doc.json["meshes"][0]["weights"] = json!([0.5, 0.0]);
    let rest = doc.scene();
    assert!(near(corner(&pose(&rest, ClipChoice::default(), 0.0), 0), Vec3::Z), "the mesh's weights");
    doc.json["nodes"][0]["weights"] = json!([0.0, 0.25]);
    doc.clip(0, "weights", "LINEAR", (&[0.0, 1.0], "SCALAR", &[0.0, 0.0, 1.0, 3.0]));
    let scene = doc.scene();
    assert!(near(corner(&pose(&scene, ClipChoice::default(), 0.0), 0), Vec3::X * 0.25), "the node's weights");
    assert!(near(corner(&pose(&scene, HELD, 0.5), 0), Vec3::new(1.5, 0.0, 1.0)));
}

#[test]
fn flat_normals_follow_a_morph_target() {
    let mut doc = Doc::triangle();
    // Lifts the third corner so that the face looks along -y when fully moved.
    let lift = doc.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 1.0]);
    doc.primitive()["targets"] = json!([{ "POSITION": lift }]);
    doc.json["nodes"][0]["weights"] = json!([1.0]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(near(posed.parts[0].normals[0].0, Vec3::NEG_Y), "{:?}", posed.parts[0].normals);
}

#[test]
fn a_moved_matrix_node_keeps_what_the_track_leaves_alone() {
    let mut doc = Doc::triangle();
    // Scale 2, moved by (1, 0, 0), columns first.
    doc.json["nodes"][0]["matrix"] = json!([2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 0, 1]);
    let rest = doc.scene();
    assert!(near(corner(&pose(&rest, ClipChoice::default(), 0.0), 1), Vec3::X * 3.0));
    doc.clip(0, "translation", "LINEAR", (&[0.0], "VEC3", &[0.0, 5.0, 0.0]));
    let scene = doc.scene();
    assert!(near(corner(&pose(&scene, HELD, 0.0), 1), Vec3::new(2.0, 5.0, 0.0)));
}

#[test]
fn foreign_and_repeated_channels_are_ignored_with_a_warning() {
    let mut doc = Doc::triangle();
    doc.clip(0, "translation", "LINEAR", (&[0.0], "VEC3", &[1.0, 0.0, 0.0]));
    let channels = doc.json["animations"][0]["channels"].as_array_mut().unwrap();
    channels.push(channels[0].clone());
    channels.push(json!({ "sampler": 0, "target": {
        "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/materials/0/alphaCutoff" } } } }));
    channels.push(json!({ "sampler": 0, "target": { "path": "translation" } }));
    doc.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let scene = doc.scene();
    assert_eq!(scene.clips[0].tracks.len(), 1);
    for part in ["KHR_animation_pointer", "2 of 4 channels", "animated twice"] {
        assert!(scene.warnings.iter().any(|warning| warning.contains(part)), "{part}: {:?}", scene.warnings);
    }
}

#[test]
fn keys_that_do_not_rise_are_dropped_with_a_warning() {
    let mut doc = Doc::triangle();
    let values = [0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    doc.clip(0, "translation", "LINEAR", (&[0.0, 0.0, 1.0], "VEC3", &values));
    let scene = doc.scene();
    assert_eq!(scene.clips[0].tracks[0].times, [0.0, 1.0]);
    assert!(matches!(&scene.clips[0].tracks[0].values, TrackValues::Translation(values) if values[1].x == 2.0));
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn damaged_tracks_are_errors_that_name_clip_and_node() {
    let base = || {
        let mut doc = Doc::triangle();
        doc.clip(0, "translation", "LINEAR", (&[0.0, 1.0], "VEC3", &[0.0; 6]));
        doc
    };
    let mut short = base();
    short.json["accessors"][2]["count"] = json!(1);
    assert!(short.fault().contains("clip \"clip_0\", channel 0 (node \"Thing\") has 1 value instead of 2"));
    let mut sampler = base();
    sampler.json["animations"][0]["channels"][0]["sampler"] = json!(4);
    assert!(sampler.fault().contains("its sampler does not exist"));
    let mut node = base();
    node.json["animations"][0]["channels"][0]["target"]["node"] = json!(4);
    assert!(node.fault().contains("the node does not exist"));
    let mut endless = Doc::triangle();
    endless.clip(0, "scale", "LINEAR", (&[0.0], "VEC3", &[0.0, f32::INFINITY, 0.0]));
    assert!(endless.fault().contains("not a finite number"));
    let mut far = Doc::triangle();
    far.clip(0, "translation", "LINEAR", (&[0.0], "VEC3", &[0.0, -1e30, 0.0]));
    let told = far.fault();
    assert!(
        told.contains("clip \"clip_0\", channel 0 (node \"Thing\") has the value -1e30, which is beyond 1e15"),
        "{told}"
    );
    let mut node = Doc::triangle();
    node.json["nodes"][0]["translation"] = json!([0.0, 1e30, 0.0]);
    let told = node.fault();
    assert!(told.contains("the placement of node \"Thing\" is not finite, or beyond 1e15"), "{told}");
}

/// Two joints: the lower at the origin, the upper one metre above it; three vertices at heights 0, 1 and 2.
fn skinned() -> Doc {
    let mut doc = Doc::points(&[[0.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 2.0, 0.0]]);
    doc.attribute("NORMAL", "VEC3", &[1.0, 0.0, 0.0].repeat(3));
    let joints = doc.accessor(&[0, 1, 0, 0].repeat(3), U8, "VEC4", 3);
    let weights = doc.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    doc.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    doc.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    #[rustfmt::skip]
    let matrices = doc.floats("MAT4", &[
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 1.0,
    ]);
    doc.json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": matrices }]);
    doc.json["nodes"] = json!([
        { "name": "Thing", "mesh": 0, "skin": 0, "translation": [100, 100, 100] },
        { "name": "Lower", "children": [2] },
        { "name": "Upper", "translation": [0, 1, 0] },
    ]);
    doc.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    doc
}

#[test]
fn skins_follow_their_joints_and_not_their_node() {
    let mut doc = skinned();
    let rest = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(near(corner(&rest, 2), Vec3::Y * 2.0), "the node's own placement does not count");
    let turn = Quat::from_rotation_z(std::f32::consts::FRAC_PI_2);
    doc.clip(2, "rotation", "LINEAR", (&[0.0], "VEC4", &turn.to_array()));
    let bent = pose(&doc.scene(), HELD, 0.0);
    assert!(near(corner(&bent, 0), Vec3::ZERO));
    // Half of it stays at (0.5, 1), half turns about (0, 1) to (0, 1.5).
    assert!(near(corner(&bent, 1), Vec3::new(0.25, 1.25, 0.0)), "{}", corner(&bent, 1));
    assert!(near(corner(&bent, 2), Vec3::new(-1.0, 1.0, 0.0)), "{}", corner(&bent, 2));
    assert!(near(bent.parts[0].normals[2].0, Vec3::Y), "normals turn along");
}

#[test]
fn skins_that_do_not_fit_are_refused() {
    let mut missing = skinned();
    missing.json["skins"][0]["joints"] = json!([1]);
    assert!(missing.fault().contains("vertex 1 follows a joint that the skin of node \"Thing\" (1 joint) lacks"));
    let mut few = skinned();
    few.json["skins"][0]["joints"] = json!([1, 2, 1]);
    assert!(few.fault().contains("2 inverse bind matrices for 3 joints"));
    let mut outside = skinned();
    outside.json["scenes"][0]["nodes"] = json!([0]);
    assert!(outside.fault().contains("joint \"Lower\" is not part of the scene"));
}

#[test]
fn mirrored_and_squashed_nodes_keep_good_normals() {
    let mut doc = Doc::square();
    doc.json["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(posed.parts[0].is_mirrored);
    assert!(near(posed.parts[0].normals[0].0, Vec3::Z), "the outside stays the outside");

    let mut doc = Doc::square();
    doc.attribute("NORMAL", "VEC3", &[1.0, 1.0, 0.0].repeat(4));
    doc.json["nodes"][0]["scale"] = json!([2, 1, 1]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(!posed.parts[0].is_mirrored);
    assert!(near(posed.parts[0].normals[0].0, Vec3::new(0.5, 1.0, 0.0).normalize()));

    let mut doc = Doc::square();
    doc.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(near(posed.parts[0].normals[0].0, Vec3::Z), "a flattened mesh faces its own way");
    let mut doc = Doc::square();
    doc.json["nodes"][0]["scale"] = json!([1e-12, 1e-12, 1e-12]);
    let posed = pose(&doc.scene(), ClipChoice::default(), 0.0);
    assert!(near(posed.parts[0].normals[0].0, Vec3::Z), "tiny scales do not lose the direction");
}

#[test]
fn many_vertices_pose_the_same_on_many_threads() {
    let count = 60_000;
    let points: Vec<[f32; 3]> = (0..count).map(|i| [i as f32, (i % 7) as f32, (i % 3) as f32]).collect();
    let mut doc = Doc::points(&points);
    doc.json["nodes"][0]["rotation"] = json!(Quat::from_rotation_y(0.7).to_array());
    let scene = doc.scene();
    let threads = |count| rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap();
    let one = threads(1).install(|| pose(&scene, ClipChoice::default(), 0.0));
    let four = threads(4).install(|| pose(&scene, ClipChoice::default(), 0.0));
    assert_eq!(one.parts[0].positions.len(), count);
    assert!(one.parts[0].positions == four.parts[0].positions);
    assert!(one.parts[0].normals == four.parts[0].normals);
}
