//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Out: one edge set a vertex, its half-edges; the normal matrix is 2 WᵀLW, and the right side 2 Wᵀb with
//! b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j), for each edge is in the sets of both its ends.

use super::edge_sets::SetEdge;
use super::neighbours::HalfEdges;

/// The half-edges of every vertex as its set.
pub(super) fn edge_sets(half_edges: &HalfEdges) -> Vec<SetEdge> {
    let vertices = 0..half_edges.vertex_count();
    let edges = vertices
        .flat_map(|i| half_edges.of(i).iter().map(move |&(j, weight)| SetEdge { set: i, ends: [i, j], weight }));
    edges.collect()
}
