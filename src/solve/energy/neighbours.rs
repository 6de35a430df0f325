//! Half-edges of a mesh with uniform or cotangent weights, grouped by vertex.
//!
//! In: points, triangles. Out: for every vertex its neighbours and w_ij; each undirected edge appears twice.

use crate::solve::small::{area_of, dot, minus};
use crate::solve::{EdgeWeights, Shape};

/// Neighbours of all vertices, one vertex after the other.
#[derive(Clone, Debug, Default)]
pub(crate) struct HalfEdges {
    /// #vertices + 1 offsets.
    starts: Vec<usize>,
    /// (j, w_ij), sorted by j.
    entries: Vec<(usize, f64)>,
}

impl HalfEdges {
    /// Neighbours of a vertex with their weights.
    pub(crate) fn of(&self, vertex: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// Finds the half-edges. Cotangents: w_ij = ½(cot α + cot β), unclamped, over unsigned areas; triangles without area
/// give no weight but keep their edges.
pub(crate) fn half_edges<const D: usize>(shape: &Shape<D>, weights: EdgeWeights) -> HalfEdges {
    let mut found: Vec<([usize; 2], f64)> = Vec::with_capacity(shape.triangles.len() * 6);
    for triangle in &shape.triangles {
        let corners = triangle.map(|corner| corner as usize);
        for k in 0..3 {
            let [i, j, opposite] = std::array::from_fn(|step| corners[(k + step) % 3]);
            let weight = match weights {
                EdgeWeights::Uniform => 1.0,
                EdgeWeights::Cot => half_cotangent(shape, opposite, i, j),
            };
            if i != j {
                found.extend([([i, j], weight), ([j, i], weight)]);
            }
        }
    }
    found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut edges = HalfEdges { starts: vec![0; shape.points.len() + 1], entries: Vec::with_capacity(found.len()) };
    for same in found.chunk_by(|a, b| a.0 == b.0) {
        let [i, j] = same[0].0;
        let weight = match weights {
            EdgeWeights::Uniform => 1.0,
            EdgeWeights::Cot => same.iter().map(|(_, weight)| weight).sum(),
        };
        edges.entries.push((j, weight));
        edges.starts[i + 1] += 1;
    }
    for vertex in 0..shape.points.len() {
        edges.starts[vertex + 1] += edges.starts[vertex];
    }
    edges
}

/// Half the cotangent of the angle at `apex`.
fn half_cotangent<const D: usize>(shape: &Shape<D>, apex: usize, i: usize, j: usize) -> f64 {
    let u = minus(&shape.points[i], &shape.points[apex]);
    let v = minus(&shape.points[j], &shape.points[apex]);
    let doubled = area_of(&u, &v);
    let cotangent = dot(&u, &v) / doubled;
    if doubled > 0.0 && cotangent.is_finite() { 0.5 * cotangent } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle_pair() -> Shape<2> {
        Shape::of_triangles(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], vec![[0, 1, 2], [2, 1, 3]])
    }

    #[test]
    fn uniform_weights_are_one_an_edge() {
        let edges = half_edges(&triangle_pair(), EdgeWeights::Uniform);
        assert_eq!(edges.of(1), [(0, 1.0), (2, 1.0), (3, 1.0)]);
    }

    #[test]
    fn cotangents_see_right_angles_as_nothing() {
        let edges = half_edges(&triangle_pair(), EdgeWeights::Cot);
        for (&(j, weight), wanted) in edges.of(1).iter().zip([(0, 0.5), (2, 0.0), (3, 0.5)]) {
            assert_eq!(j, wanted.0);
            assert!((weight - wanted.1).abs() < 1e-15);
        }
    }
}
