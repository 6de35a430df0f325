//! The edges around every vertex, four vertices together so that loops run in vector registers: the sets of energies in which
//! each edge is in the sets of both its ends, with one weight.
//!
//! In: edges; moved vertices. Out: the best rotation of every vertex, and the right side of the edges.

use super::neighbours::Edge;
use super::quads::{Ids, points_of, rotate, rotations_of};
use crate::solve::packs::{LANES, Lanes, add_multiple, dispatch, load, multiply_add, store};
use crate::solve::small::{Square, apply, dot, minus};
use pulp::{Simd, WithSimd};

/// An edge of each of four vertices; lanes without one weigh nothing.
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
pub(super) struct Fans<const D: usize> {
    count: usize,
    /// Where the slots of every four vertices start, and where the last ones end.
    starts: Vec<usize>,
    slots: Vec<Slot<D>>,
}

impl<const D: usize> Fans<D> {
    /// Packs the edges between vertices at rest.
    pub(super) fn new(rest: &[[f64; D]], edges: &[Edge]) -> Self {
        let mut sizes = vec![0; rest.len().next_multiple_of(LANES)];
        edges.iter().flat_map(|edge| edge.ends).for_each(|end| sizes[end as usize] += 1);
        let mut starts = Vec::with_capacity(sizes.len() / LANES + 1);
        let mut count = 0;
        starts.push(0);
        for sizes in sizes.chunks_exact(LANES) {
            count += sizes.iter().copied().max().unwrap_or(0);
            starts.push(count);
        }
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

    /// Four vertices; beyond the last one it stands for the others, and weighs nothing.
    #[inline(always)]
    fn own(&self, pack: usize) -> Ids {
        let vertex = |lane: usize| (pack * LANES + lane).min(self.count - 1) as u32;
        [vertex(0), vertex(1), vertex(2), vertex(3)]
    }

    /// The best rotation of every vertex's edges for moved vertices, and Σ_i Σ_j w (‖v'_i − v'_j‖² − 2 v'ᵀR_i v).
    pub(super) fn rotations(&self, moved: &[[f64; D]]) -> (Vec<Square<D>>, f64) {
        dispatch(Rotations { fans: self, moved })
    }

    /// b_i = Σ_j w (R_i + R_j)(v_i − v_j).
    pub(super) fn right_side(&self, rotations: &[Square<D>]) -> Vec<[f64; D]> {
        dispatch(RightSide { fans: self, rotations })
    }

    /// Σ_i Σ_j w ‖(v'_i − v'_j) − R_i (v_i − v_j)‖².
    pub(super) fn energy(&self, rest: &[[f64; D]], rotations: &[Square<D>], moved: &[[f64; D]]) -> f64 {
        let mut sum = 0.0;
        for (vertex, rotation) in rotations.iter().enumerate() {
            let (pack, lane) = (vertex / LANES, vertex % LANES);
            for slot in &self.slots[self.starts[pack]..self.starts[pack + 1]] {
                let other = slot.others[lane] as usize;
                let now = minus(&moved[vertex], &moved[other]);
                let miss = minus(&now, &apply(rotation, &minus(&rest[vertex], &rest[other])));
                sum += slot.weight[lane] * dot(&miss, &miss);
            }
        }
        sum
    }
}

/// Kernel of [`Fans::rotations`].
struct Rotations<'a, const D: usize> {
    fans: &'a Fans<D>,
    moved: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Rotations<'_, D> {
    type Output = (Vec<Square<D>>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Vec<Square<D>>, f64) {
        let Self { fans, moved } = self;
        let zero = simd.splat_f64s(0.0);
        let (mut squares, mut gain) = (zero, 0.0);
        let mut rotations = vec![[[0.0; D]; D]; (fans.starts.len() - 1) * LANES];
        for (pack, rotations) in rotations.chunks_exact_mut(LANES).enumerate() {
            let own = points_of(simd, moved, &fans.own(pack));
            let mut sums = [[zero; D]; D];
            for slot in &fans.slots[fans.starts[pack]..fans.starts[pack + 1]] {
                let (mut now, mut square) = (own, zero);
                for (now, other) in now.iter_mut().zip(points_of(simd, moved, &slot.others)) {
                    *now = simd.sub_f64s(*now, other);
                    square = multiply_add(simd, *now, *now, square);
                }
                for (sums, edge) in sums.iter_mut().zip(&slot.edge) {
                    add_multiple(simd, load::<S>(edge), &now, sums);
                }
                squares = multiply_add(simd, load::<S>(&slot.weight), square, squares);
            }
            gain += rotate(simd, &sums, rotations);
        }
        rotations.truncate(fans.count);
        (rotations, store::<S>(squares).iter().sum::<f64>() - 2.0 * gain)
    }
}

/// Kernel of [`Fans::right_side`].
struct RightSide<'a, const D: usize> {
    fans: &'a Fans<D>,
    rotations: &'a [Square<D>],
}

impl<const D: usize> WithSimd for RightSide<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let Self { fans, rotations } = self;
        let mut values = vec![[0.0; D]; fans.count];
        for (pack, values) in values.chunks_mut(LANES).enumerate() {
            let own = rotations_of(simd, rotations, &fans.own(pack));
            let mut sides = [simd.splat_f64s(0.0); D];
            for slot in &fans.slots[fans.starts[pack]..fans.starts[pack + 1]] {
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
    use super::super::edge_packs::EdgePacks;
    use super::super::edge_sets::SetEdge;
    use super::*;

    /// A strip of vertices, some with many edges, and one without any.
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
        let (fans, packs) = (Fans::new(&rest, &edges), EdgePacks::new(&rest, &members));
        let ((turned, gain), (wanted, wanted_gain)) = (fans.rotations(&moved), packs.rotations(&moved));
        let is_near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        // The last vertex has no edges: it is no set, and does not turn.
        assert!(is_near(turned[..count - 1].as_flattened().as_flattened(), wanted.as_flattened().as_flattened()));
        assert!((gain - wanted_gain).abs() < 1e-12 * wanted_gain.abs().max(1.0), "{gain} {wanted_gain}");
        let sides = [fans.right_side(&turned), packs.right_side(&wanted, count)];
        assert!(is_near(sides[0].as_flattened(), sides[1].as_flattened()));
        let energies = [fans.energy(&rest, &turned, &moved), packs.energy(&wanted, &moved)];
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
