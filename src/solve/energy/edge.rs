//! Energy `edge`: Σ_i Σ_{j∈N(i)} w_ij ‖(v'_i − v'_j) − R_i (v_i − v_j)‖², V' = W P' (paper, equations 3 to 5).
//!
//! In: a mesh. Normal matrix 2 WᵀLW; right side 2 Wᵀb with b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j).

use super::neighbours::{HalfEdges, half_edges};
use super::{Distortion, Quality};
use crate::lattice::Grid;
use crate::solve::matrix::Normal;
use crate::solve::packs::{LANES, Packs, add_sums, dispatch, gather, load, local_handles, scatter, store};
use crate::solve::small::{Square, apply, best_rotation, dot, minus};
use crate::solve::weld::weld;
use crate::solve::{EqualVertices, Settings, Shape};
use pulp::{Simd, WithSimd};

/// The energy of a mesh.
#[derive(Debug)]
pub(crate) struct Edge<const D: usize> {
    /// Rows of W.
    weights: Packs<1>,
    shape: Shape<D>,
    half_edges: HalfEdges,
    edges: Vec<RestEdge<D>>,
}

/// An undirected edge; both half-edges count.
#[derive(Clone, Copy, Debug)]
struct RestEdge<const D: usize> {
    ends: [u32; 2],
    weight: f64,
    /// v_i − v_j.
    rest: [f64; D],
}

impl<const D: usize> RestEdge<D> {
    fn ends(&self) -> [usize; 2] {
        self.ends.map(|end| end as usize)
    }
}

impl<const D: usize> Edge<D> {
    pub(crate) fn new(grid: &Grid<D>, shape: &Shape<D>, settings: &Settings) -> Self {
        let shape = match settings.equal_vertices {
            EqualVertices::Welded => weld(shape),
            EqualVertices::Apart => shape.clone(),
        };
        let weights = Packs::new(grid, &shape.points, |weight, _| [weight]);
        let half_edges = half_edges(&shape, settings.weights);
        let mut edges = Vec::new();
        for i in 0..shape.points.len() {
            edges.extend(half_edges.of(i).iter().filter(|(j, _)| i < *j).map(|&(j, weight)| RestEdge {
                ends: [i, j].map(|end| end as u32),
                weight,
                rest: minus(&shape.points[i], &shape.points[j]),
            }));
        }
        Self { weights, shape, half_edges, edges }
    }

    /// V' = W P' (paper, equation 4).
    fn moved(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        dispatch(Moved { energy: self, handles })
    }

    /// W, row by row, #vertices × #handles.
    fn dense_weights(&self, size: usize) -> Vec<f64> {
        let mut dense = vec![0.0; self.shape.points.len() * size];
        self.each_weight(|vertex, handle, weight| dense[vertex * size + handle] = weight);
        dense
    }

    /// Calls `visit(vertex, handle, weight)` for all entries of W.
    fn each_weight(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for block in &self.weights.blocks {
            for pack in block.packs.clone() {
                let rows = self.weights.order[pack];
                for (coefficients, &handle) in self.weights.pack(block, pack).iter().zip(&block.handles) {
                    (0..LANES)
                        .filter(|&lane| rows[lane] != usize::MAX)
                        .for_each(|lane| visit(rows[lane], handle, coefficients[0][lane]));
                }
            }
        }
    }

    /// Wᵀ(LW) as one product; for bases in which all handles meet.
    fn add_dense_normal(&self, scale: f64, size: usize, normal: &mut Normal) {
        let dense = self.dense_weights(size);
        let mut laplacian = vec![0.0; dense.len()];
        for (i, out) in laplacian.chunks_exact_mut(size).enumerate() {
            let own = &dense[i * size..][..size];
            for &(j, weight) in self.half_edges.of(i) {
                let other = &dense[j * size..][..size];
                out.iter_mut().zip(own.iter().zip(other)).for_each(|(x, (a, b))| *x += weight * (a - b));
            }
        }
        normal.add_product(scale, &dense, &laplacian);
    }

    /// Σ w_ij (W_i − W_j)ᵀ(W_i − W_j) over undirected edges; for local bases.
    fn add_sparse_normal(&self, scale: f64, normal: &mut Normal) {
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.shape.points.len()];
        self.each_weight(|vertex, handle, weight| rows[vertex].push((handle, weight)));
        let mut difference: Vec<(usize, f64)> = Vec::new();
        for edge in &self.edges {
            let [i, j] = edge.ends();
            difference.clear();
            difference.extend(&rows[i]);
            for &(handle, w) in &rows[j] {
                match difference[..rows[i].len()].iter_mut().find(|entry| entry.0 == handle) {
                    Some(entry) => entry.1 -= w,
                    None => difference.push((handle, -w)),
                }
            }
            normal.add_row(scale * edge.weight, difference.iter().copied());
        }
    }

    /// S_i = Σ_j w_ij (v_i − v_j)(v'_i − v'_j)ᵀ, and Σ_i Σ_j w_ij (‖v'_i − v'_j‖² + ‖v_i − v_j‖²).
    fn covariances(&self, moved: &[[f64; D]]) -> (Vec<Square<D>>, f64) {
        let mut covariances = vec![[[0.0; D]; D]; moved.len()];
        let mut squares = 0.0;
        for edge in &self.edges {
            let [i, j] = edge.ends();
            let now = minus(&moved[i], &moved[j]);
            squares += edge.weight * (dot(&now, &now) + dot(&edge.rest, &edge.rest));
            // Both ends see the same product: each looks along the edge from its own side.
            for end in [i, j] {
                for (row, along) in covariances[end].iter_mut().zip(&edge.rest) {
                    row.iter_mut().zip(&now).for_each(|(slot, x)| *slot += edge.weight * along * x);
                }
            }
        }
        (covariances, 2.0 * squares)
    }

    /// b_i = Σ_j w_ij ½(R_i + R_j)(v_i − v_j).
    fn right_side(&self, rotations: &[Square<D>]) -> Vec<[f64; D]> {
        let mut values = vec![[0.0; D]; rotations.len()];
        for edge in &self.edges {
            let [i, j] = edge.ends();
            for d in 0..D {
                let turned = dot(&rotations[i][d], &edge.rest) + dot(&rotations[j][d], &edge.rest);
                let half = 0.5 * edge.weight * turned;
                values[i][d] += half;
                values[j][d] -= half;
            }
        }
        values
    }
}

impl<const D: usize> Distortion<D> for Edge<D> {
    /// Σ w |e|² over half-edges is 4 × the area of a cotangent mesh.
    fn mass(&self) -> f64 {
        self.edges.iter().map(|edge| edge.weight * dot(&edge.rest, &edge.rest)).sum()
    }

    /// Mesh edges join vertices of different cells, however long they are.
    fn reach(&self) -> usize {
        if self.weights.blocks.len() == 1 {
            return self.weights.reach();
        }
        let mut ranges = vec![[usize::MAX, 0]; self.shape.points.len()];
        self.each_weight(|vertex, handle, _| {
            ranges[vertex] = [ranges[vertex][0].min(handle), ranges[vertex][1].max(handle)];
        });
        let edges = self.edges.iter().map(|edge| {
            let [a, b] = edge.ends().map(|end| ranges[end]);
            a[1].max(b[1]) - a[0].min(b[0])
        });
        edges.max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        if self.weights.blocks.len() == 1 && normal.is_dense() {
            self.add_dense_normal(2.0 * scale, self.weights.blocks[0].handles.len(), normal);
        } else {
            self.add_sparse_normal(2.0 * scale, normal);
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64 {
        let (mut matrices, squares) = self.covariances(&self.moved(handles));
        let mut gain = 0.0;
        for matrix in &mut matrices {
            let rotation = best_rotation(matrix);
            gain += (0..D).map(|a| (0..D).map(|b| rotation[a][b] * matrix[b][a]).sum::<f64>()).sum::<f64>();
            *matrix = rotation;
        }
        let values = self.right_side(&matrices);
        dispatch(Transposed { energy: self, values: &values, scale: 2.0 * scale, right_side });
        // Σ w ‖e' − R e‖² = Σ w (‖e'‖² + ‖e‖²) − 2 Σ tr(R S).
        squares - 2.0 * gain
    }

    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64 {
        let rotations: Vec<Square<D>> = self.covariances(&self.moved(turned_at)).0.iter().map(best_rotation).collect();
        let moved = self.moved(handles);
        let parts = self.edges.iter().map(|edge| {
            let [i, j] = edge.ends();
            let now = minus(&moved[i], &moved[j]);
            let miss = |end: usize| {
                let miss = minus(&now, &apply(&rotations[end], &edge.rest));
                dot(&miss, &miss)
            };
            edge.weight * (miss(i) + miss(j))
        });
        parts.sum()
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

/// Kernel of [`Edge::moved`].
struct Moved<'a, const D: usize> {
    energy: &'a Edge<D>,
    handles: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Moved<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let weights = &self.energy.weights;
        let mut moved = vec![[0.0; D]; self.energy.shape.points.len()];
        let mut local = Vec::new();
        for block in &weights.blocks {
            local_handles(block, self.handles, &mut local);
            for pack in block.packs.clone() {
                let values = gather(simd, weights.pack(block, pack), &local).map(|[x]| store::<S>(x));
                for (lane, &vertex) in weights.order[pack].iter().enumerate() {
                    if let Some(slot) = moved.get_mut(vertex) {
                        *slot = std::array::from_fn(|d| values[d][lane]);
                    }
                }
            }
        }
        moved
    }
}

/// Kernel that adds scale · Wᵀ values.
struct Transposed<'a, const D: usize> {
    energy: &'a Edge<D>,
    values: &'a [[f64; D]],
    scale: f64,
    right_side: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Transposed<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let weights = &self.energy.weights;
        let mut sums = Vec::new();
        for block in &weights.blocks {
            sums.clear();
            sums.resize(block.handles.len(), [[0.0; LANES]; D]);
            for pack in block.packs.clone() {
                let rows = weights.order[pack].map(|row| self.values.get(row).copied().unwrap_or([0.0; D]));
                let lanes = std::array::from_fn(|d| [load::<S>(&rows.map(|row| row[d]))]);
                scatter(simd, weights.pack(block, pack), &lanes, &mut sums);
            }
            add_sums(block, &sums, self.scale, self.right_side);
        }
    }
}
