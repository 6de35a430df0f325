//! Regularisers: what holds handles that neither pins nor the shape hold.
//!
//! In: the grid and the handles that are moved by hand. Out: least-squares rows.

use super::rows::RowSet;
use super::{Regularizer, Scaling};
use crate::lattice::Grid;

/// The rows of a regulariser, with λgr = 1. `moved` marks handles that are moved by hand.
pub(crate) fn rows<const D: usize>(kind: Regularizer, grid: &Grid<D>, moved: &[bool], scaling: Scaling) -> RowSet<D> {
    match kind {
        Regularizer::Rest => rest(grid, moved, scaling),
        Regularizer::Bend => bend(grid, scaling),
    }
}

/// Σ ‖P'_i − P⁰_i‖² over handles not moved by hand (paper, equation 8); dimensionless: the mean, in box diagonals.
fn rest<const D: usize>(grid: &Grid<D>, moved: &[bool], scaling: Scaling) -> RowSet<D> {
    let free = moved.iter().filter(|&&is_moved| !is_moved).count();
    let weight = match scaling {
        Scaling::Plain => 1.0,
        Scaling::Dimensionless => 1.0 / (free.max(1) as f64 * grid.diagonal().powi(2)),
    };
    let mut rows = RowSet::new();
    for index in (0..moved.len()).filter(|&index| !moved[index]) {
        rows.push(weight, [(index, 1.0)], grid.rest_handle(index));
    }
    rows
}

/// Σ |Δaa|² + 2 Σ |Δab|²: second differences along axes, mixed ones for every pair of axes.
///
/// Dimensionless: s²·(mean |Δaa|²/ha⁴ + 2 mean |Δab|²/(ha²hb²)), s the box diagonal, ha the handle distance,
/// which tends to s² times the mean squared second derivative whatever the dims.
fn bend<const D: usize>(grid: &Grid<D>, scaling: Scaling) -> RowSet<D> {
    let mut rows = RowSet::new();
    for a in 0..D {
        for b in a..D {
            let stencil = stencil(grid, a, b);
            let reach: [usize; D] = std::array::from_fn(|axis| usize::from(axis == a) + usize::from(axis == b));
            let starts: Vec<usize> = (0..grid.handle_count())
                .filter(|&index| (0..D).all(|axis| grid.place(index)[axis] + reach[axis] < grid.dims[axis]))
                .collect();
            let share = if a == b { 1.0 } else { 2.0 };
            let weight = match scaling {
                Scaling::Plain => share,
                Scaling::Dimensionless => {
                    let cell = grid.pitch(a) * grid.pitch(b);
                    share * (grid.diagonal() / cell).powi(2) / starts.len().max(1) as f64
                }
            };
            for start in starts {
                rows.push(weight, stencil.iter().map(|&(step, c)| (start + step, c)), [0.0; D]);
            }
        }
    }
    rows
}

/// Index steps and coefficients of one second difference.
fn stencil<const D: usize>(grid: &Grid<D>, a: usize, b: usize) -> Vec<(usize, f64)> {
    let (along, across) = (grid.stride(a), grid.stride(b));
    if a == b {
        vec![(0, 1.0), (along, -2.0), (2 * along, 1.0)]
    } else {
        vec![(0, 1.0), (along, -1.0), (across, -1.0), (along + across, 1.0)]
    }
}
