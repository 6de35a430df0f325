//! Energy `element`: 2 Σ_t A_t ‖J_t − R_t‖²_F, with J_t the linear map of triangle t (the triangle-based schemes of T. Igarashi
//! et al. 2005 and W. Baxter et al. 2008; L. Liu et al., "A Local/Global Approach to Mesh Parameterization", 2008).
//!
//! In: a mesh. Out: one edge set per triangle. For any linear map M of the plane of a triangle 2 A ‖M‖² = Σ_k cot_k ‖M e_k‖²,
//! with e_k the edge opposite corner k.

use super::mesh_edges::triangle_edges;
use super::set_edges::{SetEdge, sorted};
use crate::solve::problem::Shape;

/// Lists the sides of every triangle, one set per triangle.
pub(super) fn members<const D: usize>(shape: &Shape<D>) -> Vec<SetEdge> {
    let triangles = 0..shape.triangles.len();
    let edges = triangles
        .flat_map(|set| triangle_edges(shape, set).map(|(ends, cotangent)| SetEdge::new(set, ends, cotangent)));
    sorted(edges.collect(), shape.points.len())
}
