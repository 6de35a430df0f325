//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Out: one edge set a vertex, its half-edges; the normal matrix is 2 WᵀLW, and the right side 2 Wᵀb with
//! b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j), for each edge is in the sets of both its ends.

use super::edge_sets::SetEdge;
use super::neighbours::Edge;

/// Every edge in the sets of its ends, sorted as `edges` are; those without weight are left out.
pub(super) fn edge_sets(edges: &[Edge]) -> Vec<SetEdge> {
    let mut members = Vec::with_capacity(2 * edges.len());
    for &Edge { ends, weight } in edges.iter().filter(|edge| edge.weight != 0.0) {
        members.extend(ends.map(|set| SetEdge { set, ends, weight }));
    }
    members
}
