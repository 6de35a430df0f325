//! Search for the lowest minimum of a frame that is solved alone.
//!
//! In: the minimum that the solve from the rigid fit reaches. Out: the same where the shape is hardly deformed, else the lowest
//! minimum that several starts lead to, and whether the second derivative is positive definite there. Among equally low minima
//! the one on a fixed side is taken, so that a strip under compression always buckles to the same side. See docs/METHOD.md, "True
//! minima".

mod saddle;
mod side;
mod starts;

use super::cached_factor::CachedFactor;
use super::cancel::{Cancel, Cancelled};
use super::error::SolveError;
use super::minimization::{Energies, FinalPhase, Minimization, MinimizationResult};
use super::prefactored::TargetTerms;
use super::settings::{Settings, Start};
use super::system::System;
use super::targets::Targets;
use side::Side;

/// Mean ‖J − R‖² below which a shape counts as hardly deformed: none of 1,200 random problems had another minimum there.
const HARDLY_BENT: f64 = 5e-3;

/// Fraction of the energy by which one minimum must be lower than another; otherwise they count as equally low.
const LOWER: f64 = 3e-4;

/// Mean ‖ΔJ‖² between a coarsely solved state and a known minimum below which the state leads to that minimum.
const SAME: f64 = 5e-3;

/// Tolerance and iteration limit of a coarse solve from a start, and the maximum number of such solves in succession. After each
/// the state is compared with the known minima.
const COARSE: (f64, usize, usize) = (3e-3, 6, 5);

/// A start is dropped if after the second coarse solve its energy exceeds this multiple of the lowest known energy: parts are
/// then wound the wrong way.
const HOPELESS: f64 = 1.5;

/// Maximum number of saddles that are left in succession.
const ESCAPES: usize = 4;

impl<const D: usize> System<D> {
    /// Finds the lowest minimum for targets; `observe` is that of [`Minimization::run`].
    pub(crate) fn least(
        &self,
        targets: &TargetTerms<D>,
        mut observe: Option<&mut dyn FnMut(Energies)>,
        cancel: &Cancel,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let minimization = self.minimization(targets, cancel);
        let first = match &mut observe {
            Some(observe) => minimization.run_without_barrier(Some(&mut **observe))?,
            None => minimization.run_without_barrier(None)?,
        };
        if !minimization.has_second_derivative() || self.settings().start == Start::Rest || !first.is_converged {
            return minimization.with_barrier(first, None, &mut CachedFactor::default());
        }
        let mut search = Search::new(self, targets, &minimization, first);
        search.try_other_starts()?;
        let found = search.settled()?;
        let result = minimization.with_barrier(found, None, &mut CachedFactor::default())?;
        if let Some(observe) = observe {
            observe(minimization.energies(&result.handles, &result.handles));
        }
        Ok(result)
    }
}

impl<const D: usize> System<D> {
    /// Checks a state that was reached from a previous one. Returns a lower state beside it if it is a saddle, else the state
    /// itself. Where the barrier acts, its descent has checked the state.
    pub(crate) fn leave_saddle(
        &self,
        followed: MinimizationResult<D>,
        targets: &Targets<D>,
        cancel: &Cancel,
    ) -> Result<MinimizationResult<D>, SolveError> {
        let to = self.retargeted(targets, cancel)?;
        let targets = self.targets(targets, &to);
        let minimization = self.minimization(&targets, cancel);
        let is_held = minimization.barrier.is_some_and(|barrier| !barrier.is_clear(&followed.handles));
        if !minimization.has_second_derivative() || is_held {
            return Ok(followed);
        }
        let before = followed.handles.clone();
        let mut search = Search::new(self, &targets, &minimization, followed);
        search.rounds.clear();
        Ok(minimization.with_barrier(search.settled()?, Some(&before), &mut CachedFactor::default())?)
    }
}

impl<const D: usize> Minimization<'_, D> {
    /// Whether the energy has a second derivative that can be factored, and the settings do not ask for plain iterations.
    fn has_second_derivative(&self) -> bool {
        self.settings.acceleration > 0 && self.settings.tolerance > 0.0 && self.distortion.flops().is_some()
    }
}

/// Minima found so far.
struct Search<'a, const D: usize> {
    problem: &'a Minimization<'a, D>,
    side: Side<D>,
    /// Start states, in rounds.
    rounds: Vec<Vec<Vec<[f64; D]>>>,
    /// Known minima with their energies; the best is the first.
    known: Vec<(f64, MinimizationResult<D>)>,
}

impl<'a, const D: usize> Search<'a, D> {
    fn new(
        system: &System<D>,
        targets: &TargetTerms<D>,
        problem: &'a Minimization<'a, D>,
        first: MinimizationResult<D>,
    ) -> Self {
        let rotation = system.fitted(targets).rotation();
        let rest = system.rest();
        let side = Side::new(system.grid(), (&rest, system.stiffness()), &rotation);
        let energy = problem.energy(&first.handles);
        let stiffness = problem.scales.shape * problem.distortion.mass();
        let rounds = if energy > HARDLY_BENT * stiffness {
            starts::rounds(system.grid(), (&problem.start, &rest), &rotation)
        } else {
            Vec::new()
        };
        Self { problem, side, rounds, known: vec![(energy, first)] }
    }

    /// Solves from the start states, round after round while a round finds new minima.
    fn try_other_starts(&mut self) -> Result<(), Cancelled> {
        for starts in std::mem::take(&mut self.rounds) {
            let before = self.known.len();
            for from in starts {
                self.try_from(&from)?;
            }
            if self.known.len() == before {
                break;
            }
        }
        Ok(())
    }

    /// Solves from a state, unless it leads to a known minimum.
    fn try_from(&mut self, from: &[[f64; D]]) -> Result<(), Cancelled> {
        let problem = self.problem;
        let (tolerance, iteration_limit, times) = COARSE;
        let coarse = Settings { tolerance, iteration_limit, ..problem.settings.clone() };
        let (mut from, mut iterations) = (from.to_vec(), 0);
        for time in 0..times {
            let near = Minimization { settings: &coarse, final_phase: FinalPhase::LocalGlobal, ..problem.from(&from) };
            let near = near.run_without_barrier(None)?;
            iterations += near.iterations;
            let is_hopeless = time > 0 && problem.energy(&near.handles) > HOPELESS * self.known[0].0;
            if is_hopeless || self.is_known(&near.handles) {
                return Ok(());
            }
            from = near.handles;
            if near.is_converged {
                break;
            }
        }
        let found = problem.from(&from).run_without_barrier(None)?;
        if found.is_converged {
            self.note(MinimizationResult { iterations: iterations + found.iterations, ..found });
        }
        Ok(())
    }

    /// Adds a minimum, and makes it the best if it is lower, or equally low and on the fixed side.
    fn note(&mut self, found: MinimizationResult<D>) {
        let energy = self.problem.energy(&found.handles);
        if energy.is_nan() || self.is_known(&found.handles) {
            return;
        }
        let (least, best) = &self.known[0];
        // The energy of a saddle that is being left is infinite: any state beside it is lower.
        let margin = if least.is_finite() { LOWER * least } else { 0.0 };
        let is_better = energy < least - margin
            || energy <= least + margin && self.side.of(&difference(&found.handles, &best.handles)) > 0.0;
        self.known.push((energy, found));
        if is_better {
            let last = self.known.len() - 1;
            self.known.swap(0, last);
        }
    }

    /// Whether a state is near a known minimum.
    fn is_known(&self, handles: &[[f64; D]]) -> bool {
        let stiffness = self.problem.scales.shape * self.problem.distortion.mass();
        let is_near = |known: &MinimizationResult<D>| {
            let by = difference(handles, &known.handles);
            self.problem.squared_length(&by) < SAME * stiffness
        };
        self.known.iter().any(|(_, known)| is_near(known))
    }

    /// Returns the best state, after leaving it while it is a saddle and a lower state can be found.
    fn settled(mut self) -> Result<MinimizationResult<D>, Cancelled> {
        let mut is_minimum = self.problem.is_minimum(&self.known[0].1.handles)?;
        for _ in 0..ESCAPES {
            if is_minimum || !self.escape()? {
                break;
            }
            is_minimum = self.problem.is_minimum(&self.known[0].1.handles)?;
        }
        let (energy, best) = self.known.swap_remove(0);
        Ok(MinimizationResult { is_minimum: Some(is_minimum), energy: Some(energy), ..best })
    }

    /// Leaves a saddle to both sides; returns false if neither leads to a lower minimum.
    fn escape(&mut self) -> Result<bool, Cancelled> {
        let problem = self.problem;
        let saddle = self.known[0].1.handles.clone();
        let before = self.known[0].0;
        let Some(along) = problem.descent_direction(&saddle)? else { return Ok(false) };
        // The energy of the saddle no longer counts, so that states beside it replace it.
        self.known[0].0 = f64::INFINITY;
        let first = if self.side.of(&along) < 0.0 { -1.0 } else { 1.0 };
        for sign in [first, -first] {
            let found = problem.from(&sum(&saddle, &along, sign)).run_without_barrier(None)?;
            if found.is_converged && problem.energy(&found.handles) < before {
                self.note(found);
            }
        }
        let has_found = self.known[0].0.is_finite();
        if !has_found {
            self.known[0].0 = before;
        }
        Ok(has_found)
    }
}

impl<'a, const D: usize> Minimization<'a, D> {
    /// Returns the same minimisation with another start state.
    fn from<'b>(&'b self, initial: &'b [[f64; D]]) -> Minimization<'b, D>
    where
        'a: 'b,
    {
        Minimization { initial: Some(initial), start: self.start.clone(), ..*self }
    }
}

fn difference<const D: usize>(a: &[[f64; D]], b: &[[f64; D]]) -> Vec<[f64; D]> {
    sum(a, b, -1.0)
}

fn sum<const D: usize>(a: &[[f64; D]], b: &[[f64; D]], factor: f64) -> Vec<[f64; D]> {
    a.iter().zip(b).map(|(a, b)| std::array::from_fn(|d| a[d] + factor * b[d])).collect()
}
