//! The minimisation of one solve: its energy, right-hand sides and prefactored matrix.
//!
//! In: a prefactored system and targets. Out: energies, right-hand sides, and the type of the result.

use super::barrier::Barrier;
use super::cancel::Cancel;
use super::constraints::Constraints;
use super::energy::Distortion;
use super::linalg::factorization::Factorization;
use super::linalg::normal_matrix::NormalMatrix;
use super::settings::Settings;
use super::terms::{Scales, Terms};

/// Relative increase of the energy that still counts as none: smaller differences are rounding errors, and rejecting good steps
/// costs more than it saves.
pub(crate) const SAFEGUARD: f64 = 1e-8;

/// Method with which an iteration ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FinalPhase {
    /// Newton's method, if the energy implements its second derivative.
    Newton,
    /// Local-global steps only.
    LocalGlobal,
}

/// One solve: the energy with its matrix and targets.
pub(crate) struct Minimization<'a, const D: usize> {
    pub(crate) distortion: &'a dyn Distortion<D>,
    /// Constant matrix of one coordinate.
    pub(crate) normal: &'a NormalMatrix,
    pub(crate) factor: &'a Factorization,
    pub(crate) constraints: &'a Constraints,
    pub(crate) scales: Scales,
    pub(crate) terms: &'a Terms<D>,
    pub(crate) settings: &'a Settings,
    /// Diagonal of the rest box, the unit in which steps are measured.
    pub(crate) diagonal: f64,
    /// Rigid fit of the pins, or the rest handles: the start state unless `initial` is given, and the centre of the Tikhonov term.
    pub(crate) start: Vec<[f64; D]>,
    /// Start state in place of `start`.
    pub(crate) initial: Option<&'a [[f64; D]]>,
    pub(crate) final_phase: FinalPhase,
    /// Barrier that keeps cells from folding, if there is one.
    pub(crate) barrier: Option<&'a Barrier<D>>,
    pub(crate) cancel: &'a Cancel<'a>,
}

/// The result of a minimisation.
#[derive(Clone, Debug)]
pub(crate) struct MinimizationResult<const D: usize> {
    pub(crate) handles: Vec<[f64; D]>,
    pub(crate) iterations: usize,
    pub(crate) is_converged: bool,
    /// Whether some pins gave way to the barrier.
    pub(crate) has_given_way: bool,
    /// Whether the second derivative is positive definite at the result; `None` if it was not checked.
    pub(crate) is_minimum: Option<bool>,
    /// Energy of the result without the barrier; `None` if it was not computed.
    pub(crate) energy: Option<f64>,
}

impl<const D: usize> MinimizationResult<D> {
    /// A result without a barrier, of which nothing else was computed.
    pub(crate) fn of(handles: Vec<[f64; D]>, iterations: usize, is_converged: bool) -> Self {
        Self { handles, iterations, is_converged, has_given_way: false, is_minimum: None, energy: None }
    }
}

/// Energy terms without their weights, and the weighted sum.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub(crate) struct Energies {
    /// Distortion of the shape, E_ml.
    pub ml: f64,
    /// Pins, E_mp.
    pub mp: f64,
    /// Moved handles, E_gp.
    pub gp: f64,
    /// Regulariser, E_gr.
    pub gr: f64,
    /// Weighted sum, including the proximal term.
    pub total: f64,
}

impl<const D: usize> Minimization<'_, D> {
    /// Energy terms at `handles` with the rotations that are best at `rotations_at`.
    pub(crate) fn energies(&self, handles: &[[f64; D]], rotations_at: &[[f64; D]]) -> Energies {
        let ml = self.distortion.energy(handles, rotations_at);
        let mp = self.terms.acting_pins().energy(handles);
        let gp = self.terms.handles.energy(handles);
        let gr = self.terms.regularizer.energy(handles);
        let scales = self.scales;
        let proximal = scales.proximal * self.terms.proximal.energy(handles);
        let total = scales.shape * ml + scales.pins * mp + scales.handles * gp + scales.regularizer * gr + proximal;
        Energies { ml, mp, gp, gr, total }
    }

    /// Local step: adds the right-hand side of the best rotations at `state` and returns the total energy there. Plain iterations
    /// without a barrier do not need the energy and get 0.
    pub(crate) fn local_energy(&self, state: &[[f64; D]], right_side: &mut [[f64; D]]) -> f64 {
        let ml = self.distortion.local_step(state, self.scales.shape, right_side, self.cancel);
        if self.settings.acceleration == 0 && self.barrier.is_none() {
            return 0.0;
        }
        self.scales.shape * ml
            + self.scales.pins * self.terms.acting_pins().energy(state)
            + self.scales.handles * self.terms.handles.energy(state)
            + self.scales.regularizer * self.terms.regularizer.energy(state)
            + self.scales.tikhonov * state.iter().zip(&self.start).map(|(x, start)| squared_gap(x, start)).sum::<f64>()
            + self.scales.proximal * self.terms.proximal.energy(state)
    }

    /// Total energy at `handles`; 0 for plain iterations without a barrier, see [`Self::local_energy`].
    pub(crate) fn energy(&self, handles: &[[f64; D]]) -> f64 {
        self.local_energy(handles, &mut vec![[0.0; D]; handles.len()])
    }

    /// The part of the right-hand side that does not depend on rotations.
    pub(crate) fn constant_right_side(&self) -> Vec<[f64; D]> {
        let mut right_side: Vec<[f64; D]> = self.start.iter().map(|x| x.map(|x| x * self.scales.tikhonov)).collect();
        self.terms.acting_pins().add_right_side(self.scales.pins, &mut right_side);
        self.terms.handles.add_right_side(self.scales.handles, &mut right_side);
        self.terms.regularizer.add_right_side(self.scales.regularizer, &mut right_side);
        self.terms.proximal.add_right_side(self.scales.proximal, &mut right_side);
        right_side
    }
}

/// Largest distance that a handle moves between two states; NaN if one is NaN.
pub(crate) fn largest_step<const D: usize>(from: &[[f64; D]], to: &[[f64; D]]) -> f64 {
    let squares = from.iter().zip(to).map(|(a, b)| squared_gap(a, b));
    squares.fold(0.0, |most: f64, square| if square <= most { most } else { square }).sqrt()
}

fn squared_gap<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|d| (a[d] - b[d]).powi(2)).sum()
}
