//! Energy `vertex`: Σ_i ‖(L V')_i − R_i (L V)_i‖², the paper's equation 5 to the letter, ‖LWP' − TLV‖².
//!
//! In: a mesh. R_i is that of `edge`. Normal matrix WᵀLᵀLW, right side WᵀLᵀ(R_i (LV)_i). Where LV = 0, as inside flat
//! cotangent meshes, nothing is rigid.

use super::edge_sets::{EdgeSets, add_to_row};
use super::neighbours::HalfEdges;
use super::{Distortion, Quality};
use crate::solve::matrix::Normal;
use crate::solve::packs::span;
use crate::solve::small::{Square, apply, dot, minus};

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
    /// `sets` are those of `edge` over the same half-edges.
    pub(super) fn new(sets: EdgeSets<D>, half_edges: HalfEdges) -> Self {
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

    /// Rows of LW, #vertices × #handles.
    fn dense_rows(&self, size: usize) -> Vec<f64> {
        let mut dense = vec![0.0; self.half_edges.vertex_count() * size];
        for (row, out) in self.rows().zip(dense.chunks_exact_mut(size)) {
            row.into_iter().for_each(|(handle, w)| out[handle] = w);
        }
        dense
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
        if self.sets.vertices.shared_handles().is_some() {
            return self.sets.vertices.reach();
        }
        self.rows().filter_map(|row| span(row.iter().map(|entry| entry.0))).max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        match self.sets.vertices.shared_handles().filter(|&shared| normal.is_full(shared)) {
            Some(size) => {
                let rows = self.dense_rows(size);
                normal.add_product(scale, &rows, &rows);
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
