//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Normal matrix 2 WᵀLW; right side 2 Wᵀb with b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j).

use super::neighbours::{HalfEdges, half_edges};
use super::{Distortion, Quality};
use crate::lattice::Grid;
use crate::solve::matrix::Normal;
use crate::solve::packs::{LANES, Packs, add_sums, gather, local_handles, scatter};
use crate::solve::small::{Square, apply, best_rotation, dot, minus};
use crate::solve::weld::weld;
use crate::solve::{EqualVertices, Settings, Shape};

/// The energy of a mesh.
#[derive(Debug)]
pub(crate) struct Edge<const D: usize> {
    /// Rows of W.
    weights: Packs<1>,
    shape: Shape<D>,
    edges: HalfEdges,
}

impl<const D: usize> Edge<D> {
    pub(crate) fn new(grid: &Grid<D>, shape: &Shape<D>, settings: &Settings) -> Self {
        let shape = match settings.equal_vertices {
            EqualVertices::Welded => weld(shape),
            EqualVertices::Apart => shape.clone(),
        };
        let weights = Packs::new(grid, &shape.points, |weight, _| [weight]);
        let edges = half_edges(&shape, settings.weights);
        Self { weights, shape, edges }
    }

    /// V' = W P' (paper, equation 4).
    fn moved(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        let mut moved = vec![[0.0; D]; self.shape.points.len()];
        let mut local = Vec::new();
        for block in &self.weights.blocks {
            local_handles(block, handles, &mut local);
            for pack in block.packs.clone() {
                let values = gather(self.weights.pack(block, pack), &local);
                for (lane, &vertex) in self.weights.order[pack].iter().enumerate() {
                    if let Some(slot) = moved.get_mut(vertex) {
                        *slot = std::array::from_fn(|d| values[d][0][lane]);
                    }
                }
            }
        }
        moved
    }

    /// Adds scale · Wᵀ b.
    fn add_transposed(&self, values: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) {
        let mut sums = Vec::new();
        for block in &self.weights.blocks {
            sums.clear();
            sums.resize(block.handles.len(), [[0.0; LANES]; D]);
            for pack in block.packs.clone() {
                let order = &self.weights.order[pack];
                let value = |d: usize, lane: usize| values.get(order[lane]).map_or(0.0, |value| value[d]);
                let lanes = std::array::from_fn(|d| [std::array::from_fn(|lane| value(d, lane))]);
                scatter(self.weights.pack(block, pack), &lanes, &mut sums);
            }
            add_sums(block, &sums, scale, right_side);
        }
    }

    /// W as a dense matrix, #vertices × #handles, by columns.
    fn dense_weights(&self, size: usize) -> Vec<f64> {
        let rows = self.shape.points.len();
        let mut dense = vec![0.0; rows * size];
        self.each_weight(|vertex, handle, weight| dense[handle * rows + vertex] = weight);
        dense
    }

    /// Calls `visit(vertex, handle, weight)` for all entries of W.
    fn each_weight(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for block in &self.weights.blocks {
            for pack in block.packs.clone() {
                for (coefficients, &handle) in self.weights.pack(block, pack).iter().zip(&block.handles) {
                    let rows = self.weights.order[pack].iter().zip(&coefficients[0]);
                    rows.filter(|(vertex, _)| **vertex != usize::MAX)
                        .for_each(|(&vertex, &weight)| visit(vertex, handle, weight));
                }
            }
        }
    }

    /// Wᵀ(LW) as one product; for bases in which all handles meet.
    fn add_dense_normal(&self, scale: f64, size: usize, normal: &mut Normal) {
        let rows = self.shape.points.len();
        let dense = self.dense_weights(size);
        let mut laplacian = vec![0.0; dense.len()];
        for (column, out) in dense.chunks_exact(rows).zip(laplacian.chunks_exact_mut(rows)) {
            for (vertex, slot) in out.iter_mut().enumerate() {
                *slot = self.edges.of(vertex).iter().map(|&(j, w)| w * (column[vertex] - column[j])).sum();
            }
        }
        normal.add_product(scale, &dense, &laplacian);
    }

    /// Σ w_ij (W_i − W_j)ᵀ(W_i − W_j) over undirected edges; for local bases.
    fn add_sparse_normal(&self, scale: f64, normal: &mut Normal) {
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.shape.points.len()];
        self.each_weight(|vertex, handle, weight| rows[vertex].push((handle, weight)));
        let mut difference: Vec<(usize, f64)> = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            for &(j, weight) in self.edges.of(i).iter().filter(|(j, _)| i < *j) {
                difference.clear();
                difference.extend(row);
                for &(handle, w) in &rows[j] {
                    match difference[..row.len()].iter_mut().find(|entry| entry.0 == handle) {
                        Some(entry) => entry.1 -= w,
                        None => difference.push((handle, -w)),
                    }
                }
                normal.add_row(scale * weight, difference.iter().copied());
            }
        }
    }

    fn rest_edge(&self, i: usize, j: usize) -> [f64; D] {
        minus(&self.shape.points[i], &self.shape.points[j])
    }
}

impl<const D: usize> Distortion<D> for Edge<D> {
    fn rotation_count(&self) -> usize {
        self.edges.vertex_count()
    }

    /// Σ w |e|² over half-edges is 4 × the area of a cotangent mesh.
    fn mass(&self) -> f64 {
        let half_edges = (0..self.edges.vertex_count()).flat_map(|i| self.edges.of(i).iter().map(move |e| (i, e)));
        0.5 * half_edges
            .map(|(i, &(j, weight))| {
                let edge = self.rest_edge(i, j);
                weight * dot(&edge, &edge)
            })
            .sum::<f64>()
    }

    /// Mesh edges join vertices of different cells, however long they are.
    fn reach(&self) -> usize {
        let mut ranges = vec![[usize::MAX, 0]; self.edges.vertex_count()];
        self.each_weight(|vertex, handle, _| {
            ranges[vertex] = [ranges[vertex][0].min(handle), ranges[vertex][1].max(handle)];
        });
        let pairs = (0..ranges.len()).flat_map(|i| self.edges.of(i).iter().map(move |&(j, _)| [i, j]));
        let edges = pairs.map(|[i, j]| ranges[i][1].max(ranges[j][1]) - ranges[i][0].min(ranges[j][0]));
        edges.max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        if self.weights.blocks.len() == 1 && normal.is_dense() {
            self.add_dense_normal(2.0 * scale, self.weights.blocks[0].handles.len(), normal);
        } else {
            self.add_sparse_normal(2.0 * scale, normal);
        }
    }

    fn local_step(
        &self,
        handles: &[[f64; D]],
        scale: f64,
        rotations: &mut [Square<D>],
        right_side: &mut [[f64; D]],
    ) -> f64 {
        let moved = self.moved(handles);
        for (i, rotation) in rotations.iter_mut().enumerate() {
            // S_i = Σ_j w_ij (v_i − v_j)(v'_i − v'_j)ᵀ.
            let mut s = [[0.0; D]; D];
            for &(j, weight) in self.edges.of(i) {
                let (rest, now) = (self.rest_edge(i, j), minus(&moved[i], &moved[j]));
                for a in 0..D {
                    (0..D).for_each(|b| s[a][b] += weight * rest[a] * now[b]);
                }
            }
            *rotation = best_rotation(&s);
        }
        let values: Vec<[f64; D]> = (0..moved.len()).map(|i| self.right_side_of(i, rotations)).collect();
        self.add_transposed(&values, 2.0 * scale, right_side);
        self.energy_of(&moved, rotations)
    }

    fn energy(&self, handles: &[[f64; D]], rotations: &[Square<D>]) -> f64 {
        self.energy_of(&self.moved(handles), rotations)
    }

    fn quality(&self, handles: &[[f64; D]]) -> Quality {
        let moved = self.moved(handles);
        let mut quality = Quality::new();
        for triangle in &self.shape.triangles {
            quality
                .add_triangle(triangle.map(|k| &self.shape.points[k as usize]), triangle.map(|k| &moved[k as usize]));
        }
        quality
    }
}

impl<const D: usize> Edge<D> {
    /// b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j).
    fn right_side_of(&self, i: usize, rotations: &[Square<D>]) -> [f64; D] {
        let mut sum = [0.0; D];
        for &(j, weight) in self.edges.of(i) {
            let edge = self.rest_edge(i, j);
            let (own, other) = (apply(&rotations[i], &edge), apply(&rotations[j], &edge));
            (0..D).for_each(|d| sum[d] += 0.5 * weight * (own[d] + other[d]));
        }
        sum
    }

    fn energy_of(&self, moved: &[[f64; D]], rotations: &[Square<D>]) -> f64 {
        let mut energy = 0.0;
        for (i, rotation) in rotations.iter().enumerate() {
            for &(j, weight) in self.edges.of(i) {
                let turned = apply(rotation, &self.rest_edge(i, j));
                let miss = minus(&minus(&moved[i], &moved[j]), &turned);
                energy += weight * dot(&miss, &miss);
            }
        }
        energy
    }
}
