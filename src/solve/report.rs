//! The result of a solve: the lattice and a report.

use super::branching::BranchedLattice;
use super::pin_residuals::PinResidual;
use crate::lattice::Lattice;
use serde::Serialize;

/// Knowledge of the energy around a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stationarity {
    /// The energy rises in every direction: the second derivative is positive definite.
    Minimum,
    /// The energy falls along some direction, but following that direction led to no other solution.
    Saddle,
    /// The solve converged and was not checked: moves of a drag, frames of a trajectory, energies without a second derivative.
    #[default]
    Unchecked,
    /// The solve did not converge.
    Unconverged,
}

/// The quality of a solution.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolveReport {
    /// Distance of each pin from its target, in units of the space (screen: frame heights), #pins.
    pub pin_errors: Vec<f64>,
    /// Pins that miss their targets, with the reasons.
    pub pin_residuals: Vec<PinResidual>,
    /// Number of folded cells, in 2D or 3D.
    pub folded_cells: usize,
    /// Number of cells that fold on the model; folds in what is empty are invisible.
    pub folded_model_cells: usize,
    /// Lower bound, within 1e-3, of the smallest determinant of the gradient over the model. If it is above 0, nothing
    /// of it folds. This is proven for all bases except Bernstein, whose cells are sampled.
    pub min_cell_det: f64,
    /// Smallest determinant of the gradient over the samples.
    pub min_det: f64,
    /// Angular distortion: area-weighted mean of s1/s2 + s2/s1 − 2.
    pub angular: f64,
    /// Area distortion: area-weighted mean of s1·s2 + 1/(s1·s2) − 2.
    pub area: f64,
    /// Whether pins or moved handles gave way because the lattice would have folded ([`super::Guard::Limit`]).
    pub is_held_back: bool,
    /// Distance of each moved handle from its target, in units of the space.
    pub handle_errors: Vec<f64>,
    /// Number of linear solves: local-global and Newton steps, including rejected ones and those along a path, without those from
    /// other starts that led to a different result.
    pub iterations: usize,
    /// Whether the last step was below the tolerance.
    pub is_converged: bool,
    /// Whether the solution is a minimum or a saddle, if that is known.
    pub stationarity: Stationarity,
    /// The minimised energy, without the barrier; `None` for frames of trajectories and plain iterations.
    pub energy: Option<f64>,
    /// Pairs of pins, by index, at the same point with different targets, for which the solution is a compromise (least squares).
    pub conflicts: Vec<[usize; 2]>,
    /// Warnings for the user (contradicting handles, no pins, an empty shape...).
    pub warnings: Vec<String>,
}

/// A solved lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<const D: usize> {
    /// The lattice; the largest branch of a branching lattice.
    pub lattice: Lattice<D>,
    /// All branches, where parts of the shape have their own copies of handles.
    pub(crate) branches: Option<BranchedLattice<D>>,
    /// Quality of the solution.
    pub report: SolveReport,
}
