//! The local-global iteration: best rotations, then one linear solve, until the handles rest or Newton takes over.
//!
//! In: a factored problem and a first state. Out: handles, and how the iteration ended.

use super::Settings;
use super::anderson::Anderson;
use super::constraints::Constraints;
use super::energy::Distortion;
use super::matrix::{Factor, Normal};
use super::newton::{Finish, Pace};
use super::solver::{Scales, Terms};

/// Part by which the energy may rise: below it rounding decides, and rejecting good steps costs more than it saves.
pub(crate) const SAFEGUARD: f64 = 1e-8;

/// All that an iteration needs.
pub(crate) struct Iteration<'a, const D: usize> {
    pub(crate) distortion: &'a dyn Distortion<D>,
    /// The constant matrix of a coordinate.
    pub(crate) normal: &'a Normal,
    pub(crate) factor: &'a Factor,
    pub(crate) constraints: &'a Constraints,
    pub(crate) scales: Scales,
    pub(crate) terms: &'a Terms<D>,
    pub(crate) settings: &'a Settings,
    /// Length that steps are measured by.
    pub(crate) diagonal: f64,
    /// First handles, unless others are given; the weak hold pulls towards them.
    pub(crate) start: Vec<[f64; D]>,
    /// Handles to go on from.
    pub(crate) first: Option<&'a [[f64; D]]>,
    pub(crate) finish: Finish,
}

/// How an iteration ended.
#[derive(Clone, Debug)]
pub(crate) struct Run<const D: usize> {
    pub(crate) handles: Vec<[f64; D]>,
    pub(crate) iterations: usize,
    pub(crate) is_converged: bool,
}

/// Unweighted terms and their weighted sum.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Energies {
    /// Distortion.
    pub ml: f64,
    /// Pins.
    pub mp: f64,
    /// Moved handles.
    pub gp: f64,
    /// Regulariser.
    pub gr: f64,
    /// Weighted sum.
    pub total: f64,
}

impl<const D: usize> Iteration<'_, D> {
    /// Iterates to the tolerance or the limit.
    ///
    /// `observe` sees the terms after every local-global step, under the rotations it was solved with, then at every place
    /// that Newton's method takes, under the best rotations; at last those of the handles that come out.
    pub(crate) fn run(&self, mut observe: Option<&mut dyn FnMut(Energies)>) -> Run<D> {
        let mut tell = |handles: &[[f64; D]], turned_at: &[[f64; D]]| {
            if let Some(observe) = &mut observe {
                observe(self.energies(handles, turned_at));
            }
        };
        let constant = self.constant_right_side();
        let mut anderson = Anderson::new(self.settings.acceleration);
        let mut state = self.first.map_or_else(|| self.start.clone(), <[_]>::to_vec);
        let mut plain: Option<Vec<[f64; D]>> = None;
        let mut last_energy = f64::INFINITY;
        let mut misses = Vec::new();
        let mut pace = Pace::of(self);
        for iteration in 1..=self.settings.iteration_limit {
            let mut next = constant.clone();
            let mut energy = self.local_energy(&state, &mut next);
            // The safeguard: an accelerated state that is worse than the last one gives way to the plain one.
            if (energy.is_nan() || energy > last_energy * (1.0 + SAFEGUARD))
                && let Some(plain) = plain.take()
            {
                state = plain;
                anderson.reset();
                next.copy_from_slice(&constant);
                energy = self.local_energy(&state, &mut next);
            }
            last_energy = energy;
            self.factor.solve(&mut next);
            self.constraints.enforce(self.terms, &mut misses, &mut next);
            tell(&next, &state);
            let step = largest_step(&state, &next);
            if pace.as_mut().is_some_and(|pace| pace.is_time(step)) {
                return self.newton(&next, iteration, &mut |place| tell(place, place));
            }
            if step <= self.settings.tolerance * self.diagonal {
                return Run { handles: next, iterations: iteration, is_converged: true };
            }
            if self.settings.acceleration > 0 {
                plain = Some(next.clone());
                anderson.step(&state, &mut next);
            }
            state = next;
        }
        // An accelerated state that nobody has checked is not handed out.
        let handles = plain.unwrap_or(state);
        Run { handles, iterations: self.settings.iteration_limit, is_converged: false }
    }

    /// The terms at `handles` under the rotations that are best at `turned_at`.
    fn energies(&self, handles: &[[f64; D]], turned_at: &[[f64; D]]) -> Energies {
        let ml = self.distortion.energy(handles, turned_at);
        let mp = self.terms.pins.energy(handles);
        let gp = self.terms.handles.energy(handles);
        let gr = self.terms.regularizer.energy(handles);
        let scales = self.scales;
        let total = scales.shape * ml + scales.pins * mp + scales.handles * gp + scales.regularizer * gr;
        Energies { ml, mp, gp, gr, total }
    }

    /// Local step: adds its right side and gives the total energy at `state`.
    pub(crate) fn local_energy(&self, state: &[[f64; D]], right_side: &mut [[f64; D]]) -> f64 {
        let ml = self.distortion.local_step(state, self.scales.shape, right_side);
        if self.settings.acceleration == 0 {
            return 0.0;
        }
        self.scales.shape * ml
            + self.scales.pins * self.terms.pins.energy(state)
            + self.scales.handles * self.terms.handles.energy(state)
            + self.scales.regularizer * self.terms.regularizer.energy(state)
            + self.scales.hold * state.iter().zip(&self.start).map(|(x, start)| squared_gap(x, start)).sum::<f64>()
    }

    /// The part of the right side that no rotation changes.
    pub(crate) fn constant_right_side(&self) -> Vec<[f64; D]> {
        let mut right_side: Vec<[f64; D]> = self.start.iter().map(|x| x.map(|x| x * self.scales.hold)).collect();
        self.terms.pins.add_right_side(self.scales.pins, &mut right_side);
        self.terms.handles.add_right_side(self.scales.handles, &mut right_side);
        self.terms.regularizer.add_right_side(self.scales.regularizer, &mut right_side);
        right_side
    }
}

/// Largest distance a handle moves.
pub(crate) fn largest_step<const D: usize>(from: &[[f64; D]], to: &[[f64; D]]) -> f64 {
    let squares = from.iter().zip(to).map(|(a, b)| squared_gap(a, b));
    squares.fold(0.0, |most: f64, square| if square <= most { most } else { square }).sqrt()
}

fn squared_gap<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|d| (a[d] - b[d]).powi(2)).sum()
}
