//! General edge sets in SIMD packets of two layouts: four sets with their edges, and four edges with the sets that contain them.
//!
//! In: sorted edges of sets; moved vertices. Out: the best rotation of every set, and the right-hand side.

use super::packets::{Ids, add_edge, best_rotations, points_of, rotations_of, slot_starts};
use super::set_edges::SetEdge;
use crate::simd::dispatch;
use crate::solve::linalg::simd::{LANES, Lanes, add_multiple, load, multiply_add, store};
use crate::solve::linalg::small_matrix::{SquareMatrix, apply, dot, minus};
use pulp::{Simd, WithSimd};

/// One edge of each of four sets; the weight is 0 in unused lanes.
#[derive(Clone, Debug)]
struct SetSlot<const D: usize> {
    /// Vertices i and j.
    ends: [Ids; 2],
    /// w (v_i − v_j).
    edge: [Lanes; D],
    /// w.
    weight: Lanes,
}

/// Four edges, with the slots that list their sets.
#[derive(Clone, Debug)]
struct EdgePacket<const D: usize> {
    /// Vertices i and j.
    ends: [Ids; 2],
    /// v_i − v_j; 0 in unused lanes.
    edge: [Lanes; D],
    /// Range of the slots in `edge_slots`.
    sets: std::ops::Range<usize>,
}

/// One set that contains each of four edges, with the weight of the edge in it.
#[derive(Clone, Debug)]
struct EdgeSlot {
    sets: Ids,
    weight: Lanes,
}

/// Edges of all sets, and sets of all edges.
#[derive(Debug)]
pub(super) struct EdgeSetPackets<const D: usize> {
    set_count: usize,
    /// First slot of every group of four sets, and the end of the last group.
    starts: Vec<usize>,
    set_slots: Vec<SetSlot<D>>,
    edges: Vec<EdgePacket<D>>,
    edge_slots: Vec<EdgeSlot>,
}

impl<const D: usize> EdgeSetPackets<D> {
    /// Packs edges that are sorted by their ends; each pair of edge and set occurs once.
    pub(super) fn new(rest: &[[f64; D]], members: &[SetEdge]) -> Self {
        let set_count = members.iter().map(|member| member.set as usize + 1).max().unwrap_or(0);
        let mut packets =
            Self { set_count, starts: Vec::new(), set_slots: Vec::new(), edges: Vec::new(), edge_slots: Vec::new() };
        packets.add_sets(rest, members);
        packets.add_edges(rest, members);
        packets
    }

    fn add_sets(&mut self, rest: &[[f64; D]], members: &[SetEdge]) {
        let packet_count = self.set_count.div_ceil(LANES);
        let mut sizes = vec![0; packet_count * LANES];
        members.iter().for_each(|member| sizes[member.set as usize] += 1);
        self.starts = slot_starts(&sizes);
        let count = self.starts[packet_count];
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
                self.edges.push(EdgePacket { ends: [[0; LANES]; 2], edge: [[0.0; LANES]; D], sets: count..count });
            }
            let Some(packet) = self.edges.last_mut() else { return };
            let [i, j] = same[0].ends;
            let edge = minus(&rest[i as usize], &rest[j as usize]);
            (packet.ends[0][lane], packet.ends[1][lane]) = (i, j);
            (0..D).for_each(|d| packet.edge[d][lane] = edge[d]);
            packet.sets.end = packet.sets.end.max(packet.sets.start + same.len());
            self.edge_slots.resize(packet.sets.end, EdgeSlot { sets: [0; LANES], weight: [0.0; LANES] });
            for (slot, member) in self.edge_slots[packet.sets.start..].iter_mut().zip(same) {
                (slot.sets[lane], slot.weight[lane]) = (member.set, member.weight);
            }
        }
    }

    /// Returns the best rotation of every set for moved vertices, and Σ_s Σ w (‖v'_i − v'_j‖² − 2 (v'_i − v'_j)ᵀ R_s (v_i − v_j)).
    pub(super) fn rotations(&self, moved: &[[f64; D]]) -> (Vec<SquareMatrix<D>>, f64) {
        dispatch(Rotations { packets: self, moved })
    }

    /// Returns b_i = Σ_s Σ_{(i,j)∈s} w R_s (v_i − v_j) for each of `count` vertices.
    pub(super) fn right_side(&self, rotations: &[SquareMatrix<D>], count: usize) -> Vec<[f64; D]> {
        dispatch(RightSide { packets: self, rotations, count })
    }

    /// Energy Σ_s Σ w ‖(v'_i − v'_j) − R_s (v_i − v_j)‖².
    pub(super) fn energy(&self, rotations: &[SquareMatrix<D>], moved: &[[f64; D]]) -> f64 {
        let mut sum = 0.0;
        for packet in &self.edges {
            for lane in 0..LANES {
                let now = minus(&moved[packet.ends[0][lane] as usize], &moved[packet.ends[1][lane] as usize]);
                let edge: [f64; D] = std::array::from_fn(|d| packet.edge[d][lane]);
                for slot in &self.edge_slots[packet.sets.clone()] {
                    let miss = minus(&now, &apply(&rotations[slot.sets[lane] as usize], &edge));
                    sum += slot.weight[lane] * dot(&miss, &miss);
                }
            }
        }
        sum
    }
}

/// Kernel of [`EdgeSetPackets::rotations`].
struct Rotations<'a, const D: usize> {
    packets: &'a EdgeSetPackets<D>,
    moved: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Rotations<'_, D> {
    type Output = (Vec<SquareMatrix<D>>, f64);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Vec<SquareMatrix<D>>, f64) {
        let Self { packets, moved } = self;
        let zero = simd.splat_f64s(0.0);
        let (mut squares, mut gain) = (zero, 0.0);
        let mut rotations = vec![[[0.0; D]; D]; (packets.starts.len() - 1) * LANES];
        for (range, rotations) in packets.starts.windows(2).zip(rotations.chunks_exact_mut(LANES)) {
            let mut sums = [[zero; D]; D];
            for slot in &packets.set_slots[range[0]..range[1]] {
                let ends = [points_of(simd, moved, &slot.ends[1]), points_of(simd, moved, &slot.ends[0])];
                let square = add_edge(simd, &slot.edge, ends, &mut sums);
                squares = multiply_add(simd, load::<S>(&slot.weight), square, squares);
            }
            gain += best_rotations(simd, &sums, rotations);
        }
        rotations.truncate(packets.set_count);
        (rotations, store::<S>(squares).iter().sum::<f64>() - 2.0 * gain)
    }
}

/// Kernel of [`EdgeSetPackets::right_side`].
struct RightSide<'a, const D: usize> {
    packets: &'a EdgeSetPackets<D>,
    rotations: &'a [SquareMatrix<D>],
    count: usize,
}

impl<const D: usize> WithSimd for RightSide<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let Self { packets, rotations, count } = self;
        let mut values = vec![[0.0; D]; count];
        for packet in &packets.edges {
            let mut sums = [[simd.splat_f64s(0.0); D]; D];
            for slot in &packets.edge_slots[packet.sets.clone()] {
                let weight = load::<S>(&slot.weight);
                for (sums, rows) in sums.iter_mut().zip(&rotations_of(simd, rotations, &slot.sets)) {
                    add_multiple(simd, weight, rows, sums);
                }
            }
            let mut turned = [[0.0; LANES]; D];
            for (turned, sums) in turned.iter_mut().zip(&sums) {
                let mut image = simd.splat_f64s(0.0);
                for (sum, edge) in sums.iter().zip(&packet.edge) {
                    image = multiply_add(simd, *sum, load::<S>(edge), image);
                }
                *turned = store::<S>(image);
            }
            let [from, to] = &packet.ends;
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
