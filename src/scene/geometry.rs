//! Normals and tangents that a file leaves out or breaks.
//!
//! In: positions, UVs, triangles. Out: unit normals and tangents, one a vertex.

use glam::{DVec3, Vec2, Vec3, Vec4};

/// Unit normal of a triangle, counter-clockwise from the front; `None` where it has no area.
pub(super) fn face_normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).try_normalize().map(DVec3::as_vec3)
}

/// One normal a vertex, for vertices that no two triangles share: vertices 3t, 3t+1, 3t+2 are triangle t.
pub(super) fn flat_normals(positions: &[Vec3]) -> Vec<Vec3> {
    assert_eq!(positions.len() % 3, 0, "three vertices a triangle");
    let (triangles, _) = positions.as_chunks::<3>();
    triangles.iter().flat_map(|corners| [face_normal(*corners).unwrap_or(Vec3::Z); 3]).collect()
}

/// Brings normals to unit length; those without a direction get that of the faces around them. `normals`: #vertices.
pub(super) fn repair_normals(positions: &[Vec3], triangles: &[[u32; 3]], normals: &mut [Vec3]) {
    assert_eq!(positions.len(), normals.len(), "one normal a vertex");
    let units: Vec<Option<Vec3>> = normals.iter().map(|normal| unit(*normal)).collect();
    let around = if units.contains(&None) { face_sums(positions, triangles) } else { Vec::new() };
    for (vertex, normal) in normals.iter_mut().enumerate() {
        let from_faces = || around[vertex].try_normalize().map_or(Vec3::Z, DVec3::as_vec3);
        *normal = units[vertex].unwrap_or_else(from_faces);
    }
}

/// Sum of the face normals around each vertex, weighted by area.
fn face_sums(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| positions[corner as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        triangle.iter().for_each(|&corner| sums[corner as usize] += normal);
    }
    sums
}

fn unit(vector: Vec3) -> Option<Vec3> {
    vector.as_dvec3().try_normalize().map(DVec3::as_vec3)
}

/// A unit vector perpendicular to the unit vector `normal`.
fn perpendicular(normal: Vec3) -> Vec3 {
    let axis = if normal.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
    unit(axis - normal * normal.dot(axis)).unwrap_or(Vec3::X)
}

/// Brings tangents to unit length and their w to ±1; those without a direction get one across the normal.
pub(super) fn repair_tangents(normals: &[Vec3], tangents: &mut [Vec4]) {
    assert_eq!(normals.len(), tangents.len(), "one tangent a vertex");
    for (normal, tangent) in normals.iter().zip(tangents) {
        let direction = unit(tangent.truncate()).unwrap_or_else(|| perpendicular(*normal));
        *tangent = direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
}

/// Tangents along increasing u, one a vertex, perpendicular to `normals`; w tells the side of increasing v.
///
/// Face tangents are summed with the angle at the corner as weight, as in Morten S. Mikkelsen, "Simulation of Wrinkled
/// Surfaces Revisited", 2008, §3.3, <https://github.com/mmikk/MikkTSpace>; vertices are not split where the UVs are
/// mirrored: the larger side wins.
pub(super) fn tangents(positions: &[Vec3], normals: &[Vec3], uvs: &[Vec2], triangles: &[[u32; 3]]) -> Vec<Vec4> {
    assert_eq!(positions.len(), normals.len(), "one normal a vertex");
    assert_eq!(positions.len(), uvs.len(), "one UV a vertex");
    let mut along_u = vec![DVec3::ZERO; positions.len()];
    let mut along_v = vec![DVec3::ZERO; positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|corner| positions[corner as usize].as_dvec3());
        let Some([u, v]) = face_gradients(corners, triangle.map(|corner| uvs[corner as usize])) else { continue };
        for (k, &corner) in triangle.iter().enumerate() {
            let weight = corner_angle(corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
            along_u[corner as usize] += u * weight;
            along_v[corner as usize] += v * weight;
        }
    }
    let sums = along_u.into_iter().zip(along_v);
    sums.zip(normals).map(|((u, v), normal)| finish_tangent(u, v, *normal)).collect()
}

/// Unit directions of increasing u and v on a triangle; `None` where the UVs (or the triangle) are degenerate.
fn face_gradients(corners: [DVec3; 3], uvs: [Vec2; 3]) -> Option<[DVec3; 2]> {
    let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
    let (d1, d2) = ((uvs[1] - uvs[0]).as_dvec2(), (uvs[2] - uvs[0]).as_dvec2());
    let sign = d1.perp_dot(d2).signum();
    if d1.perp_dot(d2) == 0.0 {
        return None;
    }
    let u = ((e1 * d2.y - e2 * d1.y) * sign).try_normalize()?;
    let v = ((e2 * d1.x - e1 * d2.x) * sign).try_normalize()?;
    Some([u, v])
}

fn corner_angle(at: DVec3, left: DVec3, right: DVec3) -> f64 {
    let (Some(a), Some(b)) = ((left - at).try_normalize(), (right - at).try_normalize()) else { return 0.0 };
    a.dot(b).clamp(-1.0, 1.0).acos()
}

fn finish_tangent(along_u: DVec3, along_v: DVec3, normal: Vec3) -> Vec4 {
    let n = normal.as_dvec3();
    let flat = (along_u - n * n.dot(along_u)).try_normalize();
    let tangent = flat.map_or_else(|| perpendicular(normal), DVec3::as_vec3);
    let is_mirrored = n.cross(along_u).dot(along_v) < 0.0;
    tangent.extend(if is_mirrored { -1.0 } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn tangents_follow_u_and_tell_the_side_of_v() {
        let upright = [Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(1.0, 1.0), Vec2::new(0.0, 1.0)];
        let flipped = upright.map(|uv| Vec2::new(uv.x, 1.0 - uv.y));
        let turned = upright.map(|uv| Vec2::new(uv.y, 1.0 - uv.x));
        for (uvs, expected) in
            [(upright, Vec3::X.extend(1.0)), (flipped, Vec3::X.extend(-1.0)), (turned, Vec3::Y.extend(1.0))]
        {
            for tangent in tangents(&SQUARE, &[Vec3::Z; 4], &uvs, &TRIANGLES) {
                assert!((tangent - expected).length() < 1e-6, "{tangent} is not {expected}");
            }
        }
    }

    #[test]
    fn tangents_without_uvs_still_lie_across_the_normal() {
        for tangent in tangents(&SQUARE, &[Vec3::Z; 4], &[Vec2::ZERO; 4], &TRIANGLES) {
            assert!(tangent.truncate().dot(Vec3::Z).abs() < 1e-6);
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn broken_normals_take_the_direction_of_the_faces() {
        let mut normals = [Vec3::ZERO, Vec3::NAN, Vec3::new(0.0, 3.0, 0.0), Vec3::new(1e-30, 0.0, 0.0)];
        repair_normals(&SQUARE, &TRIANGLES, &mut normals);
        assert_eq!(normals, [Vec3::Z, Vec3::Z, Vec3::Y, Vec3::X]);
    }
}
