//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Out: one edge set a vertex, its half-edges; the normal matrix is 2 WᵀLW, and the right side 2 Wᵀb with
//! b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j), for each edge is in the sets of both its ends.

use super::edge_sets::{EdgeSets, Seen};
use super::neighbours::Edge;
use super::vertices::Vertices;
use crate::lattice::Grid;
use crate::solve::Shape;

/// The energy of a mesh with these edges.
pub(super) fn build<const D: usize>(grid: &Grid<D>, shape: Shape<D>, edges: Vec<Edge>) -> EdgeSets<D> {
    let mean_stiffness = shape.mean_stiffness();
    let vertices = Vertices::new(grid, shape.points);
    EdgeSets::around_vertices(vertices, edges, Seen::Triangles(shape.triangles)).of_mean_stiffness(mean_stiffness)
}
