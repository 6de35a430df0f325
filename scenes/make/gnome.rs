//! The gnome's body: coat, trousers, boots, mittens, head, beard and hat, with joint weights.
//!
//! Out: surfaces in the rest pose of [`super::rig`]; the gnome looks along +z and its soles are at y = 0.

use super::fields::{blended, block, capsule, ellipsoid, mirrored, ring};
use super::glb::Surface;
use super::nets::{Region, lathe, skin_of};
use super::paint::smoothstep;
use super::rig::{HAT, HEAD, joint_weights};
use glam::{DVec2, DVec3};

/// Indices of the gnome's materials in the file.
#[derive(Clone, Copy)]
pub(crate) struct Cloths {
    pub(crate) coat: usize,
    pub(crate) trousers: usize,
    pub(crate) leather: usize,
    pub(crate) mitten: usize,
    pub(crate) gold: usize,
    pub(crate) fur: usize,
    pub(crate) skin: usize,
    pub(crate) knit: usize,
    pub(crate) eye: usize,
    pub(crate) glint: usize,
}

const TRUNK: [usize; 7] = [0, 1, 2, 5, 6, 7, 8];
const WAIST: [usize; 2] = [0, 1];
const LEGS: [usize; 7] = [0, 9, 10, 11, 12, 13, 14];
const FEET: [usize; 4] = [10, 11, 13, 14];
const HANDS: [usize; 2] = [6, 8];

const fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn torso(at: DVec3) -> f64 {
    let belly = ellipsoid(at, v(0.0, 0.42, 0.012), v(0.205, 0.19, 0.195));
    blended(belly, capsule(at, v(0.0, 0.46, 0.0), v(0.0, 0.62, -0.005), [0.165, 0.115]), 0.12)
}

fn coat(at: DVec3) -> f64 {
    let half = mirrored(at);
    let upper = capsule(half, v(0.14, 0.605, 0.0), v(0.275, 0.49, 0.0), [0.078, 0.07]);
    let lower = capsule(half, v(0.275, 0.49, 0.0), v(0.36, 0.375, 0.028), [0.07, 0.068]);
    blended(torso(at), blended(upper, lower, 0.04), 0.09)
}

fn trousers(at: DVec3) -> f64 {
    let half = mirrored(at);
    let thigh = capsule(half, v(0.10, 0.33, 0.0), v(0.105, 0.20, 0.01), [0.083, 0.08]);
    blended(thigh, capsule(half, v(0.105, 0.20, 0.01), v(0.11, 0.12, 0.0), [0.08, 0.07]), 0.03)
}

fn boots(at: DVec3) -> f64 {
    let half = mirrored(at);
    let shaft = capsule(half, v(0.11, 0.15, -0.005), v(0.11, 0.07, -0.005), [0.08, 0.072]);
    let foot = capsule(half, v(0.11, 0.06, -0.01), v(0.122, 0.055, 0.105), [0.070, 0.074]);
    let toe = capsule(half, v(0.122, 0.075, 0.13), v(0.124, 0.11, 0.165), [0.05, 0.024]);
    blended(blended(shaft, foot, 0.05), toe, 0.06).max(-at.y).max(at.y - 0.185)
}

fn mittens(at: DVec3) -> f64 {
    let half = mirrored(at);
    let palm = capsule(half, v(0.382, 0.345, 0.036), v(0.405, 0.295, 0.045), [0.058, 0.062]);
    blended(palm, capsule(half, v(0.375, 0.335, 0.05), v(0.365, 0.30, 0.105), [0.03, 0.026]), 0.025)
}

fn cuffs(at: DVec3) -> f64 {
    let half = mirrored(at);
    let wrist = capsule(half, v(0.355, 0.382, 0.027), v(0.368, 0.364, 0.031), [0.079, 0.079]);
    wrist.min(ring(at - v(0.0, 0.0, 0.012), 0.168, 0.285, 0.042))
}

fn face(at: DVec3) -> f64 {
    let skull = ellipsoid(at, v(0.0, 0.80, 0.0), v(0.195, 0.185, 0.185));
    let nose = ellipsoid(at, v(0.0, 0.765, 0.205), v(0.062, 0.056, 0.058));
    let ear = ellipsoid(mirrored(at), v(0.20, 0.795, -0.01), v(0.045, 0.055, 0.03));
    blended(blended(skull, nose, 0.03), ear, 0.03)
}

fn beard(at: DVec3) -> f64 {
    let half = mirrored(at);
    let bib = capsule(at, v(0.0, 0.685, 0.125), v(0.0, 0.475, 0.225), [0.135, 0.03]);
    let jaw = capsule(half, v(0.165, 0.80, 0.045), v(0.09, 0.66, 0.13), [0.04, 0.085]);
    let lip = capsule(half, v(0.015, 0.722, 0.218), v(0.135, 0.695, 0.17), [0.043, 0.02]);
    let brow = capsule(half, v(0.05, 0.893, 0.172), v(0.122, 0.876, 0.142), [0.022, 0.015]);
    let hair = ellipsoid(at, v(0.0, 0.80, -0.03), v(0.205, 0.17, 0.185)).max(at.z + 0.02 - 0.25 * (at.y - 0.8));
    blended(blended(blended(bib, jaw, 0.06), hair, 0.03), lip, 0.012).min(brow)
}

fn brim(at: DVec3) -> f64 {
    ring(at, 0.172, 0.940, 0.043)
}

fn bobble(at: DVec3) -> f64 {
    at.distance(v(0.0, 1.397, -0.13)) - 0.055
}

fn buckle(at: DVec3) -> f64 {
    let center = v(0.0, 0.425, 0.222);
    block(at, center, v(0.045, 0.038, 0.014), 0.008).max(-block(at, center, v(0.026, 0.019, 0.05), 0.004))
}

/// The surface of a field within a box, with weights of the given joints.
fn cut(field: fn(DVec3) -> f64, [lo, hi]: [DVec3; 2], cell: f64, joints: &[usize], material: usize) -> Surface {
    let surface = skin_of(field, &Region { lo, hi, cell });
    bound(Surface { material, ..surface }, joints)
}

fn bound(mut surface: Surface, joints: &[usize]) -> Surface {
    surface.joint_weights = surface.positions.iter().map(|at| joint_weights(*at, joints)).collect();
    surface
}

/// A strap around the belly.
fn belt(material: usize) -> Surface {
    let radius = |height: f64| {
        (0..400).map(|step| 0.1 + 0.0005 * f64::from(step)).find(|r| torso(v(0.0, height, *r)) > 0.0).unwrap_or(0.2)
    };
    let profile: Vec<DVec2> = [(0.457, -0.006), (0.453, 0.008), (0.44, 0.0125), (0.41, 0.0125), (0.397, 0.008)]
        .into_iter()
        .chain([(0.393, -0.006)])
        .map(|(height, out)| DVec2::new(radius(height) - 0.008 + out, height))
        .collect();
    let mut strap = lathe(&profile, 40);
    for position in &mut strap.positions {
        // The belly is not exactly round.
        *position = v(position.x * 1.03, position.y, position.z) + v(0.0, 0.0, 0.012 * 0.5);
    }
    bound(Surface { material, ..strap }, &WAIST)
}

/// The node `Legs`: trousers and boots.
pub(crate) fn legs(cloths: Cloths) -> Vec<Surface> {
    vec![
        cut(trousers, [v(-0.24, 0.02, -0.14), v(0.24, 0.46, 0.14)], 0.028, &LEGS, cloths.trousers),
        cut(boots, [v(-0.24, -0.03, -0.12), v(0.24, 0.25, 0.23)], 0.022, &FEET, cloths.leather),
    ]
}

/// The node `Body`: coat, mittens, fur and belt.
pub(crate) fn body(cloths: Cloths) -> Vec<Surface> {
    vec![
        cut(coat, [v(-0.48, 0.20, -0.24), v(0.48, 0.76, 0.26)], 0.027, &TRUNK, cloths.coat),
        cut(mittens, [v(-0.5, 0.2, -0.06), v(0.5, 0.44, 0.16)], 0.018, &HANDS, cloths.mitten),
        cut(cuffs, [v(-0.48, 0.22, -0.26), v(0.48, 0.5, 0.28)], 0.025, &[0, 1, 6, 8], cloths.fur),
        belt(cloths.leather),
        cut(buckle, [v(-0.06, 0.37, 0.19), v(0.06, 0.48, 0.25)], 0.011, &WAIST, cloths.gold),
    ]
}

/// The node `Face`, reddish at nose, cheeks and ears.
pub(crate) fn head(cloths: Cloths) -> Vec<Surface> {
    let mut skin = cut(face, [v(-0.28, 0.58, -0.22), v(0.28, 1.02, 0.3)], 0.022, &[HEAD], cloths.skin);
    let rosy = |at: &DVec3| {
        let half = mirrored(*at);
        let near = |center: DVec3, reach: f64| 1.0 - smoothstep(0.3 * reach, reach, half.distance(center));
        let blush = near(v(0.0, 0.765, 0.23), 0.085).max(near(v(0.115, 0.755, 0.155), 0.075));
        let blush = blush.max(near(v(0.23, 0.80, 0.0), 0.06));
        v(0.82, 0.46, 0.30).lerp(v(0.83, 0.20, 0.13), 0.75 * blush)
    };
    skin.colors = skin.positions.iter().map(rosy).collect();
    vec![skin]
}

/// The node `Beard`: beard, moustache and brows.
pub(crate) fn whiskers(cloths: Cloths) -> Vec<Surface> {
    vec![cut(beard, [v(-0.26, 0.4, -0.26), v(0.26, 1.0, 0.3)], 0.023, &[HEAD], cloths.fur)]
}

/// The node `Hat`: a knitted cone that leans back, with brim and bobble.
pub(crate) fn hat(cloths: Cloths) -> Vec<Surface> {
    let profile: Vec<DVec2> = (0..=20)
        .map(|row| {
            let t = f64::from(row) / 20.0;
            DVec2::new(0.014 + 0.168 * (t.powf(0.85) + 0.10 * (t * std::f64::consts::PI).sin()), 1.395 - 0.46 * t)
        })
        .collect();
    let mut cone = lathe(&profile, 36);
    for position in &mut cone.positions {
        position.z -= 0.13 * smoothstep(0.925, 1.475, position.y).sqrt() * smoothstep(0.925, 1.395, position.y);
    }
    let mut parts = vec![
        Surface { material: cloths.knit, ..cone },
        Surface {
            material: cloths.fur,
            ..skin_of(brim, &Region { lo: v(-0.25, 0.87, -0.25), hi: v(0.25, 1.01, 0.25), cell: 0.025 })
        },
        Surface {
            material: cloths.fur,
            ..skin_of(bobble, &Region { lo: v(-0.08, 1.31, -0.21), hi: v(0.08, 1.48, -0.05), cell: 0.02 })
        },
    ];
    for part in &mut parts {
        let share = |at: &DVec3| smoothstep(1.0, 1.26, at.y);
        part.joint_weights = (part.positions.iter())
            .map(|at| [(HEAD as u8, 1.0 - share(at)), (HAT as u8, share(at)), (0, 0.0), (0, 0.0)])
            .collect();
    }
    parts
}

/// An eye in its own coordinates, with a highlight.
pub(crate) fn eye(cloths: Cloths) -> Vec<Surface> {
    let ball = |center: DVec3, radii: DVec3, material: usize| {
        let profile: Vec<DVec2> = (0..=8)
            .map(|row| {
                let angle = std::f64::consts::PI * f64::from(row) / 8.0;
                DVec2::new(angle.sin(), angle.cos())
            })
            .collect();
        let mut ball = lathe(&profile, 14);
        for (position, normal) in ball.positions.iter_mut().zip(&mut ball.normals) {
            *normal = (*position / radii).normalize();
            *position = *position * radii + center;
        }
        Surface { material, ..ball }
    };
    let glint = ball(v(0.008, 0.013, 0.016), v(0.0075, 0.009, 0.006), cloths.glint);
    vec![ball(DVec3::ZERO, v(0.027, 0.037, 0.02), cloths.eye), glint]
}

/// Position of the left eye; the right one is its mirror image.
pub(crate) const EYE: DVec3 = v(0.068, 0.822, 0.170);
