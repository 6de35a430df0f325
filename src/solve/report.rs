//! The result of a solve: the lattice and a report.

use super::branching::BranchedLattice;
use super::pin_residuals::PinResidual;
use crate::lattice::Lattice;
use serde::Serialize;

/// What is known of the energy around a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stationarity {
    /// It rises in every direction: the second derivative is positive definite.
    Minimum,
    /// It falls along some direction, and following it led nowhere.
    Saddle,
    /// The solve converged, and nobody looked: moves of a drag, frames of a trajectory, energies without a second derivative.
    #[default]
    Unchecked,
    /// The solve did not converge.
    Unconverged,
}

/// The quality of a solution.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolveReport {
    /// Distance of each pin from its target, in units of the space (screen: frame heights), as many as pins.
    pub pin_errors: Vec<f64>,
    /// The pins that are off their targets, and why.
    pub pin_residuals: Vec<PinResidual>,
    /// Folded cells, in 2D or 3D.
    pub folded_cells: usize,
    /// Folded active cells, which contain some of the model; folds in the others are invisible.
    pub folded_model_cells: usize,
    /// Smallest determinant of the gradient over the active cells: a lower bound, within 1e-3. Above 0
    /// nothing folds, which is proven for all bases except Bernstein, whose cells are sampled.
    pub min_cell_det: f64,
    /// Smallest determinant of the gradient over the samples.
    pub min_det: f64,
    /// Angular distortion: mean over area of s1/s2 + s2/s1 − 2.
    pub angular: f64,
    /// Area distortion: mean over area of s1·s2 + 1/(s1·s2) − 2.
    pub area: f64,
    /// Pins or moved handles gave way where the lattice would fold ([`super::Guard::Limit`]).
    pub is_held_back: bool,
    /// Distance of each moved handle from its target, in units of the space.
    pub handle_errors: Vec<f64>,
    /// Linear solves: local-global and Newton steps, including rejected ones and those along a path, not those from starts
    /// that led elsewhere.
    pub iterations: usize,
    /// The last step was below the tolerance.
    pub is_converged: bool,
    /// Minimum, saddle, or neither is known.
    pub stationarity: Stationarity,
    /// The energy that was minimised, without the barrier; `None` for frames of trajectories and plain iterations.
    pub energy: Option<f64>,
    /// Pairs of pins, by index, at the same point with different targets: the solution is a compromise (least
    /// squares).
    pub conflicts: Vec<[usize; 2]>,
    /// Warnings for the user (contradicting handles, no pins, an empty shape...).
    pub warnings: Vec<String>,
}

/// A solved lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<const D: usize> {
    /// The lattice; of a branching one the largest branch.
    pub lattice: Lattice<D>,
    /// All branches, where parts of the shape have copies of handles of their own.
    pub branches: Option<BranchedLattice<D>>,
    /// How good it is.
    pub report: SolveReport,
}
