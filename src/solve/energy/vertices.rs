//! Points that follow the lattice: V' = W P' (paper, equation 4), and products with Wᵀ.
//!
//! In: rest points and a grid. Out: moved points, rows of W.

use crate::lattice::Grid;
use crate::solve::packs::{LANES, Packs, add_sums, dispatch, gather_group, load, local_handles, scatter_group, store};
use crate::solve::products::Products;
use pulp::{Simd, WithSimd};

/// Packs that are worked on together.
const GROUP: usize = 4;

/// Rest points with their rows of W.
#[derive(Debug)]
pub(crate) struct Vertices<const D: usize> {
    /// Where they rest, #vertices.
    pub(crate) rest: Vec<[f64; D]>,
    weights: Weights,
}

/// W.
#[derive(Debug)]
enum Weights {
    /// Of a local basis.
    Local(Packs<1>),
    /// Of a basis in which all handles meet.
    Everywhere(Products),
}

impl<const D: usize> Vertices<D> {
    pub(crate) fn new(grid: &Grid<D>, rest: Vec<[f64; D]>) -> Self {
        let weights = match Products::new(grid, &rest) {
            Some(products) => Weights::Everywhere(products),
            None => Weights::Local(Packs::new(grid, &rest, |weight, _| [weight])),
        };
        Self { rest, weights }
    }

    /// V' = W P', #vertices.
    pub(crate) fn moved(&self, handles: &[[f64; D]]) -> Vec<[f64; D]> {
        match &self.weights {
            Weights::Local(weights) => dispatch(Moved { weights, count: self.rest.len(), handles }),
            Weights::Everywhere(products) => products.moved(handles),
        }
    }

    /// Adds scale · Wᵀ values; values are #vertices.
    pub(crate) fn add_transposed(&self, values: &[[f64; D]], scale: f64, right_side: &mut [[f64; D]]) {
        match &self.weights {
            Weights::Local(weights) => dispatch(Transposed { weights, values, scale, right_side }),
            Weights::Everywhere(products) => products.add_transposed(values, scale, right_side),
        }
    }

    /// W of a basis in which all handles meet.
    pub(crate) fn products(&self) -> Option<&Products> {
        match &self.weights {
            Weights::Local(_) => None,
            Weights::Everywhere(products) => Some(products),
        }
    }

    /// How far apart handles of one row are, by index.
    pub(crate) fn reach(&self) -> usize {
        match &self.weights {
            Weights::Local(weights) => weights.reach(),
            Weights::Everywhere(products) => products.handle_count() - 1,
        }
    }

    /// W, row by row, of a local basis.
    pub(crate) fn rows(&self) -> Vec<Vec<(usize, f64)>> {
        let mut rows = vec![Vec::new(); self.rest.len()];
        self.each_weight(|vertex, handle, weight| rows[vertex].push((handle, weight)));
        rows
    }

    /// Least and greatest handle of a local basis that acts on each vertex.
    pub(crate) fn ranges(&self) -> Vec<[usize; 2]> {
        let mut ranges = vec![[usize::MAX, 0]; self.rest.len()];
        self.each_weight(|vertex, handle, _| {
            ranges[vertex] = [ranges[vertex][0].min(handle), ranges[vertex][1].max(handle)];
        });
        ranges
    }

    /// Calls `visit(vertex, handle, weight)` for all entries of W of a local basis.
    fn each_weight(&self, mut visit: impl FnMut(usize, usize, f64)) {
        let Weights::Local(weights) = &self.weights else { return };
        for block in &weights.blocks {
            for pack in block.packs.clone() {
                let rows = weights.order[pack];
                for (coefficients, &handle) in weights.pack(block, pack).iter().zip(&block.handles) {
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
    weights: &'a Packs<1>,
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
    weights: &'a Packs<1>,
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
