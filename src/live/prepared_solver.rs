//! A layer's prefactored solver, with its weight in the cache.

use super::warp::Warning;
use crate::pipeline::LayerSolver;

/// Bytes of a solver per pair of handles that share a sample: 2 MB for 10 x 10 handles of B-splines, measured.
const PAIR_BYTES: usize = 1250;

/// A solver and the warnings of its preparation.
#[derive(Debug)]
pub(super) struct PreparedSolver {
    /// `None`: nothing of the layer is visible.
    pub(super) solver: Option<LayerSolver>,
    pub(super) warnings: Vec<Warning>,
}

impl PreparedSolver {
    /// Estimates its size in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Some(solver) = &self.solver else { return 1 };
        let grid = solver.grid();
        let handles = grid.handle_count();
        // Handles that influence a sample.
        let shared = grid.basis.handles_at_point(grid.dims);
        handles * shared * PAIR_BYTES
    }
}
