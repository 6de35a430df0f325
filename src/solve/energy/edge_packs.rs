//! Edges of any sets, and sets of edges, four together so that loops run in vector registers.
//!
//! In: edges of sets, sorted; moved vertices. Out: the best rotation of every set, and the right side of the edges.

use super::edge_sets::SetEdge;
use super::quads::{Ids, points_of, rotate, rotations_of};
use crate::solve::packs::{LANES, Lanes, add_multiple, dispatch, load, multiply_add, store};
use crate::solve::small::{Square, apply, dot, minus};
use pulp::{Simd, WithSimd};

/// An edge of each of four sets; lanes without one weigh nothing.
#[derive(Clone, Debug)]
struct SetSlot<const D: usize> {
    /// Vertices i and j.
    ends: [Ids; 2],
    /// w (v_i − v_j).
    edge: [Lanes; D],
    /// w.
    weight: Lanes,
}

/// Four edges with their sets.
#[derive(Clone, Debug)]
struct EdgePack<const D: usize> {
    /// Vertices i and j.
    ends: [Ids; 2],
    /// v_i − v_j; zero in lanes without an edge.
    edge: [Lanes; D],
    sets: std::ops::Range<usize>,
}

/// A set of each of four edges.
#[derive(Clone, Debug)]
struct EdgeSlot {
    sets: Ids,
    weight: Lanes,
}

/// Who belongs to whom.
#[derive(Debug)]
pub(super) struct EdgePacks<const D: usize> {
    set_count: usize,
    /// Where the slots of every four sets start, and where the last ones end.
    starts: Vec<usize>,
    set_slots: Vec<SetSlot<D>>,
    edges: Vec<EdgePack<D>>,
    edge_slots: Vec<EdgeSlot>,
}

impl<const D: usize> EdgePacks<D> {
    /// Packs edges that are sorted by their ends, each set of an edge once.
    pub(super) fn new(rest: &[[f64; D]], members: &[SetEdge]) -> Self {
        let set_count = members.iter().map(|member| member.set as usize + 1).max().unwrap_or(0);
        let mut packs =
            Self { set_count, starts: Vec::new(), set_slots: Vec::new(), edges: Vec::new(), edge_slots: Vec::new() };
        packs.add_sets(rest, members);
        packs.add_edges(rest, members);
        packs
    }

    fn add_sets(&mut self, rest: &[[f64; D]], members: &[SetEdge]) {
        let pack_count = self.set_count.div_ceil(LANES);
        let mut sizes = vec![0; pack_count * LANES];
        members.iter().for_each(|member| sizes[member.set as usize] += 1);
        let mut count = 0;
        self.starts.reserve_exact(pack_count + 1);
        self.starts.push(0);
        for sizes in sizes.chunks_exact(LANES) {
            count += sizes.iter().copied().max().unwrap_or(0);
            self.starts.push(count);
        }
        self.set_slots = vec![SetSlot { ends: [[0; LANES]; 2], edge: [[0.0; LANES]; D], weight: [0.0; LANES] }; count];
        for member in members.iter().rev() {
            let (set, [i, j]) = (member.set as usize, member.ends);
            sizes[set] -= 1;
            let slot = &mut self.set_slots[self.starts[set / LANES] + sizes[set]];
            let (lane, edge) = (set % LANES, minus(&rest[i as usize], &rest[j as usize]));
            (slot.ends[0][lane], slot.ends[1][lane], slot.weight[lane]) = (i, j, member.weight);
            (0..D).for_each(|d| slot.edge[d][lane] = member.weight * edge[d]);
        }
    }

    fn add_edges(&mut self, rest: &[[f64; D]], members: &[SetEdge]) {
        self.edges.reserve(members.len() / (2 * LANES) + 1);
        self.edge_slots.reserve(members.len() / LANES + 1);
        for (number, same) in members.chunk_by(|a, b| a.ends == b.ends).enumerate() {
            let lane = number % LANES;
            let count = self.edge_slots.len();
            if lane == 0 {
                self.edges.push(EdgePack { ends: [[0; LANES]; 2], edge: [[0.0; LANES]; D], sets: count..count });
            }
            let Some(pack) = self.edges.last_mut() else { return };
            let [i, j] = same[0].ends;
            let edge = minus(&rest[i as usize], &rest[j as usize]);
            (pack.ends[0][lane], pack.ends[1][lane]) = (i, j);
            (0..D).for_each(|d| pack.edge[d][lane] = edge[d]);
            pack.sets.end = pack.sets.end.max(pack.sets.start + same.len());
            self.edge_slots.resize(pack.sets.end, EdgeSlot { sets: [0; LANES], weight: [0.0; LANES] });
            for (slot, member) in self.edge_slots[pack.sets.start..].iter_mut().zip(same) {
                (slot.sets[lane], slot.weight[lane]) = (member.set, member.weight);
            }
        }
    }

    /// The best rotation of every set for moved vertices, and Σ_s Σ w (‖v'_i − v'_j‖² − 2 v'ᵀR_s v).
    pub(super) fn rotations(&self, moved: &[[f64; D]]) -> (Vec<Square<D>>, f64) {
        dispatch(Rotations { packs: self, moved })
    }

    /// b_i = Σ_s Σ_{(i,j)∈s} w R_s (v_i − v_j), for each of `count` vertices.
    pub(super) fn right_side(&self, rotations: &[Square<D>], count: usize) -> Vec<[f64; D]> {
        dispatch(RightSide { packs: self, rotations, count })
    }

    /// Σ_s Σ w ‖(v'_i − v'_j) − R_s (v_i − v_j)‖².
    pub(super) fn energy(&self, rotations: &[Square<D>], moved: &[[f64; D]]) -> f64 {
        let mut sum = 0.0;
        for pack in &self.edges {
            for lane in 0..LANES {
                let now = minus(&moved[pack.ends[0][lane] as usize], &moved[pack.ends[1][lane] as usize]);
                let edge: [f64; D] = std::array::from_fn(|d| pack.edge[d][lane]);
                for slot in &self.edge_slots[pack.sets.clone()] {
                    let miss = minus(&now, &apply(&rotations[slot.sets[lane] as usize], &edge));
                    sum += slot.weight[lane] * dot(&miss, &miss);
                }
            }
        }
        sum
    }
}

/// Kernel of [`EdgePacks::rotations`].
struct Rotations<'a, const D: usize> {
    packs: &'a EdgePacks<D>,
    moved: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Rotations<'_, D> {
    type Output = (Vec<Square<D>>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Vec<Square<D>>, f64) {
        let Self { packs, moved } = self;
        let zero = simd.splat_f64s(0.0);
        let (mut squares, mut gain) = (zero, 0.0);
        let mut rotations = vec![[[0.0; D]; D]; (packs.starts.len() - 1) * LANES];
        for (range, rotations) in packs.starts.windows(2).zip(rotations.chunks_exact_mut(LANES)) {
            let mut sums = [[zero; D]; D];
            for slot in &packs.set_slots[range[0]..range[1]] {
                let (from, to) = (points_of(simd, moved, &slot.ends[1]), points_of(simd, moved, &slot.ends[0]));
                let (mut now, mut square) = (to, zero);
                for (now, from) in now.iter_mut().zip(from) {
                    *now = simd.sub_f64s(*now, from);
                    square = multiply_add(simd, *now, *now, square);
                }
                for (sums, edge) in sums.iter_mut().zip(&slot.edge) {
                    add_multiple(simd, load::<S>(edge), &now, sums);
                }
                squares = multiply_add(simd, load::<S>(&slot.weight), square, squares);
            }
            gain += rotate(simd, &sums, rotations);
        }
        rotations.truncate(packs.set_count);
        (rotations, store::<S>(squares).iter().sum::<f64>() - 2.0 * gain)
    }
}

/// Kernel of [`EdgePacks::right_side`].
struct RightSide<'a, const D: usize> {
    packs: &'a EdgePacks<D>,
    rotations: &'a [Square<D>],
    count: usize,
}

impl<const D: usize> WithSimd for RightSide<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let Self { packs, rotations, count } = self;
        let mut values = vec![[0.0; D]; count];
        for pack in &packs.edges {
            let mut sums = [[simd.splat_f64s(0.0); D]; D];
            for slot in &packs.edge_slots[pack.sets.clone()] {
                let weight = load::<S>(&slot.weight);
                for (sums, rows) in sums.iter_mut().zip(&rotations_of(simd, rotations, &slot.sets)) {
                    add_multiple(simd, weight, rows, sums);
                }
            }
            let mut turned = [[0.0; LANES]; D];
            for (turned, sums) in turned.iter_mut().zip(&sums) {
                let mut image = simd.splat_f64s(0.0);
                for (sum, edge) in sums.iter().zip(&pack.edge) {
                    image = multiply_add(simd, *sum, load::<S>(edge), image);
                }
                *turned = store::<S>(image);
            }
            let [from, to] = &pack.ends;
            for (lane, (&i, &j)) in from.iter().zip(to).enumerate() {
                for (d, turned) in turned.iter().enumerate() {
                    values[i as usize][d] += turned[lane];
                    values[j as usize][d] -= turned[lane];
                }
            }
        }
        values
    }
}
