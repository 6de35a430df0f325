//! Energies of edge sets, Σ_s Σ_{(i,j)∈s} w ‖(v'_i − v'_j) − R_s (v_i − v_j)‖², with one rotation per set (A. Jacobson et al.,
//! "Fast automatic skinning transformations", 2012). Files `edge`, `element`, `spokes_and_rims` and `stroke` define the sets.
//!
//! In: vertices, and edges with their sets. Out: the normal matrix WᵀLW, in which each edge has the sum of its weights in all
//! sets, and the right-hand side Wᵀb.

use super::area::Area;
use super::distortion::{Distortion, DistortionMetrics};
use super::edge_set_packets::EdgeSetPackets;
use super::embedded_vertices::EmbeddedVertices;
use super::mesh_edges::{Edge, HalfEdges};
use super::one_rings::OneRings;
use super::set_edges::SetEdge;
use crate::solve::cancel::Cancel;
use crate::solve::linalg::normal_matrix::NormalMatrix;
use crate::solve::linalg::small_matrix::{SquareMatrix, dot, minus};
use crate::solve::linalg::syrk::SyrkRows;
use crate::solve::separable_rows::SeparableRows;
use pulp::Simd;

/// Where the distortion metrics are measured.
#[derive(Debug)]
pub(crate) enum MetricSource<const D: usize> {
    /// On triangles of the vertices.
    Triangles(Vec<[u32; 3]>),
    /// On the gradient of the lattice at samples.
    Samples(Area<D>),
}

/// Layout of the sets.
#[derive(Debug)]
enum Sets<const D: usize> {
    /// One set per vertex: its one-ring.
    OneRings(OneRings<D>),
    /// General sets.
    Any(EdgeSetPackets<D>),
}

/// The energy of all sets.
#[derive(Debug)]
pub(crate) struct EdgeSets<const D: usize> {
    pub(crate) vertices: EmbeddedVertices<D>,
    sets: Sets<D>,
    /// All edges, each with the sum of its weights in all sets.
    edges: Vec<Edge>,
    /// Constant part of the energy, Σ_s Σ w ‖v_i − v_j‖².
    squares: f64,
    metric_source: MetricSource<D>,
    mean_stiffness: f64,
}

impl<const D: usize> EdgeSets<D> {
    /// Builds the energy whose sets are the one-rings of the vertices. `edges` are sorted and distinct.
    pub(crate) fn around_vertices(
        vertices: EmbeddedVertices<D>,
        mut edges: Vec<Edge>,
        metric_source: MetricSource<D>,
    ) -> Self {
        edges.retain(|edge| edge.weight != 0.0);
        let one_rings = OneRings::new(&vertices.rest, &edges);
        edges.iter_mut().for_each(|edge| edge.weight *= 2.0);
        Self::of_sets(vertices, Sets::OneRings(one_rings), edges, metric_source)
    }

    /// Builds the energy of general sets. `members` are sorted by ends, then by set; each pair of edge and set occurs once.
    pub(crate) fn new(vertices: EmbeddedVertices<D>, members: &[SetEdge], metric_source: MetricSource<D>) -> Self {
        let sum = |same: &[SetEdge]| same.iter().map(|member| member.weight).sum();
        let edges = members.chunk_by(|a, b| a.ends == b.ends);
        let edges = edges.map(|same| Edge { ends: same[0].ends, weight: sum(same) }).collect();
        let packets = EdgeSetPackets::new(&vertices.rest, members);
        Self::of_sets(vertices, Sets::Any(packets), edges, metric_source)
    }

    fn of_sets(vertices: EmbeddedVertices<D>, sets: Sets<D>, edges: Vec<Edge>, metric_source: MetricSource<D>) -> Self {
        let squares = edges.iter().map(|edge| {
            let [i, j] = edge.ends.map(|end| &vertices.rest[end as usize]);
            let side = minus(i, j);
            edge.weight * dot(&side, &side)
        });
        let squares = squares.sum();
        Self { vertices, sets, edges, squares, metric_source, mean_stiffness: 1.0 }
    }

    /// Sets the mean stiffness that the weights contain. The mass is divided by it, so that stiff parts do not soften the rest.
    pub(crate) fn with_mean_stiffness(self, mean_stiffness: f64) -> Self {
        Self { mean_stiffness, ..self }
    }

    /// Returns the best rotation of every set for moved vertices.
    pub(crate) fn rotations(&self, moved: &[[f64; D]]) -> Vec<SquareMatrix<D>> {
        self.rotations_and_energy(moved).0
    }

    /// Returns the best rotations, and the energy under them without its constant part `squares`.
    fn rotations_and_energy(&self, moved: &[[f64; D]]) -> (Vec<SquareMatrix<D>>, f64) {
        match &self.sets {
            Sets::OneRings(one_rings) => one_rings.rotations(moved),
            Sets::Any(packets) => packets.rotations(moved),
        }
    }

    /// Adds Σ w (W_i − W_j)ᵀ(W_i − W_j), for bases of local support.
    fn add_sparse_normal(&self, scale: f64, normal: &mut NormalMatrix) {
        let rows = self.vertices.rows();
        let mut difference = Vec::new();
        for edge in &self.edges {
            let [i, j] = edge.ends.map(|end| end as usize);
            difference.clear();
            difference.extend(&rows[i]);
            add_to_row(&mut difference, &rows[j], -1.0);
            normal.add_row(scale * edge.weight, &difference);
        }
    }
}

/// Rows of W and LW, for bases of global support.
struct LaplacianRows {
    weights: SeparableRows,
    half_edges: HalfEdges,
    row: Vec<(usize, f64)>,
}

impl SyrkRows for LaplacianRows {
    fn count(&self) -> usize {
        self.half_edges.vertex_count()
    }

    #[inline(always)]
    fn write<S: Simd>(&mut self, simd: S, vertex: usize, [a, b]: [&mut [f64]; 2]) {
        self.weights.write(simd, &[(vertex, 1.0)], a);
        self.half_edges.laplacian_row(vertex, &mut self.row);
        self.weights.write(simd, &self.row, b);
    }
}

/// Adds a multiple of a sparse row to another; entries of `row` are (handle, coefficient).
pub(super) fn add_to_row(row: &mut Vec<(usize, f64)>, other: &[(usize, f64)], factor: f64) {
    let known = row.len();
    for &(handle, w) in other {
        match row[..known].iter_mut().find(|entry| entry.0 == handle) {
            Some(entry) => entry.1 += factor * w,
            None => row.push((handle, factor * w)),
        }
    }
}

impl<const D: usize> Distortion<D> for EdgeSets<D> {
    /// Half of Σ w ‖e‖², which over the half-edges of a cotangent mesh is 4 × its area.
    fn mass(&self) -> f64 {
        0.5 * self.squares / self.mean_stiffness
    }

    /// Edges may connect vertices of distant cells, so the bandwidth can exceed that of a row of W.
    fn bandwidth(&self) -> usize {
        if self.vertices.separable().is_some() {
            return self.vertices.bandwidth();
        }
        let ranges = self.vertices.ranges();
        let edges = self.edges.iter().map(|edge| {
            let [a, b] = edge.ends.map(|end| ranges[end as usize]);
            a[1].max(b[1]) - a[0].min(b[0])
        });
        edges.max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut NormalMatrix, cancel: &Cancel) {
        let Some(separable) = self.vertices.separable() else { return self.add_sparse_normal(scale, normal) };
        let half_edges = HalfEdges::new(self.vertices.rest.len(), &self.edges);
        let rows = &mut LaplacianRows { weights: separable.by_point(), half_edges, row: Vec::new() };
        normal.add_syrk(scale, rows, cancel);
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]], _cancel: &Cancel) -> f64 {
        let (rotations, gain) = self.rotations_and_energy(&self.vertices.moved(handles));
        let values = match &self.sets {
            Sets::OneRings(one_rings) => one_rings.right_side(&rotations),
            Sets::Any(packets) => packets.right_side(&rotations, self.vertices.rest.len()),
        };
        self.vertices.add_transposed(&values, scale, right_side);
        self.squares + gain
    }

    fn energy(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> f64 {
        let rotations = self.rotations(&self.vertices.moved(rotations_at));
        let moved = self.vertices.moved(handles);
        match &self.sets {
            Sets::OneRings(one_rings) => one_rings.energy(&self.vertices.rest, &rotations, &moved),
            Sets::Any(packets) => packets.energy(&rotations, &moved),
        }
    }

    fn metrics(&self, handles: &[[f64; D]]) -> DistortionMetrics {
        let triangles = match &self.metric_source {
            MetricSource::Triangles(triangles) => triangles,
            MetricSource::Samples(area) => return area.metrics(handles),
        };
        let (rest, moved) = (&self.vertices.rest, self.vertices.moved(handles));
        let mut metrics = DistortionMetrics::new();
        for triangle in triangles {
            metrics.add_triangle(triangle.map(|k| &rest[k as usize]), triangle.map(|k| &moved[k as usize]));
        }
        metrics
    }
}
