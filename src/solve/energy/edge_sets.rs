//! Energies Σ_s Σ_{(i,j)∈s} w ‖(v'_i − v'_j) − R_s (v_i − v_j)‖²: sets of edges with one rotation each (A. Jacobson et
//! al., "Fast automatic skinning transformations", 2012). Which edges make a set tells `edge`, `element`, `rims`, `stroke`.
//!
//! In: vertices, edges of sets. Normal matrix WᵀLW with each edge's weights of all sets added up; right side Wᵀb.

use super::area::Area;
use super::vertices::Vertices;
use super::{Distortion, Quality};
use crate::solve::buckets::sort_in_buckets;
use crate::solve::matrix::Normal;
use crate::solve::small::{Square, apply, best_rotation, dot, minus};

/// An edge as a member of a set; in several sets it counts several times.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SetEdge {
    /// The set.
    pub(crate) set: usize,
    /// Vertices.
    pub(crate) ends: [usize; 2],
    /// w.
    pub(crate) weight: f64,
}

/// What the report on distortion looks at.
#[derive(Debug)]
pub(crate) enum Seen<const D: usize> {
    /// Triangles over the vertices.
    Triangles(Vec<[u32; 3]>),
    /// The lattice's gradient at samples.
    Samples(Area<D>),
}

/// The energy.
#[derive(Debug)]
pub(crate) struct EdgeSets<const D: usize> {
    pub(crate) vertices: Vertices<D>,
    set_count: usize,
    links: Vec<Link<D>>,
    /// Set and weight, link after link.
    members: Vec<(usize, f64)>,
    seen: Seen<D>,
    mean_stiffness: f64,
}

/// An undirected edge.
#[derive(Clone, Debug)]
struct Link<const D: usize> {
    ends: [usize; 2],
    /// v_i − v_j.
    rest: [f64; D],
    /// Sum of its weights in all sets.
    weight: f64,
    members: std::ops::Range<usize>,
}

impl<const D: usize> EdgeSets<D> {
    /// Sorts the edges; sets are numbered from 0, edges without weight are left out.
    pub(crate) fn new(vertices: Vertices<D>, mut edges: Vec<SetEdge>, seen: Seen<D>) -> Self {
        let set_count = edges.iter().map(|edge| edge.set + 1).max().unwrap_or(0);
        edges.retain(|edge| edge.weight != 0.0 && edge.ends[0] != edge.ends[1]);
        edges.iter_mut().for_each(|edge| edge.ends.sort_unstable());
        let key = |edge: &SetEdge| (edge.ends[1], edge.set);
        let order = |a: &SetEdge, b: &SetEdge| key(a).cmp(&key(b)).then(a.weight.total_cmp(&b.weight));
        sort_in_buckets(&mut edges, vertices.rest.len(), |edge| edge.ends[0], order);
        let (mut links, mut members): (Vec<Link<D>>, Vec<(usize, f64)>) = (Vec::new(), Vec::new());
        for same in edges.chunk_by(|a, b| a.ends == b.ends) {
            let first = members.len();
            let sets = same.chunk_by(|a, b| a.set == b.set);
            members.extend(sets.map(|set| (set[0].set, set.iter().map(|edge| edge.weight).sum())));
            let [i, j] = same[0].ends;
            links.push(Link {
                ends: [i, j],
                rest: minus(&vertices.rest[i], &vertices.rest[j]),
                weight: members[first..].iter().map(|member| member.1).sum(),
                members: first..members.len(),
            });
        }
        Self { vertices, set_count, links, members, seen, mean_stiffness: 1.0 }
    }

    /// The weights carry this stiffness on average: what is stiff does not make the rest soft.
    pub(crate) fn of_mean_stiffness(self, mean_stiffness: f64) -> Self {
        Self { mean_stiffness, ..self }
    }

    /// S_s = Σ w (v_i − v_j)(v'_i − v'_j)ᵀ of every set, and Σ_s Σ w (‖v'_i − v'_j‖² + ‖v_i − v_j‖²).
    fn covariances(&self, moved: &[[f64; D]]) -> (Vec<Square<D>>, f64) {
        let mut covariances = vec![[[0.0; D]; D]; self.set_count];
        let mut squares = 0.0;
        for link in &self.links {
            let now = link.now(moved);
            squares += link.weight * (dot(&now, &now) + dot(&link.rest, &link.rest));
            for &(set, weight) in &self.members[link.members.clone()] {
                for (row, along) in covariances[set].iter_mut().zip(&link.rest) {
                    row.iter_mut().zip(&now).for_each(|(slot, x)| *slot += weight * along * x);
                }
            }
        }
        (covariances, squares)
    }

    /// The best rotation of every set for moved vertices.
    pub(crate) fn rotations(&self, moved: &[[f64; D]]) -> Vec<Square<D>> {
        self.covariances(moved).0.iter().map(best_rotation).collect()
    }

    /// b_i = Σ_s Σ_{(i,j)∈s} w R_s (v_i − v_j).
    fn right_side(&self, rotations: &[Square<D>]) -> Vec<[f64; D]> {
        let mut values = vec![[0.0; D]; self.vertices.rest.len()];
        for link in &self.links {
            let [i, j] = link.ends;
            let mut turned = [0.0; D];
            for &(set, weight) in &self.members[link.members.clone()] {
                let image = apply(&rotations[set], &link.rest);
                (0..D).for_each(|d| turned[d] += weight * image[d]);
            }
            for d in 0..D {
                values[i][d] += turned[d];
                values[j][d] -= turned[d];
            }
        }
        values
    }

    /// Wᵀ(LW) as one product; for bases in which all handles meet.
    fn add_dense_normal(&self, scale: f64, size: usize, normal: &mut Normal) {
        let dense = self.vertices.dense(size);
        let mut laplacian = vec![0.0; dense.len()];
        for link in &self.links {
            let [i, j] = link.ends.map(|end| &dense[end * size..][..size]);
            // The first end is the lesser one.
            let (rows, later) = laplacian.split_at_mut(link.ends[1] * size);
            let slots = rows[link.ends[0] * size..][..size].iter_mut().zip(&mut later[..size]);
            for ((slot, other), (a, b)) in slots.zip(i.iter().zip(j)) {
                let difference = link.weight * (a - b);
                *slot += difference;
                *other -= difference;
            }
        }
        normal.add_product(scale, &dense, &laplacian);
    }

    /// Σ w (W_i − W_j)ᵀ(W_i − W_j); for local bases.
    fn add_sparse_normal(&self, scale: f64, normal: &mut Normal) {
        let rows = self.vertices.rows();
        let mut difference = Vec::new();
        for link in &self.links {
            let [i, j] = link.ends;
            difference.clear();
            difference.extend(&rows[i]);
            add_to_row(&mut difference, &rows[j], -1.0);
            normal.add_row(scale * link.weight, &difference);
        }
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

impl<const D: usize> Link<D> {
    /// v'_i − v'_j.
    fn now(&self, moved: &[[f64; D]]) -> [f64; D] {
        minus(&moved[self.ends[0]], &moved[self.ends[1]])
    }
}

impl<const D: usize> Distortion<D> for EdgeSets<D> {
    /// Over the half-edges of a cotangent mesh Σ w ‖e‖² is 4 × its area.
    fn mass(&self) -> f64 {
        let sum: f64 = self.links.iter().map(|link| link.weight * dot(&link.rest, &link.rest)).sum();
        0.5 * sum / self.mean_stiffness
    }

    /// Edges join vertices of different cells, however long they are.
    fn reach(&self) -> usize {
        if self.vertices.shared_handles().is_some() {
            return self.vertices.reach();
        }
        let ranges = self.vertices.ranges();
        let edges = self.links.iter().map(|link| {
            let [a, b] = link.ends.map(|end| ranges[end]);
            a[1].max(b[1]) - a[0].min(b[0])
        });
        edges.max().unwrap_or(0)
    }

    fn add_normal(&self, scale: f64, normal: &mut Normal) {
        match self.vertices.shared_handles().filter(|&shared| normal.is_full(shared)) {
            Some(size) => self.add_dense_normal(scale, size, normal),
            None => self.add_sparse_normal(scale, normal),
        }
    }

    fn local_step(&self, handles: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) -> f64 {
        let (mut matrices, squares) = self.covariances(&self.vertices.moved(handles));
        let mut gain = 0.0;
        for matrix in &mut matrices {
            let rotation = best_rotation(matrix);
            gain += (0..D).map(|a| (0..D).map(|b| rotation[a][b] * matrix[b][a]).sum::<f64>()).sum::<f64>();
            *matrix = rotation;
        }
        self.vertices.add_transposed(&self.right_side(&matrices), scale, right_side);
        // Σ w ‖e' − R e‖² = Σ w (‖e'‖² + ‖e‖²) − 2 Σ tr(R S).
        squares - 2.0 * gain
    }

    fn energy(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> f64 {
        let rotations = self.rotations(&self.vertices.moved(turned_at));
        let moved = self.vertices.moved(handles);
        let parts = self.links.iter().flat_map(|link| {
            let now = link.now(&moved);
            let rotations = &rotations;
            self.members[link.members.clone()].iter().map(move |&(set, weight)| {
                let miss = minus(&now, &apply(&rotations[set], &link.rest));
                weight * dot(&miss, &miss)
            })
        });
        parts.sum()
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
