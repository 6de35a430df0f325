//! One-rings in SIMD packets of four vertices: the edge sets of energies in which each edge belongs to the sets of both its ends
//! with the same weight.
//!
//! In: edges; moved vertices. Out: the best rotation of every vertex, and the right-hand side.

use super::mesh_edges::Edge;
use super::packets::{Ids, add_edge, best_rotations, points_of, rotations_of, slot_starts};
use crate::simd::dispatch;
use crate::solve::linalg::simd::{LANES, Lanes, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{SquareMatrix, apply, dot, minus};
use pulp::{Simd, WithSimd};

/// One edge of each of four vertices; the weight is 0 in unused lanes.
#[derive(Clone, Debug)]
struct Slot<const D: usize> {
    /// The vertices j at the other ends.
    others: Ids,
    /// w (v_i − v_j).
    edge: [Lanes; D],
    /// w.
    weight: Lanes,
}

/// The edges around every vertex.
#[derive(Debug)]
pub(super) struct OneRings<const D: usize> {
    count: usize,
    /// First slot of every group of four vertices, and the end of the last group.
    starts: Vec<usize>,
    slots: Vec<Slot<D>>,
}

impl<const D: usize> OneRings<D> {
    /// Packs the edges between vertices at rest.
    pub(super) fn new(rest: &[[f64; D]], edges: &[Edge]) -> Self {
        let mut sizes = vec![0; rest.len().next_multiple_of(LANES)];
        edges.iter().flat_map(|edge| edge.ends).for_each(|end| sizes[end as usize] += 1);
        let starts = slot_starts(&sizes);
        let count = starts[sizes.len() / LANES];
        let mut slots = vec![Slot { others: [0; LANES], edge: [[0.0; LANES]; D], weight: [0.0; LANES] }; count];
        for edge in edges.iter().rev() {
            let [i, j] = edge.ends;
            for [own, other] in [[i, j], [j, i]] {
                let vertex = own as usize;
                sizes[vertex] -= 1;
                let slot = &mut slots[starts[vertex / LANES] + sizes[vertex]];
                let (lane, side) = (vertex % LANES, minus(&rest[vertex], &rest[other as usize]));
                (slot.others[lane], slot.weight[lane]) = (other, edge.weight);
                (0..D).for_each(|d| slot.edge[d][lane] = edge.weight * side[d]);
            }
        }
        Self { count: rest.len(), starts, slots }
    }

    /// Vertices of a packet; lanes beyond the last vertex repeat it (their edges have weight 0).
    #[inline(always)]
    fn own(&self, packet: usize) -> Ids {
        let vertex = |lane: usize| (packet * LANES + lane).min(self.count - 1) as u32;
        [vertex(0), vertex(1), vertex(2), vertex(3)]
    }

    /// Returns the best rotation of every one-ring for moved vertices, and
    /// Σ_i Σ_j w (‖v'_i − v'_j‖² − 2 (v'_i − v'_j)ᵀ R_i (v_i − v_j)).
    pub(super) fn rotations(&self, moved: &[[f64; D]]) -> (Vec<SquareMatrix<D>>, f64) {
        dispatch(Rotations { one_rings: self, moved })
    }

    /// Returns b_i = Σ_j w (R_i + R_j)(v_i − v_j).
    pub(super) fn right_side(&self, rotations: &[SquareMatrix<D>]) -> Vec<[f64; D]> {
        dispatch(RightSide { one_rings: self, rotations })
    }

    /// Energy Σ_i Σ_j w ‖(v'_i − v'_j) − R_i (v_i − v_j)‖².
    pub(super) fn energy(&self, rest: &[[f64; D]], rotations: &[SquareMatrix<D>], moved: &[[f64; D]]) -> f64 {
        let mut sum = 0.0;
        for (vertex, rotation) in rotations.iter().enumerate() {
            let (packet, lane) = (vertex / LANES, vertex % LANES);
            for slot in &self.slots[self.starts[packet]..self.starts[packet + 1]] {
                let other = slot.others[lane] as usize;
                let now = minus(&moved[vertex], &moved[other]);
                let miss = minus(&now, &apply(rotation, &minus(&rest[vertex], &rest[other])));
                sum += slot.weight[lane] * dot(&miss, &miss);
            }
        }
        sum
    }
}

/// Kernel of [`OneRings::rotations`].
struct Rotations<'a, const D: usize> {
    one_rings: &'a OneRings<D>,
    moved: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Rotations<'_, D> {
    type Output = (Vec<SquareMatrix<D>>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Vec<SquareMatrix<D>>, f64) {
        let Self { one_rings, moved } = self;
        let zero = simd.splat_f64s(0.0);
        let (mut squares, mut gain) = (zero, 0.0);
        let mut rotations = vec![[[0.0; D]; D]; (one_rings.starts.len() - 1) * LANES];
        for (packet, rotations) in rotations.chunks_exact_mut(LANES).enumerate() {
            let own = points_of(simd, moved, &one_rings.own(packet));
            let mut sums = [[zero; D]; D];
            for slot in &one_rings.slots[one_rings.starts[packet]..one_rings.starts[packet + 1]] {
                let ends = [points_of(simd, moved, &slot.others), own];
                let square = add_edge(simd, &slot.edge, ends, &mut sums);
                squares = multiply_add(simd, load::<S>(&slot.weight), square, squares);
            }
            gain += best_rotations(simd, &sums, rotations);
        }
        rotations.truncate(one_rings.count);
        (rotations, store::<S>(squares).iter().sum::<f64>() - 2.0 * gain)
    }
}

/// Kernel of [`OneRings::right_side`].
struct RightSide<'a, const D: usize> {
    one_rings: &'a OneRings<D>,
    rotations: &'a [SquareMatrix<D>],
}

impl<const D: usize> WithSimd for RightSide<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let Self { one_rings, rotations } = self;
        let mut values = vec![[0.0; D]; one_rings.count];
        for (packet, values) in values.chunks_mut(LANES).enumerate() {
            let own = rotations_of(simd, rotations, &one_rings.own(packet));
            let mut sides = [simd.splat_f64s(0.0); D];
            for slot in &one_rings.slots[one_rings.starts[packet]..one_rings.starts[packet + 1]] {
                let others = rotations_of(simd, rotations, &slot.others);
                for (row, side) in sides.iter_mut().enumerate() {
                    for (column, edge) in slot.edge.iter().enumerate() {
                        let both = simd.add_f64s(own[row][column], others[row][column]);
                        *side = multiply_add(simd, both, load::<S>(edge), *side);
                    }
                }
            }
            for (d, side) in sides.into_iter().enumerate() {
                values.iter_mut().zip(store::<S>(side)).for_each(|(slot, x)| slot[d] = x);
            }
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::super::edge_set_packets::EdgeSetPackets;
    use super::super::set_edges::SetEdge;
    use super::*;

    /// Compares one-rings with general edge sets, on vertices of which some have many edges and the last has none.
    fn compare<const D: usize>(count: usize) {
        let place = |k: usize, phase: f64| std::array::from_fn(|d| (phase * k as f64 + 2.0 * d as f64).sin());
        let rest: Vec<[f64; D]> = (0..count).map(|k| place(k, 1.3)).collect();
        let moved: Vec<[f64; D]> = (0..count).map(|k| place(k, 1.4)).collect();
        let pairs = (0..count - 1).flat_map(|i| (i + 1..count - 1).map(move |j| [i, j]));
        let edges: Vec<Edge> = pairs
            .filter(|[i, j]| j - i < 3 || i % 5 == 0)
            .map(|[i, j]| Edge::new([i, j], 0.2 + ((i + 3 * j) as f64).cos()))
            .collect();
        let members: Vec<SetEdge> =
            edges.iter().flat_map(|&Edge { ends, weight }| ends.map(|set| SetEdge { set, ends, weight })).collect();
        let (one_rings, packets) = (OneRings::new(&rest, &edges), EdgeSetPackets::new(&rest, &members));
        let ((turned, gain), (wanted, wanted_gain)) = (one_rings.rotations(&moved), packets.rotations(&moved));
        let is_near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        // The last vertex has no edges and therefore no set.
        assert!(is_near(turned[..count - 1].as_flattened().as_flattened(), wanted.as_flattened().as_flattened()));
        assert!((gain - wanted_gain).abs() < 1e-12 * wanted_gain.abs().max(1.0), "{gain} {wanted_gain}");
        let sides = [one_rings.right_side(&turned), packets.right_side(&wanted, count)];
        assert!(is_near(sides[0].as_flattened(), sides[1].as_flattened()));
        let energies = [one_rings.energy(&rest, &turned, &moved), packets.energy(&wanted, &moved)];
        assert!((energies[0] - energies[1]).abs() < 1e-12 * energies[1].abs().max(1.0), "{energies:?}");
    }

    #[test]
    fn fans_are_the_sets_around_vertices() {
        for count in [3, 8, 13, 30] {
            compare::<2>(count);
            compare::<3>(count);
        }
    }
}
