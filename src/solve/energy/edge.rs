//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Out: one edge set per vertex, its one-ring. As each edge is in the one-rings of both its ends, the normal matrix
//! is 2 WᵀLW, and the right-hand side is 2 Wᵀb with b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j).

use super::edge_sets::{EdgeSets, MetricSource};
use super::embedded_vertices::EmbeddedVertices;
use super::mesh_edges::Edge;
use crate::lattice::Grid;
use crate::solve::cancel::Cancel;
use crate::solve::problem::Shape;

/// Builds the energy of a mesh with the given edges.
pub(super) fn build<const D: usize>(grid: &Grid<D>, shape: Shape<D>, edges: Vec<Edge>, cancel: &Cancel) -> EdgeSets<D> {
    let mean_stiffness = shape.mean_stiffness();
    let vertices = EmbeddedVertices::new(grid, shape.points, cancel);
    EdgeSets::around_vertices(vertices, edges, MetricSource::Triangles(shape.triangles))
        .with_mean_stiffness(mean_stiffness)
}
