//! Edges of a mesh with their weights: uniform or cotangent for a whole mesh, or the cotangents of one triangle.
//!
//! In: points and triangles. Out: distinct edges with w_ij, or the neighbours of every vertex.

use crate::solve::counting_sort::counting_sort;
use crate::solve::linalg::small_matrix::{area_of, dot, minus};
use crate::solve::problem::Shape;
use crate::solve::settings::EdgeWeights;

/// An undirected edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Vertices, the smaller index first.
    pub(crate) ends: [u32; 2],
    /// w_ij.
    pub(crate) weight: f64,
}

impl Edge {
    /// Creates an edge between two vertices, in either order.
    pub(super) fn new([i, j]: [usize; 2], weight: f64) -> Self {
        Self { ends: [i.min(j) as u32, i.max(j) as u32], weight }
    }
}

/// Neighbours of all vertices, vertex after vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct HalfEdges {
    /// First entry of each vertex, and the end of the last: #vertices + 1.
    starts: Vec<usize>,
    /// (j, w_ij), sorted by j within a vertex.
    entries: Vec<(usize, f64)>,
}

impl HalfEdges {
    /// Lists both directions of edges that are sorted by their ends.
    pub(crate) fn new(vertex_count: usize, edges: &[Edge]) -> Self {
        let mut starts = vec![0; vertex_count + 1];
        edges.iter().flat_map(|edge| edge.ends).for_each(|end| starts[end as usize + 1] += 1);
        for vertex in 0..vertex_count {
            starts[vertex + 1] += starts[vertex];
        }
        let mut entries = vec![(0, 0.0); 2 * edges.len()];
        let mut next = starts.clone();
        for edge in edges {
            let [i, j] = edge.ends.map(|end| end as usize);
            for (from, to) in [(i, j), (j, i)] {
                entries[next[from]] = (to, edge.weight);
                next[from] += 1;
            }
        }
        Self { starts, entries }
    }

    /// Number of vertices, including isolated ones.
    pub(crate) fn vertex_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns (L x)_i = Σ_j w_ij (x_i − x_j); L is symmetric.
    pub(crate) fn laplacian<const D: usize>(&self, x: &[[f64; D]]) -> Vec<[f64; D]> {
        let sum_at = |i: usize| {
            let mut sum = [0.0; D];
            for &(j, weight) in self.of(i) {
                (0..D).for_each(|d| sum[d] += weight * (x[i][d] - x[j][d]));
            }
            sum
        };
        (0..self.vertex_count()).map(sum_at).collect()
    }

    /// Overwrites `row` with a row of L, as (vertex, coefficient).
    pub(crate) fn laplacian_row(&self, vertex: usize, row: &mut Vec<(usize, f64)>) {
        let neighbours = self.of(vertex);
        row.clear();
        row.push((vertex, neighbours.iter().map(|entry| entry.1).sum()));
        row.extend(neighbours.iter().map(|&(j, weight)| (j, -weight)));
    }

    /// Neighbours of a vertex with their weights.
    pub(crate) fn of(&self, vertex: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// Lists the distinct edges of a mesh, sorted by their ends. Cotangent weights are w_ij = ½(cot α + cot β), unclamped, with
/// unsigned areas; triangles without area contribute weight 0, but their edges are listed.
pub(crate) fn edges<const D: usize>(shape: &Shape<D>, weights: EdgeWeights) -> Vec<Edge> {
    let mut found = Vec::with_capacity(shape.triangles.len() * 3);
    for triangle in 0..shape.triangles.len() {
        let sides = match weights {
            EdgeWeights::Uniform => sides(shape, triangle).map(|[_, i, j]| ([i, j], shape.stiffness_of(triangle))),
            EdgeWeights::Cot => triangle_edges(shape, triangle).map(|(ends, cotangent)| (ends, 0.5 * cotangent)),
        };
        for ([i, j], weight) in sides {
            if i != j {
                found.push(Edge::new([i, j], weight));
            }
        }
    }
    let sum = |same: &[Edge]| same.iter().map(|edge| edge.weight).sum::<f64>();
    match weights {
        // A uniform weight is the mean stiffness of the triangles at the edge, 1 where no stiffness is painted.
        EdgeWeights::Uniform => merged(found, shape.points.len(), |same| sum(same) / same.len() as f64),
        EdgeWeights::Cot => merged(found, shape.points.len(), sum),
    }
}

/// Sorts edges between `count` vertices by their ends and merges duplicates; `weight` computes the weight of the merged edge.
pub(super) fn merged(mut edges: Vec<Edge>, count: usize, weight: impl Fn(&[Edge]) -> f64) -> Vec<Edge> {
    for end in [1, 0] {
        counting_sort(&mut edges, count, |edge| edge.ends[end] as usize);
    }
    let (mut known, mut first) = (0, 0);
    while first < edges.len() {
        let ends = edges[first].ends;
        let next = first + edges[first..].iter().take_while(|edge| edge.ends == ends).count();
        let same = &mut edges[first..next];
        if same.len() > 2 {
            // Sorted, so that sums do not depend on the order of the triangles.
            same.sort_by(|a, b| a.weight.total_cmp(&b.weight));
        }
        edges[known] = Edge { ends, weight: weight(same) };
        (known, first) = (known + 1, next);
    }
    edges.truncate(known);
    edges
}

/// Returns the edges of a triangle, each with the cotangent of the opposite angle times the stiffness of the triangle. The
/// cotangent is 0 where the area of the triangle is within the rounding error of its sides.
pub(crate) fn triangle_edges<const D: usize>(shape: &Shape<D>, triangle: usize) -> [([usize; 2], f64); 3] {
    let stiffness = shape.stiffness_of(triangle);
    sides(shape, triangle)
        .map(|[apex, i, j]| ([i, j], stiffness * cotangent(&shape.points[apex], &shape.points[i], &shape.points[j])))
}

/// Returns the sides of a triangle as [opposite corner, from, to].
fn sides<const D: usize>(shape: &Shape<D>, triangle: usize) -> [[usize; 3]; 3] {
    let corners = shape.triangles[triangle].map(|corner| corner as usize);
    std::array::from_fn(|k| std::array::from_fn(|step| corners[(k + step) % 3]))
}

/// Cotangent of the angle at `apex`, with the unsigned area.
fn cotangent<const D: usize>(apex: &[f64; D], i: &[f64; D], j: &[f64; D]) -> f64 {
    let (u, v) = (minus(i, apex), minus(j, apex));
    let doubled = area_of(&u, &v);
    if doubled > 1e-14 * (dot(&u, &u) + dot(&v, &v)) { dot(&u, &v) / doubled } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_edges(shape: &Shape<2>, weights: EdgeWeights) -> HalfEdges {
        HalfEdges::new(shape.points.len(), &edges(shape, weights))
    }

    fn triangle_pair() -> Shape<2> {
        Shape::of_triangles(vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], vec![[0, 1, 2], [2, 1, 3]])
    }

    #[test]
    fn uniform_weights_are_one_an_edge() {
        let edges = half_edges(&triangle_pair(), EdgeWeights::Uniform);
        assert_eq!(edges.of(1), [(0, 1.0), (2, 1.0), (3, 1.0)]);
    }

    #[test]
    fn weights_are_those_of_the_reference() {
        let shared = std::env::var_os("PINWARP_SHARED")
            .unwrap_or_else(|| concat!(env!("CARGO_MANIFEST_DIR"), "/../shared").into());
        let Ok(text) = std::fs::read_to_string(std::path::Path::new(&shared).join("oracle/units.json")) else {
            assert!(std::env::var_os("PINWARP_REQUIRE_SHARED").is_none(), "the reference units are not there");
            crate::internal::skip::skip("the reference units are not there; set PINWARP_SHARED");
            return;
        };
        let units: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let read = |key: &str| units["laplacian"][key].clone();
        let shape = Shape::<2>::of_triangles(
            serde_json::from_value(read("vertices")).expect("points"),
            serde_json::from_value(read("triangles")).expect("triangles"),
        );
        for (key, weights) in [("uniform", EdgeWeights::Uniform), ("cot", EdgeWeights::Cot)] {
            let edges = half_edges(&shape, weights);
            let wanted: Vec<serde_json::Value> = serde_json::from_value(read(key)).expect("a list");
            for entry in &wanted {
                let index = |key: &str| entry[key].as_u64().expect("an index") as usize;
                let found = edges.of(index("i")).iter().find(|(j, _)| *j == index("j")).expect("an edge").1;
                assert!((found - entry["w"].as_f64().expect("a number")).abs() < 1e-12, "{key}: {entry} {found}");
            }
            assert_eq!((0..5).map(|i| edges.of(i).len()).sum::<usize>(), wanted.len());
        }
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
