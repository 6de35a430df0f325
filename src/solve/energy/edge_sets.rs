//! Energies Σ_s Σ_{(i,j)∈s} w ‖(v'_i − v'_j) − R_s (v_i − v_j)‖²: sets of edges with one rotation each (A. Jacobson et
//! al., "Fast automatic skinning transformations", 2012). Which edges make a set tells `edge`, `element`, `rims`, `stroke`.
//!
//! In: vertices, edges of sets. Normal matrix WᵀLW with each edge's weights of all sets added up; right side Wᵀb.

use super::area::Area;
use super::edge_packs::EdgePacks;
use super::fans::Fans;
use super::neighbours::{Edge, HalfEdges};
use super::vertices::Vertices;
use super::{Distortion, Quality};
use crate::solve::buckets::sort_in_buckets;
use crate::solve::matrix::Normal;
use crate::solve::point_weights::PointWeights;
use crate::solve::product::RowPairs;
use crate::solve::small::{Square, dot, minus};
use pulp::Simd;
use std::cmp::Ordering;

/// An edge as a member of any set; in several sets it counts several times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetEdge {
    /// The set.
    pub(crate) set: u32,
    /// Vertices, the lesser one first.
    pub(crate) ends: [u32; 2],
    /// w.
    pub(crate) weight: f64,
}

impl SetEdge {
    /// An edge between two vertices.
    pub(super) fn new(set: usize, [i, j]: [usize; 2], weight: f64) -> Self {
        Self { set: set as u32, ends: [i.min(j) as u32, i.max(j) as u32], weight }
    }

    /// By ends and set; equal ones by weight, so that sums do not depend on the order of triangles.
    fn order(&self, other: &Self) -> Ordering {
        let key = |edge: &Self| (edge.ends, edge.set);
        key(self).cmp(&key(other)).then_with(|| self.weight.total_cmp(&other.weight))
    }
}

/// Sorts edges between `count` vertices, and makes those of one set and the same ends one; edges without weight are left out.
pub(super) fn sorted(mut members: Vec<SetEdge>, count: usize) -> Vec<SetEdge> {
    members.retain(|member| member.weight != 0.0 && member.ends[0] != member.ends[1]);
    sort_in_buckets(&mut members, count, |member| member.ends[0] as usize, SetEdge::order);
    members.dedup_by(|next, member| {
        let is_same = (next.ends, next.set) == (member.ends, member.set);
        if is_same {
            member.weight += next.weight;
        }
        is_same
    });
    members
}

/// What the report on distortion looks at.
#[derive(Debug)]
pub(crate) enum Seen<const D: usize> {
    /// Triangles over the vertices.
    Triangles(Vec<[u32; 3]>),
    /// The lattice's gradient at samples.
    Samples(Area<D>),
}

/// Which edges make a set.
#[derive(Debug)]
enum Sets<const D: usize> {
    /// Those around a vertex.
    Fans(Fans<D>),
    /// Any.
    Any(EdgePacks<D>),
}

/// The energy.
#[derive(Debug)]
pub(crate) struct EdgeSets<const D: usize> {
    pub(crate) vertices: Vertices<D>,
    sets: Sets<D>,
    /// All edges, with the sum of their weights in all sets.
    edges: Vec<Edge>,
    /// Σ_s Σ w ‖v_i − v_j‖².
    squares: f64,
    seen: Seen<D>,
    mean_stiffness: f64,
}

impl<const D: usize> EdgeSets<D> {
    /// Each edge in the sets of both its ends; sorted, each once.
    pub(crate) fn around_vertices(vertices: Vertices<D>, mut edges: Vec<Edge>, seen: Seen<D>) -> Self {
        edges.retain(|edge| edge.weight != 0.0);
        let fans = Fans::new(&vertices.rest, &edges);
        edges.iter_mut().for_each(|edge| edge.weight *= 2.0);
        Self::of_sets(vertices, Sets::Fans(fans), edges, seen)
    }

    /// Edges of any sets, sorted by their ends and sets, each set of an edge once.
    pub(crate) fn new(vertices: Vertices<D>, members: &[SetEdge], seen: Seen<D>) -> Self {
        let sum = |same: &[SetEdge]| same.iter().map(|member| member.weight).sum();
        let edges = members.chunk_by(|a, b| a.ends == b.ends);
        let edges = edges.map(|same| Edge { ends: same[0].ends, weight: sum(same) }).collect();
        let packs = EdgePacks::new(&vertices.rest, members);
        Self::of_sets(vertices, Sets::Any(packs), edges, seen)
    }

    fn of_sets(vertices: Vertices<D>, sets: Sets<D>, edges: Vec<Edge>, seen: Seen<D>) -> Self {
        let squares = edges.iter().map(|edge| {
            let [i, j] = edge.ends.map(|end| &vertices.rest[end as usize]);
            let side = minus(i, j);
            edge.weight * dot(&side, &side)
        });
        let squares = squares.sum();
        Self { vertices, sets, edges, squares, seen, mean_stiffness: 1.0 }
    }

    /// The weights carry this stiffness on average: what is stiff does not make the rest soft.
    pub(crate) fn of_mean_stiffness(self, mean_stiffness: f64) -> Self {
        Self { mean_stiffness, ..self }
    }

    /// The best rotation of every set for moved vertices.
    pub(crate) fn rotations(&self, moved: &[[f64; D]]) -> Vec<Square<D>> {
        self.turn(moved).0
    }

    /// The rotations, and what the energy gains with them.
    fn turn(&self, moved: &[[f64; D]]) -> (Vec<Square<D>>, f64) {
        match &self.sets {
            Sets::Fans(fans) => fans.rotations(moved),
            Sets::Any(packs) => packs.rotations(moved),
        }
    }

    /// Σ w (W_i − W_j)ᵀ(W_i − W_j); for local bases.
    fn add_sparse_normal(&self, scale: f64, normal: &mut Normal) {
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

/// Rows of W and LW; for bases in which all handles meet.
struct LaplacianRows {
    weights: PointWeights,
    half_edges: HalfEdges,
    row: Vec<(usize, f64)>,
}

impl RowPairs for LaplacianRows {
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

/// Adds a multiple of one sparse row to another.
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
    /// Over the half-edges of a cotangent mesh Σ w ‖e‖² is 4 × its area.
    fn mass(&self) -> f64 {
        0.5 * self.squares / self.mean_stiffness
    }

    /// Edges join vertices of different cells, however long they are.
    fn reach(&self) -> usize {
        if self.vertices.products().is_some() {
            return self.vertices.reach();
        }
        let ranges = self.vertices.ranges();
        let edges = self.edges.iter().map(|edge| {
            let [a, b] = edge.ends.map(|end| ranges[end as usize]);
            a[1].max(b[1]) - a[0].min(b[0])
        });
        edges.max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        let Some(products) = self.vertices.products() else { return self.add_sparse_normal(scale, normal) };
        let half_edges = HalfEdges::new(self.vertices.rest.len(), &self.edges);
        let rows = &mut LaplacianRows { weights: products.by_point(), half_edges, row: Vec::new() };
        normal.add_product(scale, rows);
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64 {
        let (rotations, gain) = self.turn(&self.vertices.moved(handles));
        let values = match &self.sets {
            Sets::Fans(fans) => fans.right_side(&rotations),
            Sets::Any(packs) => packs.right_side(&rotations, self.vertices.rest.len()),
        };
        self.vertices.add_transposed(&values, scale, right_side);
        self.squares + gain
    }

    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64 {
        let rotations = self.rotations(&self.vertices.moved(turned_at));
        let moved = self.vertices.moved(handles);
        match &self.sets {
            Sets::Fans(fans) => fans.energy(&self.vertices.rest, &rotations, &moved),
            Sets::Any(packs) => packs.energy(&rotations, &moved),
        }
    }

    fn quality(&self, handles: &[[f64; D]]) -> Quality {
        let triangles = match &self.seen {
            Seen::Triangles(triangles) => triangles,
            Seen::Samples(area) => return area.quality(handles),
        };
        let (rest, moved) = (&self.vertices.rest, self.vertices.moved(handles));
        let mut quality = Quality::new();
        for triangle in triangles {
            quality.add_triangle(triangle.map(|k| &rest[k as usize]), triangle.map(|k| &moved[k as usize]));
        }
        quality
    }
}
