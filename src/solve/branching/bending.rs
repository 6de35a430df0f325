//! Measures of how strongly a branching lattice bends.
//!
//! In: a [`Branching`], the lattices of its branches. Out: for each branch an estimate of its second derivative where it contains the
//! shape, and its strain at the border of the box.

use super::{Branching, handles_of_cell};
use crate::lattice::{Grid, Lattice};
use crate::solve::linalg::small_matrix::squared_distance;
use rayon::prelude::*;
use std::ops::Range;

/// Number of table cells along a span of the grid, and of blocks along each side of the bounds of a piece.
const CELLS_PER_SPAN: usize = 2;

const IDENTITY: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// Extent of a piece, in spans, below which it does not bend.
const MIN_EXTENT: f64 = 1e-4;

/// How strongly a branch bends.
#[derive(Clone, Debug)]
pub(crate) struct Bending {
    /// An estimate of the greatest norm of the second derivative in each cell of a table over the box, x fastest; 0 where the branch
    /// has no part of the shape.
    pub(crate) cells: Vec<f64>,
    /// Number of cells of the table along each axis.
    pub(crate) counts: [usize; 2],
    /// The greatest Frobenius norm of gradient minus identity at the centres of the branch's cells along the border of the box.
    pub(crate) strain_at_border: f64,
}

/// How strongly each branch bends. `lattice` returns the lattice of a branch.
pub(super) fn bending(branching: &Branching<2>, lattice: impl Fn(usize) -> Lattice<2> + Sync) -> Vec<Bending> {
    let bounds = bounds_of_pieces(branching);
    let branches = (0..branching.branches.len()).into_par_iter();
    branches.map(|branch| bending_of(branching, (branch, &lattice(branch)), &bounds)).collect()
}

/// The bounds of each piece, low and high corner, along the axes of the upright box, in spans.
fn bounds_of_pieces(branching: &Branching<2>) -> Vec<[[f64; 2]; 2]> {
    let grid = &branching.grid;
    let mut bounds = vec![[[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]]; branching.pieces.list.len()];
    for (cut, &piece) in branching.cuts.iter().zip(&branching.pieces.of_cuts) {
        let cell = grid.cell_coords(cut.cell);
        for corner in cut.polygon.corners() {
            let upright = grid.upright_from_point(*corner);
            for axis in 0..2 {
                let spans = (upright[axis] - grid.lo[axis]) / grid.spacing(axis);
                // Parts outside the box belong to the nearest cell.
                let spans = spans.clamp(cell[axis] as f64, (cell[axis] + 1) as f64);
                let [low, high] = &mut bounds[piece];
                (low[axis], high[axis]) = (low[axis].min(spans), high[axis].max(spans));
            }
        }
    }
    bounds
}

fn bending_of(branching: &Branching<2>, (branch, lattice): (usize, &Lattice<2>), bounds: &[[[f64; 2]; 2]]) -> Bending {
    let grid = &branching.grid;
    let is_smooth = branching.width > 2;
    let spans = [0, 1].map(|axis| grid.basis.spans(grid.dims[axis]));
    let counts = spans.map(|spans| spans * CELLS_PER_SPAN);
    let mut bending = Bending { cells: vec![0.0; counts[0] * counts[1]], counts, strain_at_border: 0.0 };
    let own = branching.pieces.list.iter().zip(bounds).zip(&branching.branch_of);
    for ((piece, bounds), _) in own.filter(|(_, of)| **of == branch) {
        let place = grid.cell_coords(piece.cell);
        if is_smooth {
            let within = |axis: usize, block: usize| block_cells(bounds, place, (axis, block));
            for (block, bent) in second_derivatives(lattice, bounds).into_iter().enumerate() {
                let [i, j] = [block % CELLS_PER_SPAN, block / CELLS_PER_SPAN];
                bending.raise([within(0, i), within(1, j)], bent);
            }
        } else {
            let acts = |handle: usize| branching.branches[branch][handle].is_some();
            let bent = kink(lattice, &handles_of_cell(grid, branching.width, piece.cell), acts);
            bending.raise(place.map(|place| place * CELLS_PER_SPAN..(place + 1) * CELLS_PER_SPAN), bent);
        }
        if (0..2).any(|axis| place[axis] == 0 || place[axis] + 1 == spans[axis]) {
            let gradient = gradient(lattice, place.map(|place| place as f64 + 0.5));
            let strain = squared_distance(&gradient, &IDENTITY).sqrt();
            bending.strain_at_border = bending.strain_at_border.max(strain);
        }
    }
    bending
}

impl Bending {
    /// Raises the cells in these columns and rows to at least a value.
    fn raise(&mut self, [columns, rows]: [Range<usize>; 2], least: f64) {
        for row in rows {
            let cells = &mut self.cells[row * self.counts[0]..][columns.clone()];
            cells.iter_mut().for_each(|cell| *cell = cell.max(least));
        }
    }
}

/// The table cells, along an axis, that overlap a block of the bounds of a piece and lie in its cell of the grid.
fn block_cells([low, high]: &[[f64; 2]; 2], place: [usize; 2], (axis, block): (usize, usize)) -> Range<usize> {
    let ends = [block, block + 1].map(|end| {
        let spans = low[axis] + (high[axis] - low[axis]) * end as f64 / CELLS_PER_SPAN as f64;
        (spans - place[axis] as f64) * CELLS_PER_SPAN as f64
    });
    let first = (ends[0] as usize).min(CELLS_PER_SPAN - 1);
    let end = (ends[1].ceil() as usize).clamp(first + 1, CELLS_PER_SPAN);
    let origin = place[axis] * CELLS_PER_SPAN;
    origin + first..origin + end
}

/// The largest second difference, over the squared spacing, that begins at one of these handles: a bilinear lattice has kinks at the
/// borders of its cells. Differences between handles that do not all act on the branch do not count.
fn kink(lattice: &Lattice<2>, handles: &[usize], acts: impl Fn(usize) -> bool) -> f64 {
    let grid = &lattice.grid;
    let mut greatest = 0.0_f64;
    for &start in handles {
        for [a, b] in [[0, 0], [0, 1], [1, 1]] {
            let Some(corners) = corners(grid, start, [a, b]).filter(|corners| corners.iter().all(|&at| acts(at)))
            else {
                continue;
            };
            let [p, q, r, s] = corners.map(|handle| lattice.handles[handle]);
            let length = (p[0] - q[0] - r[0] + s[0]).hypot(p[1] - q[1] - r[1] + s[1]);
            // A mixed difference occurs twice in the Frobenius norm.
            let count = if a == b { 1.0 } else { std::f64::consts::SQRT_2 };
            greatest = greatest.max(count * length / (grid.spacing(a) * grid.spacing(b)));
        }
    }
    greatest
}

/// The greatest change of the gradient along the sides of each block of a piece's bounds, over its length; blocks in rows.
fn second_derivatives(lattice: &Lattice<2>, [low, high]: &[[f64; 2]; 2]) -> [f64; CELLS_PER_SPAN * CELLS_PER_SPAN] {
    const SIDE: usize = CELLS_PER_SPAN + 1;
    let steps = [0, 1].map(|axis| (high[axis] - low[axis]) / CELLS_PER_SPAN as f64);
    let place = |k: usize| [low[0] + (k % SIDE) as f64 * steps[0], low[1] + (k / SIDE) as f64 * steps[1]];
    let gradients: [[[f64; 2]; 2]; SIDE * SIDE] = std::array::from_fn(|k| gradient(lattice, place(k)));
    let change = |from: usize, axis: usize| {
        let to = from + [1, SIDE][axis];
        if steps[axis] <= MIN_EXTENT {
            return 0.0;
        }
        squared_distance(&gradients[from], &gradients[to]).sqrt() / (steps[axis] * lattice.grid.spacing(axis))
    };
    std::array::from_fn(|block| {
        let corner = block % CELLS_PER_SPAN + SIDE * (block / CELLS_PER_SPAN);
        let across = change(corner, 0).max(change(corner + SIDE, 0));
        across.max(change(corner, 1)).max(change(corner + 1, 1))
    })
}

/// The gradient of a lattice at a place in spans.
fn gradient(lattice: &Lattice<2>, spans: [f64; 2]) -> [[f64; 2]; 2] {
    lattice.evaluate_with_gradient(lattice.grid.point_from_spans(spans)).gradient
}

/// The four handles of a second difference that begins at a handle, with signs +, -, -, +; `None` if it would extend beyond the
/// grid.
fn corners(grid: &Grid<2>, start: usize, [a, b]: [usize; 2]) -> Option<[usize; 4]> {
    let place = grid.handle_coords(start);
    let steps = |axis: usize| usize::from(axis == a) + usize::from(axis == b);
    if (0..2).any(|axis| place[axis] + steps(axis) >= grid.dims[axis]) {
        return None;
    }
    let [along_a, along_b] = [a, b].map(|axis| grid.stride(axis));
    Some([start, start + along_a, start + along_b, start + along_a + along_b])
}
