//! Builds one graph of all meshes of a node, merging vertices of any primitive that coincide and move together.
//!
//! In: the parts of a node. Out: a [`MeshGraph`] with edge lengths at rest.

use crate::scene::{Primitive, position_bits};
use glam::Vec3;
use std::collections::HashMap;
use twox_hash::XxHash3_128;

/// The vertices of a node's triangles, merged where they cannot separate.
#[derive(Debug, Default)]
pub(super) struct MeshGraph {
    /// #parts: the merged vertex of every vertex; [`Self::UNUSED`] for vertices that no triangle uses.
    pub(super) joint_of: Vec<Vec<u32>>,
    /// Number of merged vertices.
    pub(super) count: usize,
    /// #merged vertices + 1: index of the first neighbour of each.
    starts: Vec<usize>,
    /// Neighbours and their distances at rest in the space of the node, metres.
    neighbours: Vec<(u32, f32)>,
    /// Diagonal of the bounding box of all vertices at rest, metres.
    pub(super) diagonal: f32,
}

impl MeshGraph {
    /// Marks a vertex that no triangle uses.
    pub(super) const UNUSED: u32 = u32::MAX;

    /// Builds the graph of the primitives that a node draws.
    pub(super) fn of(primitives: &[&Primitive]) -> Self {
        let mut known: HashMap<([u32; 3], u128), u32> = HashMap::new();
        let mut places: Vec<Vec3> = Vec::new();
        let mut joint_of: Vec<Vec<u32>> = Vec::new();
        for primitive in primitives {
            let mut joint = vec![Self::UNUSED; primitive.positions.len()];
            for &corner in primitive.triangles.iter().flatten() {
                let vertex = corner as usize;
                let key = (position_bits(primitive.positions[vertex]), motion(primitive, vertex));
                joint[vertex] = *known.entry(key).or_insert_with(|| {
                    places.push(primitive.positions[vertex]);
                    places.len() as u32 - 1
                });
            }
            joint_of.push(joint);
        }
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for (primitive, joint) in primitives.iter().zip(&joint_of) {
            for [a, b, c] in primitive.triangles.iter().map(|corners| corners.map(|corner| joint[corner as usize])) {
                edges.extend([[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        let starts = (0..=places.len() as u32).map(|from| edges.partition_point(|edge| edge[0] < from)).collect();
        let length = |&[a, b]: &[u32; 2]| (b, places[a as usize].distance(places[b as usize]));
        let low = places.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = places.iter().copied().reduce(Vec3::max).unwrap_or_default();
        Self {
            joint_of,
            count: places.len(),
            starts,
            neighbours: edges.iter().map(length).collect(),
            diagonal: low.distance(high),
        }
    }

    /// Returns the neighbours of a merged vertex, with their distances.
    pub(super) fn around(&self, vertex: u32) -> &[(u32, f32)] {
        &self.neighbours[self.starts[vertex as usize]..self.starts[vertex as usize + 1]]
    }
}

/// Hashes everything that can move a vertex relative to others at the same position: skin and morph targets.
fn motion(primitive: &Primitive, vertex: usize) -> u128 {
    let mut words: Vec<u32> = Vec::new();
    if let Some(influences) = primitive.influences.get(vertex) {
        let mut tied: Vec<(u16, u32)> = influences
            .iter()
            .filter(|influence| influence.weight > 0.0)
            .map(|influence| (influence.joint, influence.weight.to_bits()))
            .collect();
        tied.sort_unstable();
        words.extend(tied.into_iter().flat_map(|(joint, weight)| [u32::from(joint), weight]));
    }
    for target in &primitive.targets {
        words.extend(position_bits(target.positions.get(vertex).copied().unwrap_or_default()));
    }
    XxHash3_128::oneshot(bytemuck::cast_slice(&words))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Influence;

    fn triangle(places: [[f32; 2]; 3]) -> Primitive {
        let positions = places.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        Primitive { positions, triangles: vec![[0, 1, 2]], ..Primitive::default() }
    }

    #[test]
    fn primitives_that_touch_are_one_mesh_and_lips_are_two() {
        let one = triangle([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let other = triangle([[1.0, 0.0], [1.0, 1.0], [-0.0, 1.0]]);
        let graph = MeshGraph::of(&[&one, &other]);
        assert_eq!((graph.count, &graph.joint_of[1][..]), (4, &[1, 3, 2][..]));
        assert_eq!(graph.around(1).iter().map(|(to, _)| *to).collect::<Vec<_>>(), [0, 2, 3]);
        let mut moved = other;
        let influence = |joint| std::array::from_fn(|k| Influence { joint, weight: f32::from(u8::from(k == 0)) });
        moved.influences = vec![influence(3); 3];
        assert_eq!(MeshGraph::of(&[&one, &moved]).count, 6);
    }
}
