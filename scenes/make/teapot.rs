//! The teapot scene: Newell's patches, glazed, on a table that merges into the wall behind it.
//!
//! Out: teapot.glb with the nodes `Teapot` (530 vertices, 1 primitive), `Table`, `ShotCam` and three lights.

use super::glb::{Glb, Surface, numbers, placed};
use super::paint::{png, smoothstep};
use super::patch::{Patch, flipped, mapped, tessellate};
use super::teapot_data::{HANDLE, HalfRing, LID, POT, Ring, SPOUT};
use glam::{DVec2, DVec3};
use image::ImageError;
use serde_json::json;

/// Metres per unit of Newell's data: the pot is 16 cm high.
const METRES: f64 = 0.05;

/// Quads per side of a patch, chosen for 530 vertices as in the paper's figure.
const STEPS: u32 = 4;

/// Converts Newell's axes, where z points up, to those of glTF.
fn scene_from_newell(point: DVec3) -> DVec3 {
    DVec3::new(point.x, point.z, -point.y) * METRES
}

/// For each group of four rings, a patch of a quarter circle and its three copies around the axis.
fn revolved(rings: &[Ring]) -> Vec<Patch> {
    let quarter = |[radius, arm, height]: Ring| {
        [(radius, 0.0), (radius, arm), (arm, radius), (0.0, radius)].map(|(x, y)| DVec3::new(x, y, height))
    };
    let mut patches = Vec::new();
    for start in (0..rings.len() - 1).step_by(3) {
        let patch: Patch = std::array::from_fn(|row| quarter(rings[start + row]));
        let turns: [fn(DVec3) -> DVec3; 4] =
            [|p| p, |p| DVec3::new(-p.y, p.x, p.z), |p| DVec3::new(-p.x, -p.y, p.z), |p| DVec3::new(p.y, -p.x, p.z)];
        patches.extend(turns.map(|turn| mapped(&patch, |point| scene_from_newell(turn(point)))));
    }
    patches
}

/// For each group of four half rings, a patch and its mirror image.
fn tube(rings: &[HalfRing]) -> Vec<Patch> {
    let half = |[inner_x, inner_z, outer_x, outer_z, breadth]: HalfRing| {
        let (inner, outer) = (DVec3::new(inner_x, 0.0, inner_z), DVec3::new(outer_x, 0.0, outer_z));
        let aside = DVec3::new(0.0, -breadth, 0.0);
        [inner, inner + aside, outer + aside, outer]
    };
    let mut patches = Vec::new();
    for start in (0..rings.len() - 1).step_by(3) {
        let near: Patch = std::array::from_fn(|row| half(rings[start + row]));
        let far = mapped(&near, |point| scene_from_newell(point * DVec3::new(1.0, -1.0, 1.0)));
        patches.extend([mapped(&near, scene_from_newell), flipped(&far)]);
    }
    patches
}

/// The teapot: four parts without shared vertices.
pub(crate) fn teapot() -> Surface {
    let flipped_all = |patches: Vec<Patch>| patches.iter().map(flipped).collect();
    let parts: [Vec<Patch>; 4] = [revolved(&POT), revolved(&LID), flipped_all(tube(&HANDLE)), tube(&SPOUT)];
    let mut all = Surface::default();
    for part in parts {
        let part = tessellate(&part, STEPS);
        let first = all.positions.len() as u32;
        all.positions.extend(part.positions);
        all.normals.extend(part.normals);
        all.triangles.extend(part.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }
    all
}

/// Table and wall as one bent surface, 2.4 m wide; v runs from the table's front edge to the top of the wall.
fn table() -> Surface {
    const ROWS: u32 = 24;
    let mut sheet = Surface::default();
    for row in 0..=ROWS {
        let v = f64::from(row) / f64::from(ROWS);
        let bend = ((v - 0.55) / 0.2).clamp(0.0, 1.0) * std::f64::consts::FRAC_PI_2;
        let z = 0.6 - 1.0 * v.min(0.55) / 0.55 - 0.3 * bend.sin();
        let y = 0.3 * (1.0 - bend.cos()) + 1.2 * (v - 0.75).max(0.0);
        for u in [0.0, 1.0] {
            sheet.positions.push(DVec3::new(2.4 * (u - 0.5), y, z));
            sheet.normals.push(DVec3::new(0.0, bend.cos(), bend.sin()));
            sheet.uvs.push(DVec2::new(u, v));
        }
    }
    for row in 0..ROWS {
        let at = 2 * row;
        sheet.triangles.extend([[at, at + 1, at + 3], [at, at + 3, at + 2]]);
    }
    sheet
}

/// Texture of table and wall: warm linen, a pool of light, and the pot's shadow painted under it.
fn linen(uv: DVec2) -> DVec3 {
    let (x, z) = (2.4 * (uv.x - 0.5), 0.6 - uv.y / 0.55);
    let pool = 1.0 - smoothstep(0.05, 0.75, DVec2::new(x * 0.8, (uv.y - 0.5) * 1.2).length());
    let base = DVec3::new(0.20, 0.15, 0.12).lerp(DVec3::new(0.66, 0.55, 0.44), pool);
    let contact = 1.0 - smoothstep(0.6, 1.25, DVec2::new(x, z).length() / 0.085);
    let cast = 1.0 - smoothstep(0.2, 1.5, DVec2::new((x - 0.05) / 0.17, (z + 0.035) / 0.10).length());
    base * (1.0 - 0.55 * contact) * (1.0 - 0.45 * cast)
}

/// The glTF binary file.
///
/// # Errors
/// If the texture cannot be encoded.
pub(crate) fn scene() -> Result<Vec<u8>, ImageError> {
    let mut glb = Glb::default();
    let glaze = glb.material(json!({
        "name": "Glaze", "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.022, 0.235, 0.27, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.25,
        },
    }));
    let texture = glb.texture("Linen", &png(384, 256, linen)?);
    let cloth = glb.material(json!({
        "name": "Linen", "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": texture }, "metallicFactor": 0.0 },
    }));
    let pot = glb.mesh("Teapot", &[Surface { material: glaze, ..teapot() }]);
    let sheet = glb.mesh("Table", &[Surface { material: cloth, ..table() }]);
    glb.node(json!({ "name": "Teapot", "mesh": pot }));
    glb.node(json!({ "name": "Table", "mesh": sheet }));

    let camera = glb.camera(json!({
        "name": "ShotCam", "type": "perspective",
        "perspective": { "yfov": 0.315, "znear": 0.05, "zfar": 10.0, "aspectRatio": 16.0 / 9.0 },
    }));
    let (eye, target) = (DVec3::new(0.02, 0.27, 0.82), DVec3::new(0.018, 0.092, 0.0));
    let mut node = placed(eye, target - eye);
    node["name"] = json!("ShotCam");
    node["camera"] = json!(camera);
    glb.node(node);

    let lamp = |color: [f64; 3], lux: f64| json!({ "type": "directional", "color": numbers(&color), "intensity": lux });
    glb.light("Key", DVec3::new(0.55, -0.75, -0.6), lamp([1.0, 0.94, 0.85], 3.4));
    glb.light("Fill", DVec3::new(-0.8, -0.15, -0.5), lamp([0.75, 0.87, 1.0], 0.9));
    glb.light("Rim", DVec3::new(-0.35, -0.5, 0.8), lamp([1.0, 0.97, 0.92], 3.0));
    Ok(glb.bytes("Teapot data: Martin Newell, 1975. Everything else: CC0"))
}
