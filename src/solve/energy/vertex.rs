//! Energy `vertex`: Σ_i ‖(L V')_i − R_i (L V)_i‖², the paper's equation 5 to the letter, ‖LWP' − TLV‖².
//!
//! In: a mesh. R_i is that of `edge`. Normal matrix WᵀLᵀLW, right side WᵀLᵀ(R_i (LV)_i). Where LV = 0, as inside flat
//! cotangent meshes, nothing is rigid.

use super::edge_sets::{EdgeSets, add_to_row};
use super::neighbours::{Edge, HalfEdges};
use super::{Distortion, Quality};
use crate::solve::matrix::Normal;
use crate::solve::packs::span;
use crate::solve::point_weights::PointWeights;
use crate::solve::product::RowPairs;
use crate::solve::small::{Square, apply, dot, minus};
use pulp::Simd;

/// The energy of a mesh.
#[derive(Debug)]
pub(crate) struct Vertex<const D: usize> {
    /// The vertices, and the edges whose best rotation is R_i.
    sets: EdgeSets<D>,
    half_edges: HalfEdges,
    /// L V, #vertices.
    rest: Vec<[f64; D]>,
}

impl<const D: usize> Vertex<D> {
    /// `sets` are those of `edge` over the same edges.
    pub(super) fn new(sets: EdgeSets<D>, edges: &[Edge]) -> Self {
        let half_edges = HalfEdges::new(sets.vertices.rest.len(), edges);
        let rest = half_edges.laplacian(&sets.vertices.rest);
        Self { sets, half_edges, rest }
    }

    /// R_i (L V)_i.
    fn turned(&self, rotations: &[Square<D>]) -> Vec<[f64; D]> {
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

    /// Σ ‖(L V')_i − turned_i‖².
    fn misses(&self, moved: &[[f64; D]], turned: &[[f64; D]]) -> f64 {
        let laplacian = self.half_edges.laplacian(moved);
        let squares = laplacian.iter().zip(turned).map(|(now, turned)| {
            let miss = minus(now, turned);
            dot(&miss, &miss)
        });
        squares.sum()
    }
}

impl<const D: usize> Distortion<D> for Vertex<D> {
    /// Half the most that Σ ‖(L V)_i‖² can be with edges of these lengths: LV itself may vanish.
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

    fn reach(&self) -> usize {
        if self.sets.vertices.products().is_some() {
            return self.sets.vertices.reach();
        }
        self.rows().filter_map(|row| span(row.iter().map(|entry| entry.0))).max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        match self.sets.vertices.products() {
            Some(products) => {
                let weights = products.by_point();
                normal.add_product(
                    scale,
                    &mut LaplacianSquares { weights, half_edges: &self.half_edges, row: Vec::new() },
                );
            }
            None => self.rows().for_each(|row| normal.add_row(scale, &row)),
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64 {
        let moved = self.sets.vertices.moved(handles);
        let turned = self.turned(&self.sets.rotations(&moved));
        self.sets.vertices.add_transposed(&self.half_edges.laplacian(&turned), scale, right_side);
        self.misses(&moved, &turned)
    }

    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64 {
        let turned = self.turned(&self.sets.rotations(&self.sets.vertices.moved(turned_at)));
        self.misses(&self.sets.vertices.moved(handles), &turned)
    }

    fn quality(&self, handles: &[[f64; D]]) -> Quality {
        self.sets.quality(handles)
    }
}

/// Rows of LW, twice; for bases in which all handles meet.
struct LaplacianSquares<'a> {
    weights: PointWeights,
    half_edges: &'a HalfEdges,
    row: Vec<(usize, f64)>,
}

impl RowPairs for LaplacianSquares<'_> {
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
