//! Finds the closed surfaces of a mesh, whose back faces cannot be seen from outside.
//!
//! In: a mesh at rest. Out: for every vertex whether it lies on a connected surface without a border that faces outwards. Vertices in the same
//! position count as one, also those of different primitives.

use super::{Mesh, Primitive};
use crate::disjoint_sets::DisjointSets;
use foldhash::fast::FixedState;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::OnceLock;

/// The vertices of a mesh on closed surfaces, found when they are first asked for. #primitives x #vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct SolidVertices(OnceLock<Vec<Vec<bool>>>);

impl Mesh {
    /// Whether each vertex of a primitive lies on a closed surface that faces outwards, #vertices.
    pub(crate) fn solid_vertices(&self, primitive: usize) -> &[bool] {
        self.solid.0.get_or_init(|| find(self)).get(primitive).map_or(&[], Vec::as_slice)
    }
}

/// What is known of a connected surface.
#[derive(Clone, Default)]
struct Surface {
    has_border: bool,
    /// Six times the volume that it encloses.
    volume: f64,
}

fn find(mesh: &Mesh) -> Vec<Vec<bool>> {
    let (merged, places) = merge_vertices(mesh);
    let triangles = || {
        let all = mesh.primitives.iter().zip(&merged);
        let own = all.flat_map(|(primitive, merged)| {
            primitive.triangles.iter().map(|corners| corners.map(|corner| merged[corner as usize]))
        });
        own.filter(|[a, b, c]| a != b && b != c && c != a)
    };
    let mut sets = DisjointSets::of(places.len());
    let mut edges: Vec<(u32, u32, bool)> = Vec::new();
    for [a, b, c] in triangles() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            edges.push((from.min(to), from.max(to), from < to));
            sets.join([from as usize, to as usize]);
        }
    }
    edges.par_sort_unstable();
    let mut surfaces = vec![Surface::default(); places.len()];
    for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let upwards = edge.iter().filter(|(.., is_upwards)| *is_upwards).count();
        surfaces[sets.root(edge[0].0 as usize)].has_border |= 2 * upwards != edge.len();
    }
    for corners in triangles() {
        let own = sets.root(corners[0] as usize);
        let [a, b, c] = corners.map(|corner| places[corner as usize].as_dvec3() - places[own].as_dvec3());
        surfaces[own].volume += a.dot(b.cross(c));
    }
    let mut is_solid = |&vertex: &u32| {
        let Surface { has_border, volume } = surfaces[sets.root(vertex as usize)];
        !has_border && volume > 0.0
    };
    merged.iter().map(|own| own.iter().map(&mut is_solid).collect()).collect()
}

/// Returns the bits of a position, of which equal ones have the same: adding 0 turns -0 into 0.
pub(crate) fn position_bits(position: Vec3) -> [u32; 3] {
    (position + 0.0).to_array().map(f32::to_bits)
}

/// Numbers the places where vertices are. Returns those of each primitive's vertices, and the places.
fn merge_vertices(mesh: &Mesh) -> (Vec<Vec<u32>>, Vec<Vec3>) {
    let mut numbers: HashMap<[u32; 3], u32, FixedState> = HashMap::default();
    let mut places: Vec<Vec3> = Vec::new();
    let mut number = |position: &Vec3| {
        *numbers.entry(position_bits(*position)).or_insert_with(|| {
            places.push(*position);
            places.len() as u32 - 1
        })
    };
    let of_primitive = |primitive: &Primitive| primitive.positions.iter().map(&mut number).collect();
    let merged = mesh.primitives.iter().map(of_primitive).collect();
    (merged, places)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron at an offset along x, seen from outside or from inside.
    fn tetrahedron(offset: f32, is_turned: bool) -> Primitive {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|at| at + offset * Vec3::X).to_vec();
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles = faces.map(|[a, b, c]| if is_turned { [a, c, b] } else { [a, b, c] }).to_vec();
        Primitive { positions, triangles, ..Primitive::default() }
    }

    fn solid(primitives: Vec<Primitive>) -> Vec<Vec<bool>> {
        let mesh = Mesh { primitives, ..Mesh::default() };
        (0..mesh.primitives.len()).map(|primitive| mesh.solid_vertices(primitive).to_vec()).collect()
    }

    #[test]
    fn surfaces_without_a_border_that_face_outwards_are_solid() {
        let mut open = tetrahedron(9.0, false);
        open.triangles.pop();
        let all = solid(vec![tetrahedron(0.0, false), open, tetrahedron(20.0, true)]);
        assert_eq!(all, [[true; 4], [false; 4], [false; 4]], "closed, open, inside out");
    }

    #[test]
    fn primitives_close_a_surface_together() {
        let (mut half, mut other) = (tetrahedron(0.0, false), tetrahedron(0.0, false));
        half.triangles.truncate(2);
        other.triangles.drain(..2);
        assert_eq!(solid(vec![half, other]), [[true; 4]; 2]);
    }
}
