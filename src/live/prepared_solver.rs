//! A layer's factored solver, and what it weighs in a cache.

use super::warp::Warning;
use crate::pipeline::LayerSolver;

/// What a solver holds for a handle and each of those that it shares a sample with: 2 MB at 10 x 10 handles of B-splines,
/// measured.
const PAIR_BYTES: usize = 1250;

/// A solver, and what it told while it was made.
#[derive(Debug)]
pub(super) struct PreparedSolver {
    /// `None`: nothing of the layer is in reach.
    pub(super) solver: Option<LayerSolver>,
    pub(super) warnings: Vec<Warning>,
}

impl PreparedSolver {
    /// What it weighs, about.
    pub(super) fn bytes(&self) -> usize {
        let Some(solver) = &self.solver else { return 1 };
        let grid = solver.grid();
        let handles = grid.handle_count();
        // Handles that a sample hangs on.
        let shared = grid.basis.handles_at_point(grid.dims);
        handles * shared * PAIR_BYTES
    }
}
