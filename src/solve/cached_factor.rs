//! A factored second derivative that is kept from step to step and from move to move.
//!
//! In: a factor. Out: the same for reuse, the memory of the factor that was dropped last, the forces that pins had with it, and the
//! state at which the true second derivative was positive definite.

use super::linalg::factorization::Factorization;

/// A factored second derivative for reuse, and the memory of the factor that was dropped last.
#[derive(Debug, Default)]
pub(crate) struct CachedFactor {
    factor: Option<Factorization>,
    buffer: Vec<f64>,
    /// Forces of the pins at the last minimum with the barrier, coordinate by coordinate; empty after other minima.
    forces: Vec<f64>,
    /// The last state of the present minimisation at which the true second derivative was positive definite, flat; empty if there is none.
    convex_at: Vec<f64>,
}

impl CachedFactor {
    /// Whether there is a factor.
    pub(crate) fn is_some(&self) -> bool {
        self.factor.is_some()
    }

    /// The factor, if there is one.
    pub(crate) fn factor(&self) -> Option<&Factorization> {
        self.factor.as_ref()
    }

    /// Keeps a factor.
    pub(crate) fn set_factor(&mut self, factor: Option<Factorization>) {
        self.factor = factor;
    }

    /// Drops the factor, but keeps its memory.
    pub(crate) fn discard_factor(&mut self) {
        if let Some(factor) = self.factor.take() {
            self.buffer = factor.into_buffer();
        }
    }

    /// The memory of the factor that was dropped last.
    pub(crate) fn take_buffer(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.buffer)
    }

    /// Forces of the pins that were kept, which are left empty.
    pub(crate) fn take_forces(&mut self) -> Vec<f64> {
        std::mem::take(&mut self.forces)
    }

    /// Keeps the forces of the pins.
    pub(crate) fn set_forces(&mut self, forces: Vec<f64>) {
        self.forces = forces;
    }

    /// The last state of the last move at which the true second derivative was positive definite.
    pub(crate) fn convex_state<const D: usize>(&self) -> Option<&[[f64; D]]> {
        Some(self.convex_at.as_chunks::<D>().0).filter(|state| !state.is_empty())
    }

    /// Keeps a state at which the true second derivative is positive definite.
    pub(crate) fn set_convex_state<const D: usize>(&mut self, state: &[[f64; D]]) {
        self.convex_at = state.as_flattened().to_vec();
    }

    /// Forgets the state kept for the last move.
    pub(crate) fn clear_convex_state(&mut self) {
        self.convex_at.clear();
    }
}
