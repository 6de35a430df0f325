//! The hare scene: a closed mesh with about as many vertices as the paper's bunny, rotating on a turntable.
//!
//! Out: hare.glb. Nodes: `Turntable` (animated) with the child `Hare`, and below it `Eyes` and `Nose`; `Floor`;
//! `ShotCam`.

use super::fields::{blended, capsule, ellipsoid, mirrored};
use super::glb::{Glb, Surface, Track, numbers, placed};
use super::nets::{Region, lathe, skin_of};
use super::paint::smoothstep;
use glam::{DQuat, DVec2, DVec3};
use serde_json::json;

/// Side of a cell of the surface net, which determines the number of vertices.
const CELL: f64 = 0.0895;

/// The turntable rotates from minus to plus this angle during the clip, degrees.
const HALF_TURN: f64 = 65.0;

const fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Distance to the ears on both sides.
fn ears(at: DVec3) -> f64 {
    let half = mirrored(at);
    // Ears are flattened from front to back.
    let flat = v(half.x, half.y, half.z * 1.35);
    let root = capsule(flat, v(0.09, 0.98, -0.01), v(0.15, 1.25, -0.05), [0.075, 0.105]);
    blended(root, capsule(flat, v(0.15, 1.25, -0.05), v(0.185, 1.5, -0.09), [0.105, 0.055]), 0.03)
}

/// Distance to the hare's surface, metres.
fn hare(at: DVec3) -> f64 {
    let half = mirrored(at);
    let belly = ellipsoid(at, v(0.0, 0.36, -0.02), v(0.275, 0.33, 0.29));
    let chest = ellipsoid(at, v(0.0, 0.56, 0.02), v(0.19, 0.2, 0.19));
    let head = ellipsoid(at, v(0.0, 0.83, 0.05), v(0.215, 0.19, 0.2));
    let cheek = ellipsoid(half, v(0.075, 0.765, 0.19), v(0.1, 0.08, 0.09));
    let arm = capsule(half, v(0.2, 0.55, 0.07), v(0.235, 0.4, 0.24), [0.075, 0.08]);
    let thigh = ellipsoid(half, v(0.23, 0.2, -0.02), v(0.12, 0.18, 0.19));
    let foot = capsule(half, v(0.17, 0.085, 0.02), v(0.21, 0.08, 0.33), [0.085, 0.095]);
    let tail = ellipsoid(at, v(0.0, 0.2, -0.34), v(0.12, 0.115, 0.12));
    let trunk = blended(blended(belly, chest, 0.12), head, 0.06);
    let limbs = blended(trunk, arm, 0.05).min(blended(thigh, foot, 0.08));
    let face = blended(blended(limbs, cheek, 0.06), ears(at), 0.07);
    blended(blended(face, trunk.min(thigh), 0.04), tail, 0.03)
}

/// Fur: sandy, pale below and on the muzzle, with dark tips of the ears and pink insides.
fn fur(at: DVec3, normal: DVec3) -> DVec3 {
    let sand = v(0.47, 0.27, 0.13);
    let cream = v(0.86, 0.74, 0.60);
    let belly = 1.0 - smoothstep(0.75, 1.1, ((at - v(0.0, 0.38, 0.26)) / v(0.17, 0.24, 0.2)).length());
    let muzzle = 1.0 - smoothstep(0.7, 1.05, ((at - v(0.0, 0.76, 0.25)) / v(0.17, 0.1, 0.14)).length());
    let tail = 1.0 - smoothstep(0.95, 1.2, ((at - v(0.0, 0.2, -0.36)) / 0.13).length());
    let is_ear = smoothstep(1.06, 1.14, at.y);
    let inner = is_ear * smoothstep(0.25, 0.75, normal.z);
    let tip = smoothstep(1.44, 1.52, at.y);
    let plain = sand.lerp(cream, belly.max(muzzle).max(tail));
    plain.lerp(v(0.80, 0.36, 0.31), inner).lerp(v(0.11, 0.06, 0.04), tip)
}

/// The hare's closed mesh.
pub(crate) fn body(material: usize) -> Surface {
    // The plane of symmetry is a border between cells, so that left and right are equal.
    let region = Region { lo: v(-6.0 * CELL, -0.10, -0.55), hi: v(6.0 * CELL, 1.7, 0.55), cell: CELL };
    let mut surface = skin_of(hare, &region);
    surface.colors = surface.positions.iter().zip(&surface.normals).map(|(at, normal)| fur(*at, *normal)).collect();
    surface.material = material;
    surface
}

/// An ellipsoid with the given centre and radii.
fn ball(center: DVec3, radii: DVec3, material: usize) -> Surface {
    const ROWS: u32 = 8;
    let profile =
        (0..=ROWS).map(|row| DVec2::from_angle(std::f64::consts::PI * (0.5 - f64::from(row) / f64::from(ROWS))));
    let mut surface = lathe(&profile.collect::<Vec<_>>(), 12);
    surface.positions.iter_mut().for_each(|at| *at = center + *at * radii);
    surface.normals.iter_mut().for_each(|normal| *normal = (*normal / radii).normalize());
    Surface { uvs: Vec::new(), material, ..surface }
}

/// Both eyes in one mesh: dark balls with small bright highlights.
fn eyes([dark, bright]: [usize; 2]) -> [Surface; 2] {
    let pair = |at: DVec3, shift: DVec3, radius: f64, material: usize| {
        let mut left = ball(at + shift, DVec3::splat(radius), material);
        let right = ball(at * v(-1.0, 1.0, 1.0) + shift, DVec3::splat(radius), material);
        let first = left.positions.len() as u32;
        left.positions.extend(right.positions);
        left.normals.extend(right.normals);
        left.triangles.extend(right.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        left
    };
    let at = v(0.115, 0.885, 0.2);
    [pair(at, DVec3::ZERO, 0.043, dark), pair(at, v(0.012, 0.018, 0.032), 0.014, bright)]
}

/// Floor and wall as one bent surface, with a pool of light and a soft shadow in vertex colours.
fn floor(material: usize) -> Surface {
    const COLUMNS: u32 = 24;
    const ROWS: u32 = 24;
    let mut sheet = Surface { material, ..Surface::default() };
    for (row, column) in (0..=ROWS).flat_map(|row| (0..=COLUMNS).map(move |column| (row, column))) {
        let (u, t) = (f64::from(column) / f64::from(COLUMNS) - 0.5, f64::from(row) / f64::from(ROWS));
        let bend = ((t - 0.5) / 0.2).clamp(0.0, 1.0) * std::f64::consts::FRAC_PI_2;
        let z = 1.7 - 3.4 * t.min(0.5) / 0.5 - 0.9 * bend.sin();
        let at = v(6.4 * u, 0.9 * (1.0 - bend.cos()) + 6.0 * (t - 0.7).max(0.0), z);
        let pool = 1.0 - smoothstep(0.2, 2.9, v(at.x * 0.75, at.y * 0.7, at.z.min(0.0) * 0.35).length());
        let shadow = 1.0 - smoothstep(0.18, 0.75, v(at.x - 0.06, at.y, at.z + 0.03).length());
        let color = v(0.05, 0.085, 0.105).lerp(v(0.30, 0.46, 0.45), pool);
        sheet.positions.push(at);
        sheet.colors.push(color * (1.0 - 0.62 * shadow));
    }
    let stride = COLUMNS + 1;
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let at = row * stride + column;
        sheet.triangles.extend([[at, at + 1, at + stride + 1], [at, at + stride + 1, at + stride]]);
    }
    sheet
}

/// The glTF binary file.
pub(crate) fn scene() -> Vec<u8> {
    let mut glb = Glb::default();
    let plain = |name: &str, color: [f64; 4], roughness: f64| {
        json!({ "name": name, "pbrMetallicRoughness": {
            "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": roughness } })
    };
    let fur = glb.material(plain("Fur", [1.0; 4], 0.85));
    let dark = glb.material(plain("Eye", [0.012, 0.009, 0.008, 1.0], 0.15));
    let bright = glb.material(json!({ "name": "Glint", "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "metallicFactor": 0.0 } }));
    let pink = glb.material(plain("Nose", [0.55, 0.16, 0.15, 1.0], 0.4));
    let painted = glb.material(json!({ "name": "Floor", "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "metallicFactor": 0.0 } }));

    let turntable = glb.node(json!({ "name": "Turntable" }));
    let mesh = glb.mesh("Hare", &[body(fur)]);
    let hare = glb.child(turntable, json!({ "name": "Hare", "mesh": mesh }));
    let mesh = glb.mesh("Eyes", &eyes([dark, bright]));
    glb.child(hare, json!({ "name": "Eyes", "mesh": mesh }));
    let mesh = glb.mesh("Nose", &[ball(v(0.0, 0.815, 0.275), v(0.042, 0.03, 0.03), pink)]);
    glb.child(hare, json!({ "name": "Nose", "mesh": mesh }));
    let mesh = glb.mesh("Floor", &[floor(painted)]);
    glb.node(json!({ "name": "Floor", "mesh": mesh }));
    let turned = |degrees: f64| DQuat::from_rotation_y(degrees.to_radians()).to_array();
    let values = [-HALF_TURN, 0.0, HALF_TURN].iter().flat_map(|angle| turned(*angle)).collect();
    glb.clip("Turn", &[Track { node: turntable, path: "rotation", times: vec![0.0, 0.5, 1.0], values }]);

    let camera = glb.camera(json!({ "name": "ShotCam", "type": "perspective",
        "perspective": { "yfov": 0.45, "znear": 0.1, "zfar": 30.0, "aspectRatio": 1.0 } }));
    let (eye, target) = (v(0.0, 1.4, 4.6), v(0.0, 0.79, 0.0));
    let mut node = placed(eye, target - eye);
    node["name"] = json!("ShotCam");
    node["camera"] = json!(camera);
    glb.node(node);
    let lamp = |color: [f64; 3], lux: f64| json!({ "type": "directional", "color": numbers(&color), "intensity": lux });
    glb.light("Key", v(0.6, -0.75, -0.7), lamp([1.0, 0.94, 0.84], 3.3));
    glb.light("Fill", v(-0.8, -0.2, -0.5), lamp([0.72, 0.86, 1.0], 0.9));
    glb.light("Rim", v(-0.35, -0.45, 0.85), lamp([0.95, 0.98, 1.0], 2.6));
    glb.bytes("CC0")
}
