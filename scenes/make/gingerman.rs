//! The gingerman scene: a layered flat character after the paper's, with isolated parts in front of the body.
//!
//! Out: gingerman.glb. Nodes: `Gingerman` with the children `Shadow`, `Body`, `EyeLeft`, `EyeRight`, `Mouth`,
//! `Buttons`; `Cloth`; `ShotCam` (orthographic). All materials are unlit.

use super::glb::{Glb, Surface, placed};
use super::outline::{contour, fill, gradient, triangulate};
use super::paint::{Rgba, png, png_rgba, smoothstep};
use glam::{DVec2, DVec3, FloatExt as _};
use image::ImageError;
use serde_json::{Value, json};

/// Half the visible height, metres.
const YMAG: f64 = 1.72;

/// Distance to a capsule whose radius changes from `r0` to `r1`, negative inside.
fn capsule(at: DVec2, from: DVec2, to: DVec2, [r0, r1]: [f64; 2]) -> f64 {
    let axis = to - from;
    let share = ((at - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    at.distance(from + axis * share) - (r0 + (r1 - r0) * share)
}

/// Smooth minimum (I. Quílez's quadratic polynomial): blends over `reach`.
fn blended(a: f64, b: f64, reach: f64) -> f64 {
    let overlap = (1.0 - (a - b).abs() / reach).max(0.0);
    a.min(b) - overlap * overlap * reach * 0.25
}

/// Distance to the gingerman's silhouette, negative inside; metres.
pub(crate) fn silhouette(at: DVec2) -> f64 {
    let half = DVec2::new(at.x.abs(), at.y);
    let mirrored = DVec2::new(-half.x, at.y);
    let head = DVec2::new(at.x, (at.y - 0.90) * 1.04).length() - 0.55;
    let torso = capsule(at, DVec2::new(0.0, 0.18), DVec2::new(0.0, -0.42), [0.36, 0.42]);
    let arm = capsule(half, ARM.0, ARM.1, [0.21, 0.25]);
    let leg = |at: DVec2| capsule(at, DVec2::new(0.20, -0.55), DVec2::new(0.46, -1.26), [0.24, 0.28]);
    let trunk = blended(torso, arm, 0.22);
    let legs = blended(leg(half), leg(mirrored), 0.16);
    blended(blended(trunk, legs, 0.16), head, 0.14)
}

/// Shoulder and hand.
const ARM: (DVec2, DVec2) = (DVec2::new(0.2, 0.16), DVec2::new(1.08, -0.10));

/// Lower left corner and size of the square that the body's texture covers.
const SHEET: (DVec2, f64) = (DVec2::new(-1.7, -1.8), 3.4);

fn uv(at: DVec2) -> DVec2 {
    let unit = (at - SHEET.0) / SHEET.1;
    DVec2::new(unit.x, 1.0 - unit.y)
}

fn place(uv: DVec2) -> DVec2 {
    SHEET.0 + DVec2::new(uv.x, 1.0 - uv.y) * SHEET.1
}

/// Distance to the piped icing: waves across wrists and ankles.
fn icing(at: DVec2) -> f64 {
    let half = DVec2::new(at.x.abs(), at.y);
    let cuff = |middle: DVec2, along: DVec2, waves: f64| {
        let local = half - middle;
        let (t, s) = (local.dot(along), local.dot(along.perp()));
        let swing = 0.045 * triangle_wave(s * waves);
        ((t - swing).abs() * 0.78 - 0.024).max(s.abs() - 0.4)
    };
    let wrist = cuff(ARM.0.lerp(ARM.1, 0.86), (ARM.1 - ARM.0).normalize(), 6.0);
    let ankle = cuff(DVec2::new(0.40, -1.13), DVec2::new(0.344, -0.939), 6.0);
    wrist.min(ankle).max(silhouette(at) + 0.055)
}

/// A smooth wave between −1 and 1 of period 1, made of parabolas.
fn triangle_wave(phase: f64) -> f64 {
    let t = phase.rem_euclid(1.0) * 2.0;
    if t < 1.0 { 4.0 * t * (1.0 - t) } else { -4.0 * (t - 1.0) * (2.0 - t) }
}

/// Smooth noise in 0..=1 with one bump per unit.
fn speckle(at: DVec2) -> f64 {
    let hash = |cell: DVec2| {
        let [x, y] = cell.as_i64vec2().to_array();
        let mixed = (x.wrapping_mul(374_761_393) + y.wrapping_mul(668_265_263)).wrapping_mul(1_274_126_177);
        f64::from(((mixed >> 16) & 0xffff) as u32) / 65535.0
    };
    let (cell, t) = (at.floor(), at - at.floor());
    let t = t * t * (DVec2::splat(3.0) - 2.0 * t);
    let row = |y: f64| hash(cell + DVec2::new(0.0, y)).lerp(hash(cell + DVec2::new(1.0, y)), t.x);
    row(0.0).lerp(row(1.0), t.y)
}

/// Shading of a rounded border of this width, lit from the upper left: −1..=1.
fn bevel(at: DVec2, field: fn(DVec2) -> f64, width: f64) -> f64 {
    let depth = (-field(at) / width).clamp(0.0, 1.0);
    let outwards = gradient(field, at).normalize_or_zero();
    (1.0 - depth) * (1.0 - depth) * outwards.dot(DVec2::new(-0.55, 0.835))
}

/// The body's texture: dough, baked darker at the border, blush, icing; masked to the silhouette.
fn dough(uv: DVec2) -> Rgba {
    let at = place(uv);
    let border = silhouette(at);
    let grain = 0.5 * speckle(at * 9.0) + 0.5 * speckle(at * 23.0);
    let baked = smoothstep(-0.16, 0.0, border);
    let mut color = DVec3::new(0.52, 0.215, 0.062).lerp(DVec3::new(0.30, 0.095, 0.022), baked);
    color *= 0.90 + 0.2 * grain;
    color *= 1.0 + 0.42 * bevel(at, silhouette, 0.20);
    let cheek = DVec2::new((at.x.abs() - 0.31) / 0.12, (at.y - 0.78) / 0.09).length();
    color = color.lerp(DVec3::new(0.72, 0.14, 0.09), 0.65 * (1.0 - smoothstep(0.2, 1.0, cheek)));
    let piping = icing(at);
    let under = 1.0 - smoothstep(0.0, 0.035, icing(at + DVec2::new(-0.012, 0.02)));
    color *= 1.0 - 0.4 * under;
    let glazed = DVec3::new(0.93, 0.88, 0.80) * (0.86 + 0.25 * bevel(at, icing, 0.03));
    color = color.lerp(glazed, 1.0 - smoothstep(-0.006, 0.006, piping));
    Rgba { color, alpha: 0.5 - border * SHEET_SHARPNESS }
}

/// Slope of alpha across the silhouette, per metre: 1 over a few texels, so that the mask has a smooth border.
const SHEET_SHARPNESS: f64 = 40.0;

/// The soft shadow on the cloth.
fn shade(uv: DVec2) -> Rgba {
    let border = silhouette(place(uv));
    Rgba { color: DVec3::new(0.05, 0.02, 0.03), alpha: 0.5 * (1.0 - smoothstep(-0.14, 0.13, border)) }
}

/// The gingham cloth, darker towards the corners.
fn gingham(uv: DVec2) -> DVec3 {
    let at = DVec2::new(uv.x - 0.5, uv.y - 0.5) * 14.0;
    let stripe = |x: f64| if (x + 0.5).rem_euclid(2.0) < 1.0 { 1.0 } else { 0.0 };
    let threads = (stripe(at.x) + stripe(at.y)) * 0.5;
    let color = DVec3::new(0.80, 0.86, 0.80).lerp(DVec3::new(0.34, 0.62, 0.56), threads);
    color * (1.0 - 0.45 * smoothstep(0.25, 0.75, (uv - 0.5).length()))
}

/// A flat surface at height z that faces the camera.
fn flat(points: &[DVec2], z: f64, triangles: Vec<[u32; 3]>, material: usize) -> Surface {
    Surface {
        positions: points.iter().map(|point| point.extend(z)).collect(),
        normals: vec![DVec3::Z; points.len()],
        triangles,
        material,
        ..Surface::default()
    }
}

/// Points and triangles of the silhouette grown by `margin`.
fn cutout(margin: f64, border: usize, spacing: f64) -> (Vec<DVec2>, Vec<[u32; 3]>) {
    let mut points = contour(silhouette, margin, DVec2::new(0.0, 1.45), border);
    points.extend(fill(silhouette, margin - spacing * 0.55, spacing));
    let triangles = triangulate(&points, |at| silhouette(at) - margin);
    (points, triangles)
}

fn textured(shape: &(Vec<DVec2>, Vec<[u32; 3]>), z: f64, material: usize) -> Surface {
    Surface { uvs: shape.0.iter().map(|point| uv(*point)).collect(), ..flat(&shape.0, z, shape.1.clone(), material) }
}

/// An ellipse made of a triangle fan: a bright centre, displaced by `lean` times the radii, and a rim.
struct Disc {
    center: DVec3,
    radii: DVec2,
    lean: DVec2,
    corners: usize,
    colors: [DVec3; 2],
}

fn add_disc(surface: &mut Surface, disc: &Disc) {
    let first = surface.positions.len() as u32;
    let corners = disc.corners as u32;
    let mut add = |place: DVec2, color: DVec3| {
        surface.positions.push(disc.center + (place * disc.radii).extend(0.0));
        surface.normals.push(DVec3::Z);
        surface.colors.push(color);
    };
    add(disc.lean, disc.colors[0]);
    for index in 0..disc.corners {
        let angle = std::f64::consts::TAU * index as f64 / disc.corners as f64;
        add(DVec2::from_angle(angle), disc.colors[1]);
    }
    surface.triangles.extend((0..corners).map(|at| [first, first + 1 + at, first + 1 + (at + 1) % corners]));
}

fn eye(side: f64, material: usize) -> Surface {
    let mut surface = Surface { material, ..Surface::default() };
    let center = DVec3::new(0.185 * side, 0.96, 0.02);
    let dark = DVec3::new(0.022, 0.008, 0.006);
    let pupil = Disc {
        center,
        radii: DVec2::new(0.075, 0.105),
        lean: DVec2::new(0.0, -0.35),
        corners: 16,
        colors: [DVec3::new(0.10, 0.035, 0.02), dark],
    };
    let white = DVec3::splat(0.95);
    let glint = Disc {
        center: center + DVec3::new(-0.022, 0.045, 0.005),
        radii: DVec2::splat(0.027),
        lean: DVec2::ZERO,
        corners: 7,
        colors: [white, white],
    };
    add_disc(&mut surface, &pupil);
    add_disc(&mut surface, &glint);
    surface
}

/// A smile of icing: a bent band with thin ends.
fn mouth(material: usize) -> Surface {
    const SPANS: u32 = 8;
    let mut surface = Surface { material, ..Surface::default() };
    for step in 0..=SPANS {
        let s = f64::from(step) / f64::from(SPANS) * 2.0 - 1.0;
        let (middle, slope) = (DVec2::new(0.25 * s, 0.625 + 0.13 * s * s), DVec2::new(0.25, 0.26 * s));
        let across = slope.perp().normalize() * (0.030 * (1.0 - 0.55 * s * s));
        for (side, color) in [(-1.0, DVec3::new(0.75, 0.66, 0.58)), (1.0, DVec3::new(0.97, 0.94, 0.90))] {
            surface.positions.push((middle + across * side).extend(0.02));
            surface.normals.push(DVec3::Z);
            surface.colors.push(color);
        }
    }
    for at in (0..2 * SPANS).step_by(2) {
        surface.triangles.extend([[at, at + 2, at + 3], [at, at + 3, at + 1]]);
    }
    surface
}

fn buttons(material: usize) -> Surface {
    let mut surface = Surface { material, ..Surface::default() };
    let candies = [
        (0.16, DVec3::new(0.95, 0.22, 0.20), DVec3::new(0.52, 0.02, 0.03)),
        (-0.14, DVec3::new(0.98, 0.80, 0.28), DVec3::new(0.78, 0.36, 0.03)),
        (-0.44, DVec3::new(0.45, 0.85, 0.42), DVec3::new(0.07, 0.36, 0.10)),
    ];
    for (y, bright, dark) in candies {
        let disc = Disc {
            center: DVec3::new(0.0, y, 0.02),
            radii: DVec2::splat(0.082),
            lean: DVec2::new(-0.3, 0.35),
            corners: 14,
            colors: [bright, dark],
        };
        add_disc(&mut surface, &disc);
    }
    surface
}

/// All surfaces of the character with the names of their nodes, from back to front. Materials: body, shadow, paint.
pub(crate) fn parts([body, shadow, paint]: [usize; 3]) -> Vec<(&'static str, Surface)> {
    let below = cutout(0.14, 44, 0.55);
    let cookie = cutout(0.025, 76, 0.25);
    let mut shade = textured(&below, -0.1, shadow);
    for position in &mut shade.positions {
        *position += DVec3::new(0.045, -0.065, 0.0);
    }
    vec![
        ("Shadow", shade),
        ("Body", textured(&cookie, 0.0, body)),
        ("EyeLeft", eye(-1.0, paint)),
        ("EyeRight", eye(1.0, paint)),
        ("Mouth", mouth(paint)),
        ("Buttons", buttons(paint)),
    ]
}

fn unlit(name: &str, texture: Option<usize>, alpha: &str) -> Value {
    let mut material = json!({
        "name": name, "alphaMode": alpha, "extensions": { "KHR_materials_unlit": {} },
        "pbrMetallicRoughness": { "metallicFactor": 0.0 },
    });
    if let Some(texture) = texture {
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
    }
    material
}

/// The glTF binary file.
///
/// # Errors
/// If a texture cannot be encoded.
pub(crate) fn scene() -> Result<Vec<u8>, ImageError> {
    let mut glb = Glb::default();
    let textures = [
        glb.texture("Dough", &png_rgba(768, 768, dough)?),
        glb.texture("Shade", &png_rgba(96, 96, shade)?),
        glb.texture("Gingham", &png(448, 448, gingham)?),
    ];
    let body = glb.material(unlit("Dough", Some(textures[0]), "MASK"));
    let shadow = glb.material(unlit("Shadow", Some(textures[1]), "BLEND"));
    let paint = glb.material(unlit("Sugar", None, "OPAQUE"));
    let cloth = glb.material(unlit("Cloth", Some(textures[2]), "OPAQUE"));

    let root = glb.node(json!({ "name": "Gingerman" }));
    for (name, surface) in parts([body, shadow, paint]) {
        let mesh = glb.mesh(name, &[surface]);
        glb.child(root, json!({ "name": name, "mesh": mesh }));
    }
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
    let mut sheet = flat(&corners.map(|corner| corner * 2.4), -0.2, vec![[0, 1, 2], [0, 2, 3]], cloth);
    sheet.uvs = corners.map(|corner| corner * DVec2::new(0.5, -0.5) + 0.5).to_vec();
    let mesh = glb.mesh("Cloth", &[sheet]);
    glb.node(json!({ "name": "Cloth", "mesh": mesh }));

    let camera = glb.camera(json!({
        "name": "ShotCam", "type": "orthographic",
        "orthographic": { "xmag": YMAG, "ymag": YMAG, "znear": 0.1, "zfar": 10.0 },
    }));
    let mut node = placed(DVec3::new(0.0, -0.02, 3.0), DVec3::NEG_Z);
    node["name"] = json!("ShotCam");
    node["camera"] = json!(camera);
    glb.node(node);
    Ok(glb.bytes("CC0"))
}
