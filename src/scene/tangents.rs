//! Tangents for normal maps of files that store none: MikkTSpace, as glTF 2.0 requires (§3.7.2.1).
//!
//! In: positions, normals, UVs, triangles. Out: a tangent per vertex; vertices are split where the tangents of their
//! triangles differ (mirrored UVs). Method: Morten S. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008.

use super::vertices::gather_vertices;
use super::{MorphTarget, Primitive, TextureRef, geometry};
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Computes the tangents of a primitive with the normal map `texture`, and the tangent displacements of its targets.
///
/// Existing vertices keep their indices; copies of split vertices follow them.
pub(super) fn generate(primitive: &mut Primitive, texture: &TextureRef) {
    let uvs = texture_coordinates(&primitive.uvs[texture.uv_set], texture);
    let corners = corner_tangents(&primitive.positions, &primitive.normals, &uvs, &primitive.triangles);
    split(primitive, &corners);
    let uvs = texture_coordinates(&primitive.uvs[texture.uv_set], texture);
    let mut targets = std::mem::take(&mut primitive.targets);
    targets.iter_mut().for_each(|target| target.tangents = displacements(primitive, target, &uvs));
    primitive.targets = targets;
}

/// Returns the coordinates of texture lookups: UVs after KHR_texture_transform, whose reflections mirror the tangents.
fn texture_coordinates(uvs: &[Vec2], texture: &TextureRef) -> Vec<Vec2> {
    let [u, v] = texture.texture_from_uv;
    uvs.iter().map(|uv| Vec2::new(u.dot(uv.extend(1.0)), v.dot(uv.extend(1.0)))).collect()
}

/// Gives every vertex one tangent: corners with a different one get a copy of the vertex.
fn split(primitive: &mut Primitive, corners: &[[Vec4; 3]]) {
    let count = primitive.positions.len();
    let mut tangents: Vec<Option<Vec4>> = vec![None; count];
    // The source of every vertex: itself, or for copies the vertex they are made from.
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (triangle, corners) in primitive.triangles.iter_mut().zip(corners) {
        for (corner, tangent) in triangle.iter_mut().zip(corners) {
            let first = tangents[*corner as usize].get_or_insert(*tangent);
            if first == tangent {
                continue;
            }
            *corner = *copies.entry((*corner, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                order.push(*corner);
                tangents.push(Some(*tangent));
                order.len() as u32 - 1
            });
        }
    }
    if order.len() > count {
        gather_vertices(primitive, &order);
    }
    let filled = tangents.iter().zip(&primitive.normals);
    primitive.tangents = filled.map(|(tangent, normal)| tangent.unwrap_or_else(|| any_tangent(*normal))).collect();
}

/// Returns the tangent displacements of a morph target: the tangents of the fully morphed mesh minus those at rest;
/// empty if the target moves neither positions nor normals.
fn displacements(primitive: &Primitive, target: &MorphTarget, uvs: &[Vec2]) -> Vec<Vec3> {
    if target.positions.is_empty() && target.normals.is_empty() {
        return Vec::new();
    }
    let moved = |at: &[Vec3], by: &[Vec3]| -> Vec<Vec3> {
        at.iter().enumerate().map(|(vertex, at)| at + by.get(vertex).copied().unwrap_or_default()).collect()
    };
    let positions = moved(&primitive.positions, &target.positions);
    let normals = if primitive.has_flat_normals {
        geometry::flat_normals(&positions)
    } else {
        let mut normals = moved(&primitive.normals, &target.normals);
        geometry::repair_normals(&positions, &primitive.triangles, &mut normals);
        normals
    };
    let corners = corner_tangents(&positions, &normals, uvs, &primitive.triangles);
    let mut displacements = vec![Vec3::ZERO; positions.len()];
    for (triangle, corners) in primitive.triangles.iter().zip(corners) {
        for (&corner, tangent) in triangle.iter().zip(corners) {
            displacements[corner as usize] = (tangent - primitive.tangents[corner as usize]).truncate();
        }
    }
    displacements
}

/// Returns one tangent per triangle corner; w is the handedness of glTF: bitangent = cross(normal, tangent) · w points
/// up in the image, against increasing v.
fn corner_tangents(positions: &[Vec3], normals: &[Vec3], uvs: &[Vec2], triangles: &[[u32; 3]]) -> Vec<[Vec4; 3]> {
    assert_eq!(positions.len(), normals.len(), "one normal per vertex");
    assert_eq!(positions.len(), uvs.len(), "one UV per vertex");
    let mut corners = Corners { positions, normals, uvs, triangles, tangents: Vec::with_capacity(triangles.len()) };
    let at_rest = |triangle: &[u32; 3]| triangle.map(|corner| any_tangent(normals[corner as usize]));
    corners.tangents.extend(triangles.iter().map(at_rest));
    // The error type is uninhabited.
    let _ = generate_tangents(&mut corners);
    corners.tangents
}

/// Returns a tangent for vertices whose UVs give no direction.
fn any_tangent(normal: Vec3) -> Vec4 {
    geometry::perpendicular(normal).extend(1.0)
}

/// The interface between a mesh and MikkTSpace.
struct Corners<'a> {
    /// #vertices.
    positions: &'a [Vec3],
    /// #vertices.
    normals: &'a [Vec3],
    /// #vertices.
    uvs: &'a [Vec2],
    triangles: &'a [[u32; 3]],
    /// #triangles.
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        let Some(tangent) = Vec3::from_array(space.tangent()).try_normalize() else { return };
        // MikkTSpace's bitangent points along increasing v, glTF's along the image's +Y, which is opposite to v.
        let w = if space.is_orientation_preserving() { -1.0 } else { 1.0 };
        self.tangents[face][corner] = tangent.extend(w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Vec3; 4] =
        [Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    fn tangents(uvs: [Vec2; 4]) -> Vec<Vec4> {
        corner_tangents(&SQUARE, &[Vec3::Z; 4], &uvs, &TRIANGLES).concat()
    }

    #[test]
    fn bitangents_point_up_in_the_image() {
        // v grows downwards in images: upright pictures have v = 1 at the bottom.
        let upright = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)];
        let flipped = upright.map(|uv| Vec2::new(uv.x, 1.0 - uv.y));
        let mirrored = upright.map(|uv| Vec2::new(1.0 - uv.x, uv.y));
        let turned = upright.map(|uv| Vec2::new(uv.y, 1.0 - uv.x));
        for (uvs, tangent, up) in [
            (upright, Vec3::X, Vec3::Y),
            (flipped, Vec3::X, Vec3::NEG_Y),
            (mirrored, Vec3::NEG_X, Vec3::Y),
            (turned, Vec3::NEG_Y, Vec3::X),
        ] {
            for found in tangents(uvs) {
                assert!((found.truncate() - tangent).length() < 1e-6, "{found} is not along {tangent}");
                let bitangent = Vec3::Z.cross(found.truncate()) * found.w;
                assert!((bitangent - up).length() < 1e-6, "{bitangent} is not {up}");
            }
        }
    }

    #[test]
    fn tangents_without_uvs_are_perpendicular_to_the_normal() {
        for tangent in tangents([Vec2::ZERO; 4]) {
            assert!(tangent.truncate().dot(Vec3::Z).abs() < 1e-6);
            assert!((tangent.truncate().length() - 1.0).abs() < 1e-6);
        }
    }
}
