//! Energy `spokes-and-rims`: 2 Σ_t Σ_{v∈t} A_t/3 ‖J_t − R_v‖²_F, with one rotation per vertex over all edges of its triangles,
//! the spokes and rims (I. Chao et al., "A Simple Geometric Model for Elastic Deformations", 2010).
//! R_v maximises tr(R_vᵀ Σ A_t J_t).
//!
//! In: a mesh. Out: one edge set per vertex; weights are a third of the cotangents of `element`.

use super::mesh_edges::triangle_edges;
use super::set_edges::{SetEdge, sorted};
use crate::solve::problem::Shape;

/// Lists the sides of all triangles at each vertex as the set of that vertex.
pub(super) fn members<const D: usize>(shape: &Shape<D>) -> Vec<SetEdge> {
    let mut edges = Vec::with_capacity(shape.triangles.len() * 9);
    for (number, corners) in shape.triangles.iter().enumerate() {
        for (ends, cotangent) in triangle_edges(shape, number) {
            edges.extend(corners.iter().map(|&set| SetEdge::new(set as usize, ends, cotangent / 3.0)));
        }
    }
    sorted(edges, shape.points.len())
}
