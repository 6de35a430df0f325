//! Energy `vertex`: Σ_i ‖(L V')_i − R_i (L V)_i‖², the paper's equation 5 taken literally, ‖LWP' − TLV‖².
//!
//! In: a mesh. Out: the normal matrix WᵀLᵀLW and the right-hand side WᵀLᵀ(R_i (LV)_i). R_i is the rotation of energy `edge`.
//! Where LV = 0, as inside flat meshes with cotangent weights, the energy has no rigidity.

use super::distortion::{Distortion, DistortionMetrics};
use super::edge_sets::{EdgeSets, add_to_row};
use super::mesh_edges::{Edge, HalfEdges};
use crate::solve::cancel::Cancel;
use crate::solve::linalg::normal_matrix::{NormalMatrix, index_extent};
use crate::solve::linalg::small_matrix::{SquareMatrix, apply, dot, minus};
use crate::solve::linalg::syrk::SyrkRows;
use crate::solve::separable_rows::SeparableRows;
use pulp::Simd;

/// The energy of a mesh.
#[derive(Debug)]
pub(crate) struct Vertex<const D: usize> {
    /// The vertices, and the edge sets whose best rotations are the R_i.
    sets: EdgeSets<D>,
    half_edges: HalfEdges,
    /// L V, #vertices.
    rest: Vec<[f64; D]>,
}

impl<const D: usize> Vertex<D> {
    /// Builds the energy; `sets` are those of energy `edge` with the same edges.
    pub(super) fn new(sets: EdgeSets<D>, edges: &[Edge]) -> Self {
        let half_edges = HalfEdges::new(sets.vertices.rest.len(), edges);
        let rest = half_edges.laplacian(&sets.vertices.rest);
        Self { sets, half_edges, rest }
    }

    /// Returns R_i (L V)_i for every vertex.
    fn turned(&self, rotations: &[SquareMatrix<D>]) -> Vec<[f64; D]> {
        rotations.iter().zip(&self.rest).map(|(rotation, rest)| apply(rotation, rest)).collect()
    }

    /// Rows of LW, sparse.
    fn rows(&self) -> impl Iterator<Item = Vec<(usize, f64)>> {
        let rows = self.sets.vertices.rows();
        (0..self.half_edges.vertex_count()).map(move |i| {
            let total: f64 = self.half_edges.of(i).iter().map(|entry| entry.1).sum();
            let mut sum: Vec<_> = rows[i].iter().map(|&(handle, w)| (handle, total * w)).collect();
            self.half_edges.of(i).iter().for_each(|&(j, weight)| add_to_row(&mut sum, &rows[j], -weight));
            sum
        })
    }

    /// Returns Σ ‖(L V')_i − turned_i‖².
    fn residual_energy(&self, moved: &[[f64; D]], turned: &[[f64; D]]) -> f64 {
        let laplacian = self.half_edges.laplacian(moved);
        let squares = laplacian.iter().zip(turned).map(|(now, turned)| {
            let residual = minus(now, turned);
            dot(&residual, &residual)
        });
        squares.sum()
    }
}

impl<const D: usize> Distortion<D> for Vertex<D> {
    /// Half an upper bound of Σ ‖(L V)_i‖² for the given edge lengths, because LV itself may vanish.
    fn mass(&self) -> f64 {
        let rest = &self.sets.vertices.rest;
        let most = (0..self.half_edges.vertex_count()).map(|i| {
            let edges = self.half_edges.of(i).iter();
            let (total, squares) = edges.fold((0.0, 0.0), |(total, squares), &(j, weight)| {
                let edge = minus(&rest[i], &rest[j]);
                (total + weight.abs(), squares + weight.abs() * dot(&edge, &edge))
            });
            total * squares
        });
        0.5 * most.sum::<f64>()
    }

    fn bandwidth(&self) -> usize {
        if self.sets.vertices.separable().is_some() {
            return self.sets.vertices.bandwidth();
        }
        self.rows().filter_map(|row| index_extent(row.iter().map(|entry| entry.0))).max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        match self.sets.vertices.separable() {
            Some(separable) => {
                let weights = separable.by_point();
                normal.add_syrk(
                    scale,
                    &mut LaplacianSquares { weights, half_edges: &self.half_edges, row: Vec::new() },
                    cancel,
                );
            }
            None => self.rows().for_each(|row| normal.add_row(scale, &row)),
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], _cancel: &Cancel) -> f64 {
        let moved = self.sets.vertices.moved(handles);
        let turned = self.turned(&self.sets.rotations(&moved));
        self.sets.vertices.add_transposed(&self.half_edges.laplacian(&turned), scale, right_side);
        self.residual_energy(&moved, &turned)
    }

    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64 {
        let turned = self.turned(&self.sets.rotations(&self.sets.vertices.moved(rotations_at)));
        self.residual_energy(&self.sets.vertices.moved(handles), &turned)
    }

    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics {
        self.sets.metrics(handles)
    }
}

/// Rows of LW, as both factors of the product, for bases of global support.
struct LaplacianSquares<'a> {
    weights: SeparableRows,
    half_edges: &'a HalfEdges,
    row: Vec<(usize, f64)>,
}

impl SyrkRows for LaplacianSquares<'_> {
    fn count(&self) -> usize {
        self.half_edges.vertex_count()
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, simd: S, vertex: usize, [a, b]: [&mut [f64]; 2]) {
        self.half_edges.laplacian_row(vertex, &mut self.row);
        self.weights.write(simd, &self.row, a);
        b.copy_from_slice(a);
    }
}
