//! The walker scene: a gnome with fifteen joints walks along a path, followed by the camera.
//!
//! Out: walker.glb. Nodes that layers can select: `Body`, `Legs`, and `Face`, `Beard`, `Hat`, `EyeLeft`, `EyeRight`.
//! Clips: `Stroll` (48 frames at 24 fps: two cycles; root and camera move), `Walk` (one cycle in place, loops).

use super::glb::{Glb, Surface, Track, looking, numbers, placed};
use super::gnome::{Cloths, EYE, body, eye, hat, head, legs, whiskers};
use super::meadow::{HEADING, backdrop, grass, ground, mushrooms, noise, sky, turf};
use super::paint::{Rgba, png, png_rgba, smoothstep};
use super::rig::{HEAD, JOINTS, STRIDE, joint_from_mesh, offset, walk};
use glam::{DQuat, DVec2, DVec3};
use image::ImageError;
use serde_json::{Value, json};

/// Frames of a cycle of two steps.
const CYCLE: u32 = 24;

/// A matte material with a constant colour.
fn plain(name: &str, color: [f64; 3], roughness: f64) -> Value {
    json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [color[0], color[1], color[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness,
        },
    })
}

/// An unlit material with a texture.
fn painted(name: &str, texture: usize, alpha: &str) -> Value {
    json!({
        "name": name, "alphaMode": alpha, "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": texture }, "metallicFactor": 0.0 },
    })
}

/// Texture of the hat: red wool with cream zigzag bands, ribbed like knitting.
fn knit(uv: DVec2) -> DVec3 {
    let zigzag = ((uv.x * 12.0).fract() - 0.5).abs() * 0.09;
    let band = |middle: f64| 1.0 - smoothstep(0.020, 0.030, (uv.y + zigzag - middle).abs());
    let cream = band(0.36).max(band(0.62)).max(band(0.88));
    let rib = 0.86 + 0.14 * (1.0 - (2.0 * (uv.x * 60.0).fract() - 1.0).abs());
    DVec3::new(0.60, 0.035, 0.04).lerp(DVec3::new(0.85, 0.76, 0.60), cream) * rib * (0.9 + 0.2 * noise(uv * 60.0))
}

fn cloths(glb: &mut Glb) -> Result<Cloths, ImageError> {
    let wool = glb.texture("Knit", &png(256, 256, knit)?);
    let mut material = |material: Value| glb.material(material);
    let mut cloths = Cloths {
        coat: material(plain("Coat", [0.045, 0.13, 0.30], 0.75)),
        trousers: material(plain("Trousers", [0.22, 0.07, 0.12], 0.9)),
        leather: material(plain("Leather", [0.11, 0.045, 0.022], 0.42)),
        mitten: material(plain("Mitten", [0.72, 0.36, 0.04], 0.85)),
        fur: material(plain("Fur", [0.74, 0.71, 0.64], 0.95)),
        skin: material(plain("Skin", [1.0, 1.0, 1.0], 0.55)),
        eye: material(plain("Eye", [0.012, 0.01, 0.012], 0.12)),
        gold: 0,
        knit: 0,
        glint: 0,
    };
    let mut gold = plain("Gold", [0.90, 0.58, 0.16], 0.35);
    gold["pbrMetallicRoughness"]["metallicFactor"] = json!(0.6);
    cloths.gold = material(gold);
    let mut knitted = plain("Knit", [1.0, 1.0, 1.0], 0.9);
    knitted["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": wool });
    cloths.knit = material(knitted);
    let mut glint = plain("Glint", [1.0, 1.0, 1.0], 1.0);
    glint["extensions"] = json!({ "KHR_materials_unlit": {} });
    cloths.glint = material(glint);
    Ok(cloths)
}

/// Adds the skeleton below `root`; returns the node of each joint.
fn add_joints(glb: &mut Glb, root: usize) -> Vec<usize> {
    let mut nodes: Vec<usize> = Vec::new();
    for joint in &JOINTS {
        let parent = joint.parent.map_or(root, |parent| nodes[parent]);
        let node = json!({ "name": joint.name, "translation": numbers(&offset(joint).to_array()) });
        nodes.push(glb.child(parent, node));
    }
    nodes
}

fn add_gnome(glb: &mut Glb, root: usize, joints: &[usize]) -> Result<(), ImageError> {
    let cloths = cloths(glb)?;
    let matrices: Vec<_> = JOINTS.iter().map(joint_from_mesh).collect();
    let skin = glb.skin(joints, &matrices);
    let parts = [
        ("Body", body(cloths)),
        ("Legs", legs(cloths)),
        ("Face", head(cloths)),
        ("Beard", whiskers(cloths)),
        ("Hat", hat(cloths)),
    ];
    for (name, surfaces) in parts {
        let mesh = glb.mesh(name, &surfaces);
        glb.node(json!({ "name": name, "mesh": mesh, "skin": skin }));
    }
    let mesh = glb.mesh("Eye", &eye(cloths));
    for (name, side) in [("EyeLeft", 1.0), ("EyeRight", -1.0)] {
        let at = EYE * DVec3::new(side, 1.0, 1.0) - JOINTS[HEAD].at;
        let turn = DQuat::from_rotation_y(0.36 * side);
        let node = json!({
            "name": name, "mesh": mesh,
            "translation": numbers(&at.to_array()), "rotation": numbers(&turn.to_array()),
        });
        glb.child(joints[HEAD], node);
    }
    add_shadow(glb, root)
}

/// A soft shadow under the gnome.
fn add_shadow(glb: &mut Glb, root: usize) -> Result<(), ImageError> {
    let spot = |uv: DVec2| Rgba {
        color: DVec3::new(0.03, 0.03, 0.02),
        alpha: 0.8 * (1.0 - smoothstep(0.05, 0.5, (uv - 0.5).length())),
    };
    let texture = glb.texture("Spot", &png_rgba(64, 64, spot)?);
    let material = glb.material(painted("Shadow", texture, "BLEND"));
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, z)| DVec2::new(x, z));
    let spot = Surface {
        positions: corners.map(|at| DVec3::new(at.x * 0.46, 0.004, at.y * 0.46)).to_vec(),
        normals: vec![DVec3::Y; 4],
        uvs: corners.map(|at| at * 0.5 + 0.5).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Surface::default()
    };
    let mesh = glb.mesh("Shadow", &[spot]);
    glb.child(root, json!({ "name": "Shadow", "mesh": mesh }));
    Ok(())
}

fn add_meadow(glb: &mut Glb) -> Result<(), ImageError> {
    let turf = glb.texture("Turf", &png(512, 384, turf)?);
    let hills = glb.texture("Hills", &png(512, 256, sky)?);
    let turf = glb.material(painted("Turf", turf, "OPAQUE"));
    let hills = glb.material(painted("Hills", hills, "OPAQUE"));
    let mut blades = plain("Grass", [1.0, 1.0, 1.0], 1.0);
    blades["doubleSided"] = json!(true);
    blades["extensions"] = json!({ "KHR_materials_unlit": {} });
    let blades = glb.material(blades);
    let caps = glb.material(plain("Toadstool", [1.0, 1.0, 1.0], 0.5));
    let surfaces =
        [("Ground", ground(turf)), ("Sky", backdrop(hills)), ("Grass", grass(blades)), ("Toadstools", mushrooms(caps))];
    for (name, surface) in surfaces {
        let mesh = glb.mesh(name, &[surface]);
        glb.node(json!({ "name": name, "mesh": mesh }));
    }
    Ok(())
}

/// Tracks of the skeleton over `frames` frames of the walk.
fn joint_tracks(joints: &[usize], frames: u32) -> Vec<Track> {
    let times: Vec<f64> = (0..=frames).map(|frame| f64::from(frame) / 24.0).collect();
    let stances: Vec<_> = (0..=frames).map(|frame| walk(f64::from(frame % CYCLE) / f64::from(CYCLE))).collect();
    let hips = stances.iter().flat_map(|stance| stance.hips.to_array()).collect();
    let mut tracks = vec![Track { node: joints[0], path: "translation", times: times.clone(), values: hips }];
    for (joint, node) in joints.iter().enumerate() {
        let values = stances.iter().flat_map(|stance| stance.rotations[joint].to_array()).collect();
        tracks.push(Track { node: *node, path: "rotation", times: times.clone(), values });
    }
    tracks
}

/// Position of the gnome at a time of the stroll, and position and direction of the camera.
fn stroll(seconds: f64) -> (DVec3, DVec3, DVec3) {
    let gnome = HEADING * STRIDE * (seconds - 1.0);
    let t = smoothstep(0.0, 2.0, seconds);
    let eye = DVec3::new(gnome.x * 0.9 + 0.75 - 0.55 * t, 0.78 - 0.06 * t, 3.45 - 0.15 * t);
    (gnome, eye, DVec3::new(gnome.x * 0.9 + 0.02, 0.68, gnome.z))
}

fn stroll_tracks(root: usize, camera: usize) -> Vec<Track> {
    let times: Vec<f64> = (0..=2 * CYCLE).map(|frame| f64::from(frame) / 24.0).collect();
    let views: Vec<_> = times.iter().map(|time| stroll(*time)).collect();
    let gnome = views.iter().flat_map(|(gnome, _, _)| gnome.to_array()).collect();
    let eyes = views.iter().flat_map(|(_, eye, _)| eye.to_array()).collect();
    let turns = views.iter().flat_map(|(_, eye, target)| looking(*target - *eye).to_array()).collect();
    vec![
        Track { node: root, path: "translation", times: times.clone(), values: gnome },
        Track { node: camera, path: "translation", times: times.clone(), values: eyes },
        Track { node: camera, path: "rotation", times, values: turns },
    ]
}

/// The glTF binary file.
///
/// # Errors
/// If a texture cannot be encoded.
pub(crate) fn scene() -> Result<Vec<u8>, ImageError> {
    let mut glb = Glb::default();
    let facing = DQuat::from_rotation_y(50_f64.to_radians());
    let (gnome, eye, target) = stroll(0.0);
    let root = glb.node(json!({
        "name": "Gnome", "translation": numbers(&gnome.to_array()), "rotation": numbers(&facing.to_array()),
    }));
    let joints = add_joints(&mut glb, root);
    add_gnome(&mut glb, root, &joints)?;
    add_meadow(&mut glb)?;

    let lens = glb.camera(json!({
        "name": "ShotCam", "type": "perspective",
        "perspective": { "yfov": 0.5, "znear": 0.1, "zfar": 50.0, "aspectRatio": 16.0 / 9.0 },
    }));
    let mut node = placed(eye, target - eye);
    node["name"] = json!("ShotCam");
    node["camera"] = json!(lens);
    let camera = glb.node(node);

    let lamp = |color: [f64; 3], lux: f64| json!({ "type": "directional", "color": numbers(&color), "intensity": lux });
    glb.light("Sun", DVec3::new(-0.55, -0.75, -0.55), lamp([1.0, 0.90, 0.74], 2.7));
    glb.light("Fill", DVec3::new(0.8, -0.2, -0.5), lamp([0.70, 0.84, 1.0], 0.9));
    glb.light("Rim", DVec3::new(0.5, -0.5, 0.8), lamp([1.0, 0.86, 0.66], 2.6));

    let mut tracks = joint_tracks(&joints, 2 * CYCLE);
    tracks.extend(stroll_tracks(root, camera));
    glb.clip("Stroll", &tracks);
    glb.clip("Walk", &joint_tracks(&joints, CYCLE));
    Ok(glb.bytes("CC0"))
}
