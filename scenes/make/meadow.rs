//! Surroundings of the walking gnome: a path through a meadow, grass, mushrooms, and painted hills in the distance.
//!
//! Out: surfaces in scene space. The ground is y = 0, and the path leads along [`HEADING`].

use super::glb::Surface;
use super::nets::lathe;
use super::paint::smoothstep;
use glam::{DVec2, DVec3};

/// Direction of the walk: to the right and a little towards the camera (50 degrees from +z to +x).
pub(crate) const HEADING: DVec3 = DVec3::new(0.766_044_443_119, 0.0, 0.642_787_609_687);

/// Corners of the ground, x and z: far left, near right.
const GROUND: [DVec2; 2] = [DVec2::new(-7.0, -6.0), DVec2::new(7.0, 3.0)];

/// A pseudo-random number in 0..1 for a pair of numbers.
fn hash(x: i64, y: i64) -> f64 {
    let mixed = x.wrapping_mul(374_761_393).wrapping_add(y.wrapping_mul(668_265_263));
    let mixed = (mixed ^ (mixed >> 13)).wrapping_mul(1_274_126_177);
    ((mixed >> 16) & 0xffff) as f64 / 65536.0
}

/// Smooth noise in 0..=1 with one bump per unit.
pub(crate) fn noise(at: DVec2) -> f64 {
    let (cell, t) = (at.floor(), at - at.floor());
    let t = t * t * (DVec2::splat(3.0) - 2.0 * t);
    let value = |x: i64, y: i64| hash(cell.x as i64 + x, cell.y as i64 + y);
    let row = |y: i64| value(0, y) + (value(1, y) - value(0, y)) * t.x;
    row(0) + (row(1) - row(0)) * t.y
}

/// Distance from the middle of the path, metres.
fn off_path(at: DVec2) -> f64 {
    let ahead = DVec2::new(HEADING.x, HEADING.z);
    let along = at.dot(ahead);
    (at.perp_dot(ahead) + 0.10 * (noise(DVec2::new(along * 0.9, 3.0)) - 0.5)).abs()
}

/// Colour of the distant meadow, where it meets the hills.
const HAZE: DVec3 = DVec3::new(0.42, 0.55, 0.30);

/// Colour of the ground at a texture coordinate.
pub(crate) fn turf(uv: DVec2) -> DVec3 {
    let at = GROUND[0] + uv * (GROUND[1] - GROUND[0]);
    let tone = 0.6 * noise(at * 1.7) + 0.4 * noise(at * 7.0);
    let grass = DVec3::new(0.085, 0.20, 0.045).lerp(DVec3::new(0.20, 0.33, 0.075), tone);
    let dirt = DVec3::new(0.36, 0.25, 0.145).lerp(DVec3::new(0.50, 0.37, 0.23), noise(at * 9.0));
    let edge = off_path(at) + 0.10 * (noise(at * 6.0) - 0.5);
    let color = dirt.lerp(grass, smoothstep(0.30, 0.42, edge));
    color.lerp(HAZE, smoothstep(-1.2, -6.0, at.y)) * (1.0 - 0.25 * smoothstep(1.0, 3.0, at.y))
}

/// Colour of the sky and its hills at a texture coordinate.
pub(crate) fn sky(uv: DVec2) -> DVec3 {
    let height = 1.0 - uv.y;
    let mut color = DVec3::new(0.95, 0.80, 0.58).lerp(DVec3::new(0.30, 0.55, 0.80), smoothstep(0.05, 0.75, height));
    let cloud =
        noise(DVec2::new(uv.x * 9.0, height * 16.0)) * 0.6 + noise(DVec2::new(uv.x * 21.0, height * 34.0)) * 0.4;
    color =
        color.lerp(DVec3::new(1.0, 0.95, 0.88), 0.55 * smoothstep(0.52, 0.78, cloud) * smoothstep(0.2, 0.4, height));
    let hills = [
        (0.30, 0.13, 3.0, DVec3::new(0.44, 0.60, 0.66)),
        (0.20, 0.11, 5.0, DVec3::new(0.36, 0.55, 0.45)),
        (0.10, 0.09, 8.0, DVec3::new(0.36, 0.53, 0.30)),
    ];
    for (base, swing, bumps, shade) in hills {
        let crest = base + swing * (noise(DVec2::new(uv.x * bumps, bumps)) - 0.5);
        let lit = shade.lerp(HAZE * 1.1, smoothstep(crest, 0.0, height) * 0.7);
        color = color.lerp(lit, smoothstep(crest + 0.004, crest - 0.004, height));
    }
    color
}

fn sheet(corners: [DVec3; 4], material: usize) -> Surface {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    Surface {
        positions: corners.to_vec(),
        normals: vec![normal; 4],
        uvs: [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| DVec2::new(u, v)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material,
        ..Surface::default()
    }
}

/// The ground.
pub(crate) fn ground(material: usize) -> Surface {
    let [far, near] = GROUND;
    let corners = [(far.x, near.y), (near.x, near.y), (near.x, far.y), (far.x, far.y)];
    sheet(corners.map(|(x, z)| DVec3::new(x, 0.0, z)), material)
}

/// The painted sky behind the ground.
pub(crate) fn backdrop(material: usize) -> Surface {
    let (z, half) = (GROUND[0].y, GROUND[1].x);
    let corners = [(-half, 0.0), (half, 0.0), (half, 5.0), (-half, 5.0)];
    sheet(corners.map(|(x, y)| DVec3::new(x, y, z)), material)
}

/// Tufts of grass beside the path: bent blades with darker roots.
pub(crate) fn grass(material: usize) -> Surface {
    let mut blades = Surface { material, ..Surface::default() };
    for tuft in 0..400_i64 {
        let at = DVec2::new(hash(tuft, 11) * 6.4 - 3.2, hash(tuft, 23) * 4.6 - 3.2);
        if off_path(at) < 0.40 {
            continue;
        }
        for blade in 0..4 {
            let random = |salt: i64| hash(tuft * 8 + blade, salt);
            let root = DVec3::new(at.x + 0.05 * (random(1) - 0.5), 0.0, at.y + 0.05 * (random(2) - 0.5));
            let tip = DVec3::new(0.07 * (random(3) - 0.5), 0.05 + 0.06 * random(4), 0.04 * (random(5) - 0.5));
            add_blade(&mut blades, root, tip, random(6));
        }
    }
    blades
}

fn add_blade(blades: &mut Surface, root: DVec3, tip: DVec3, tone: f64) {
    let first = blades.positions.len() as u32;
    let aside = DVec3::new(0.006, 0.0, 0.0);
    let points = [root - aside, root + aside, root + tip];
    let tint = DVec3::new(0.13, 0.26, 0.05).lerp(DVec3::new(0.34, 0.44, 0.10), tone);
    blades.positions.extend(points);
    blades.normals.extend([DVec3::Y; 3]);
    blades.colors.extend([tint * 0.55, tint * 0.55, tint * 1.15]);
    blades.triangles.push([first, first + 1, first + 2]);
}

/// Toadstools with stems and plain red caps, in vertex colours.
pub(crate) fn mushrooms(material: usize) -> Surface {
    let stands = [
        (-0.95, -0.95, 1.2),
        (-0.80, -1.05, 0.75),
        (1.15, -0.55, 1.0),
        (1.30, -0.42, 0.6),
        (0.15, -1.25, 0.9),
        (-1.75, -1.5, 1.1),
        (1.95, -1.1, 1.3),
    ];
    let profile = [
        (0.0, 0.155),
        (0.03, 0.15),
        (0.06, 0.132),
        (0.078, 0.105),
        (0.07, 0.092),
        (0.03, 0.095),
        (0.024, 0.06),
        (0.03, 0.0),
    ];
    let points: Vec<DVec2> = profile.iter().map(|(radius, height)| DVec2::new(*radius, *height)).collect();
    let mut all = Surface { material, ..Surface::default() };
    for (x, z, size) in stands {
        let one = lathe(&points, 16);
        let first = all.positions.len() as u32;
        let cap = DVec3::new(0.62, 0.05, 0.035);
        let stem = DVec3::new(0.80, 0.72, 0.58);
        all.colors.extend(one.uvs.iter().map(|uv| if uv.y < 0.5 { cap } else { stem }));
        all.positions.extend(one.positions.iter().map(|at| *at * size + DVec3::new(x, 0.0, z)));
        all.normals.extend(one.normals);
        all.triangles.extend(one.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }
    all
}
