//! Points that follow the lattice: V' = W P' (paper, equation 4), and products with Wᵀ.
//!
//! In: rest points and a grid. Out: moved points, sparse or dense rows of W.

use crate::lattice::Grid;
use crate::solve::packs::{LANES, Packs, add_sums, dispatch, gather_group, load, local_handles, scatter_group, store};
use pulp::{Simd, WithSimd};

/// Packs that are worked on together.
const GROUP: usize = 4;

/// Rest points with their rows of W.
#[derive(Debug)]
pub(crate) struct Vertices<const D: usize> {
    /// Where they rest, #vertices.
    pub(crate) rest: Vec<[f64; D]>,
    weights: Packs<1>,
}

impl<const D: usize> Vertices<D> {
    pub(crate) fn new(grid: &Grid<D>, rest: Vec<[f64; D]>) -> Self {
        let weights = Packs::new(grid, &rest, |weight, _| [weight]);
        Self { rest, weights }
    }

    /// V' = W P', #vertices.
    pub(crate) fn moved(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        dispatch(Moved { vertices: self, handles })
    }

    /// Adds scale · Wᵀ values; values are #vertices.
    pub(crate) fn add_transposed(&self, values: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) {
        dispatch(Transposed { vertices: self, values, scale, right_side });
    }

    /// Handles that act on every vertex, where they are the same ones for all.
    pub(crate) fn shared_handles(&self) -> Option<usize> {
        (self.weights.blocks.len() == 1).then(|| self.weights.blocks[0].handles.len())
    }

    /// How far apart handles of one row are, by index.
    pub(crate) fn reach(&self) -> usize {
        self.weights.reach()
    }

    /// W, row by row, #vertices × #handles.
    pub(crate) fn dense(&self, size: usize) -> Vec<f64> {
        let mut dense = vec![0.0; self.rest.len() * size];
        self.each_weight(|vertex, handle, weight| dense[vertex * size + handle] = weight);
        dense
    }

    /// W, row by row, sparse.
    pub(crate) fn rows(&self) -> Vec<Vec<(usize, f64)>> {
        let mut rows = vec![Vec::new(); self.rest.len()];
        self.each_weight(|vertex, handle, weight| rows[vertex].push((handle, weight)));
        rows
    }

    /// Least and greatest handle that acts on each vertex.
    pub(crate) fn ranges(&self) -> Vec<[usize; 2]> {
        let mut ranges = vec![[usize::MAX, 0]; self.rest.len()];
        self.each_weight(|vertex, handle, _| {
            ranges[vertex] = [ranges[vertex][0].min(handle), ranges[vertex][1].max(handle)];
        });
        ranges
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
}

/// Kernel of [`Vertices::moved`].
struct Moved<'a, const D: usize> {
    vertices: &'a Vertices<D>,
    handles: &'a [[f64; D]],
}

impl<const D: usize> WithSimd for Moved<'_, D> {
    type Output = Vec<[f64; D]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<[f64; D]> {
        let weights = &self.vertices.weights;
        let mut moved = vec![[0.0; D]; self.vertices.rest.len()];
        let mut local = Vec::new();
        for block in &weights.blocks {
            local_handles(block, self.handles, &mut local);
            for first in block.packs.clone().step_by(GROUP) {
                let group: [usize; GROUP] = std::array::from_fn(|n| (first + n).min(block.packs.end - 1));
                let sums = gather_group(simd, group.map(|pack| weights.pack(block, pack)), &local);
                for (&pack, sums) in group.iter().zip(&sums) {
                    let mut values = [[0.0; LANES]; D];
                    values.iter_mut().zip(sums).for_each(|(value, [sum])| *value = store::<S>(*sum));
                    put(weights.order[pack], &values, &mut moved);
                }
            }
        }
        moved
    }
}

/// Puts the coordinates of four rows where they belong.
#[inline(always)]
fn put<const D: usize>(rows: [usize; LANES], values: &[[f64; LANES]; D], moved: &mut [[f64; D]]) {
    for (lane, &row) in rows.iter().enumerate() {
        if let Some(slot) = moved.get_mut(row) {
            *slot = std::array::from_fn(|d| values[d][lane]);
        }
    }
}

/// Kernel of [`Vertices::add_transposed`].
struct Transposed<'a, const D: usize> {
    vertices: &'a Vertices<D>,
    values: &'a [[f64; D]],
    scale: f64,
    right_side: &'a mut [[f64; D]],
}

impl<const D: usize> WithSimd for Transposed<'_, D> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let weights = &self.vertices.weights;
        let mut sums = Vec::new();
        for block in &weights.blocks {
            sums.clear();
            sums.resize(block.handles.len(), [[0.0; LANES]; D]);
            for first in block.packs.clone().step_by(GROUP) {
                let mut values = [[[simd.splat_f64s(0.0)]; D]; GROUP];
                let mut packs = [weights.pack(block, first); GROUP];
                for n in 0..GROUP.min(block.packs.end - first) {
                    let rows = weights.order[first + n].map(|row| self.values.get(row).copied().unwrap_or([0.0; D]));
                    (0..D).for_each(|d| values[n][d] = [load::<S>(&rows.map(|row| row[d]))]);
                    packs[n] = weights.pack(block, first + n);
                }
                scatter_group(simd, packs, &values, &mut sums);
            }
            add_sums(block, &sums, self.scale, self.right_side);
        }
    }
}
