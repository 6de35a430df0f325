//! Vertices embedded in the lattice: V' = W P' (paper, equation 4), and products with Wᵀ.
//!
//! In: rest points and a grid. Out: moved points, rows of W, products Wᵀ x.

use crate::lattice::Grid;
use crate::simd::dispatch;
use crate::solve::blocked_weights::{BlockedWeights, add_sums, gather_group, local_handles, scatter_group};
use crate::solve::cancel::Cancel;
use crate::solve::linalg::simd::{LANES, load, store};
use crate::solve::separable_weights::SeparableWeights;
use pulp::{Simd, WithSimd};

/// Number of packets that are processed together.
const GROUP: usize = 4;

/// Rest points with their rows of W.
#[derive(Debug)]
pub(crate) struct EmbeddedVertices<const D: usize> {
    /// Rest positions, #vertices.
    pub(crate) rest: Vec<[f64; D]>,
    weights: Weights,
}

/// The matrix W.
#[derive(Debug)]
enum Weights {
    /// For a basis of local support.
    Local(BlockedWeights<1>),
    /// For a basis of global support.
    Everywhere(SeparableWeights),
}

impl<const D: usize> EmbeddedVertices<D> {
    pub(crate) fn new(grid: &Grid<D>, rest: Vec<[f64; D]>, cancel: &Cancel) -> Self {
        let weights = match SeparableWeights::new(grid, &rest) {
            Some(separable) => Weights::Everywhere(separable),
            None => Weights::Local(BlockedWeights::new(grid, &rest, |weight, _| [weight], cancel)),
        };
        Self { rest, weights }
    }

    /// Returns V' = W P', #vertices.
    pub(crate) fn moved(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        match &self.weights {
            Weights::Local(weights) => dispatch(Moved { weights, count: self.rest.len(), handles }),
            Weights::Everywhere(separable) => separable.moved(handles),
        }
    }

    /// Adds scale · Wᵀ values to the right-hand side; `values` has one entry per vertex.
    pub(crate) fn add_transposed(&self, values: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) {
        match &self.weights {
            Weights::Local(weights) => dispatch(Transposed { weights, values, scale, right_side }),
            Weights::Everywhere(separable) => separable.add_transposed(values, scale, right_side),
        }
    }

    /// W, if the basis has global support.
    pub(crate) fn separable(&self) -> Option<&SeparableWeights> {
        match &self.weights {
            Weights::Local(_) => None,
            Weights::Everywhere(separable) => Some(separable),
        }
    }

    /// Largest difference of handle indices within a row of W.
    pub(crate) fn bandwidth(&self) -> usize {
        match &self.weights {
            Weights::Local(weights) => weights.bandwidth(),
            Weights::Everywhere(separable) => separable.handle_count() - 1,
        }
    }

    /// Rows of W as (handle, weight), for a basis of local support.
    pub(crate) fn rows(&self) -> Vec<Vec<(usize, f64)>> {
        let mut rows = vec![Vec::new(); self.rest.len()];
        self.each_weight(|vertex, handle, weight| rows[vertex].push((handle, weight)));
        rows
    }

    /// Smallest and largest handle index of each row, for a basis of local support.
    pub(crate) fn ranges(&self) -> Vec<[usize; 2]> {
        let mut ranges = vec![[usize::MAX, 0]; self.rest.len()];
        self.each_weight(|vertex, handle, _| {
            ranges[vertex] = [ranges[vertex][0].min(handle), ranges[vertex][1].max(handle)];
        });
        ranges
    }

    /// Calls `visit(vertex, handle, weight)` for every entry of W, for a basis of local support.
    fn each_weight(&self, mut visit: impl FnMut(usize, usize, f64)) {
        let Weights::Local(weights) = &self.weights else { return };
        for block in &weights.blocks {
            for packet in block.packets.clone() {
                let rows = weights.order[packet];
                for (coefficients, &handle) in weights.packet(block, packet).iter().zip(&block.handles) {
                    (0..LANES)
                        .filter(|&lane| rows[lane] != usize::MAX)
                        .for_each(|lane| visit(rows[lane], handle, coefficients[0][lane]));
                }
            }
        }
    }
}

/// Kernel of [`EmbeddedVertices::moved`].
struct Moved<'a, const D: usize> {
    weights: &'a BlockedWeights<1>,
    count: usize,
    handles: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Moved<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let weights = self.weights;
        let mut moved = vec![[0.0; D]; self.count];
        let mut local = Vec::new();
        for block in &weights.blocks {
            local_handles(block, self.handles, &mut local);
            for first in block.packets.clone().step_by(GROUP) {
                let group: [usize; GROUP] = std::array::from_fn(|n| (first + n).min(block.packets.end - 1));
                let sums = gather_group(simd, group.map(|packet| weights.packet(block, packet)), &local);
                for (&packet, sums) in group.iter().zip(&sums) {
                    let mut values = [[0.0; LANES]; D];
                    values.iter_mut().zip(sums).for_each(|(value, [sum])| *value = store::<S>(*sum));
                    put(weights.order[packet], &values, &mut moved);
                }
            }
        }
        moved
    }
}

/// Writes the coordinates of the four rows of a packet to their vertices.
#[inline(always)]
fn put<const D: usize>(rows: [usize; LANES], values: &[[f64; LANES]; D], moved: &mut [[f64; D]]) {
    for (lane, &row) in rows.iter().enumerate() {
        if let Some(slot) = moved.get_mut(row) {
            *slot = std::array::from_fn(|d| values[d][lane]);
        }
    }
}

/// Kernel of [`EmbeddedVertices::add_transposed`].
struct Transposed<'a, const D: usize> {
    weights: &'a BlockedWeights<1>,
    values: &'a [[f64; D]],
    scale: f64,
    right_side: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Transposed<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let weights = self.weights;
        let mut sums = Vec::new();
        for block in &weights.blocks {
            sums.clear();
            sums.resize(block.handles.len(), [[0.0; LANES]; D]);
            for first in block.packets.clone().step_by(GROUP) {
                let mut values = [[[simd.splat_f64s(0.0)]; D]; GROUP];
                let mut packets = [weights.packet(block, first); GROUP];
                for n in 0..GROUP.min(block.packets.end - first) {
                    let rows = weights.order[first + n].map(|row| self.values.get(row).copied().unwrap_or([0.0; D]));
                    (0..D).for_each(|d| values[n][d] = [load::<S>(&rows.map(|row| row[d]))]);
                    packets[n] = weights.packet(block, first + n);
                }
                scatter_group(simd, packets, &values, &mut sums);
            }
            add_sums(block, &sums, self.scale, self.right_side);
        }
    }
}
