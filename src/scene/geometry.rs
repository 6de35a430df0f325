//! Completes missing normals, and repairs invalid normals and tangents.
//!
//! In: positions, triangles, stored attributes. Out: unit normals and tangents, one per vertex.

use glam::{DVec3, Vec3, Vec4};

/// Returns the unit normal of a triangle, counter-clockwise from the front; `None` if it has no area.
pub(super) fn face_normal(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    (b - a).cross(c - a).try_normalize().map(DVec3::as_vec3)
}

/// Returns one normal per vertex, for unshared vertices: vertices 3t, 3t+1, 3t+2 are those of triangle t.
pub(super) fn flat_normals(positions: &[Vec3]) -> Vec<Vec3> {
    assert_eq!(positions.len() % 3, 0, "three vertices per triangle");
    let (triangles, _) = positions.as_chunks::<3>();
    triangles.iter().flat_map(|corners| [face_normal(*corners).unwrap_or(Vec3::Z); 3]).collect()
}

/// Normalises normals; zero normals are replaced by that of the adjacent faces. `normals`: #vertices.
pub(super) fn repair_normals(positions: &[Vec3], triangles: &[[u32; 3]], normals: &mut [Vec3]) {
    assert_eq!(positions.len(), normals.len(), "one normal per vertex");
    let units: Vec<Option<Vec3>> = normals.iter().map(|normal| unit(*normal)).collect();
    let around = if units.contains(&None) { face_sums(positions, triangles) } else { Vec::new() };
    for (vertex, normal) in normals.iter_mut().enumerate() {
        let from_faces = || around[vertex].try_normalize().map_or(Vec3::Z, DVec3::as_vec3);
        *normal = units[vertex].unwrap_or_else(from_faces);
    }
}

/// Returns the area-weighted sum of the face normals around each vertex.
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

/// Returns a unit vector perpendicular to the unit vector `normal`.
pub(super) fn perpendicular(normal: Vec3) -> Vec3 {
    let axis = if normal.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
    unit(axis - normal * normal.dot(axis)).unwrap_or(Vec3::X)
}

/// Normalises tangents and sets their w to ±1; zero tangents are replaced by one perpendicular to the normal.
pub(super) fn repair_tangents(normals: &[Vec3], tangents: &mut [Vec4]) {
    assert_eq!(normals.len(), tangents.len(), "one tangent per vertex");
    for (normal, tangent) in normals.iter().zip(tangents) {
        let direction = unit(tangent.truncate()).unwrap_or_else(|| perpendicular(*normal));
        *tangent = direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    #[test]
    fn broken_normals_take_the_direction_of_the_faces() {
        let mut normals = [Vec3::ZERO, Vec3::NAN, Vec3::new(0.0, 3.0, 0.0), Vec3::new(1e-30, 0.0, 0.0)];
        repair_normals(&SQUARE, &TRIANGLES, &mut normals);
        assert_eq!(normals, [Vec3::Z, Vec3::Z, Vec3::Y, Vec3::X]);
    }
}
