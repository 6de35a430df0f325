//! Bicubic Bézier patches and their tessellation into triangles with shared vertices and exact normals.
//!
//! In: 4x4 control points per patch. Out: a surface. Bézier's form s = Σ_ij B_i(u) B_j(v) b_ij.

use super::glb::Surface;
use glam::DVec3;
use std::collections::HashMap;

/// Control points b_ij; du × dv points outwards.
pub(crate) type Patch = [[DVec3; 4]; 4];

/// Cubic Bernstein values and derivatives at t.
fn bernstein(t: f64) -> ([f64; 4], [f64; 4]) {
    let s = 1.0 - t;
    let values = [s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t];
    let slopes = [-3.0 * s * s, 3.0 * s * s - 6.0 * t * s, 6.0 * t * s - 3.0 * t * t, 3.0 * t * t];
    (values, slopes)
}

/// The patch with inside and outside exchanged.
pub(crate) fn flipped(patch: &Patch) -> Patch {
    std::array::from_fn(|i| std::array::from_fn(|j| patch[j][i]))
}

/// Applies a map to all control points. A reflection also exchanges inside and outside; [`flipped`] exchanges them back.
pub(crate) fn mapped(patch: &Patch, map: impl Fn(DVec3) -> DVec3) -> Patch {
    patch.map(|row| row.map(&map))
}

fn blend(patch: &Patch, along_u: [f64; 4], along_v: [f64; 4]) -> DVec3 {
    let row = |row: &[DVec3; 4]| -> DVec3 { row.iter().zip(along_v).map(|(point, share)| *point * share).sum() };
    patch.iter().zip(along_u).map(|(points, share)| row(points) * share).sum()
}

/// Point and unit normal at (u, v). At a pole, where one derivative vanishes, the normal is taken slightly inside the
/// patch.
fn evaluate(patch: &Patch, u: f64, v: f64) -> (DVec3, DVec3) {
    let normal_at = |u: f64, v: f64| {
        let ((bu, du), (bv, dv)) = (bernstein(u), bernstein(v));
        blend(patch, du, bv).cross(blend(patch, bu, dv))
    };
    let point = blend(patch, bernstein(u).0, bernstein(v).0);
    let normal = normal_at(u, v);
    if normal.length() > 1e-6 {
        return (point, normal.normalize());
    }
    let inside = |t: f64| t + (0.5 - t) * 1e-3;
    (point, normal_at(inside(u), inside(v)).normalize())
}

/// Tessellates the patches of a part with `steps` quads per side. Equal points are merged and their normals averaged;
/// triangles with zero area are omitted.
pub(crate) fn tessellate(patches: &[Patch], steps: u32) -> Surface {
    let mut surface = Surface::default();
    let mut known = HashMap::new();
    for patch in patches {
        let mut corner = |i: u32, j: u32| {
            let (u, v) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
            let (point, normal) = evaluate(patch, u, v);
            let key = (point * 1e6).round().as_i64vec3();
            let index = *known.entry(key).or_insert_with(|| {
                surface.positions.push(point);
                surface.normals.push(DVec3::ZERO);
                surface.positions.len() - 1
            });
            surface.normals[index] += normal;
            index as u32
        };
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            let halves = [[a, b, c], [a, c, d]];
            surface.triangles.extend(halves.iter().filter(|[p, q, r]| p != q && q != r && r != p));
        }
    }
    for normal in &mut surface.normals {
        *normal = normal.normalize();
    }
    surface
}
