//! Local-global iteration: alternates best rotations and one linear solve until it converges or Newton's method takes over.
//!
//! In: a minimisation and a start state. Out: handles, and whether the iteration converged.

use super::anderson::Anderson;
use super::cached_factor::CachedFactor;
use super::cancel::Cancelled;
use super::minimization::{Energies, Minimization, MinimizationResult, SAFEGUARD, largest_step};
use super::newton::NewtonSwitch;

impl<const D: usize> Minimization<'_, D> {
    /// Iterates to the tolerance or the iteration limit, then enforces the barrier if there is one.
    ///
    /// `observe` receives the energy terms after every local-global step, with the rotations of that step, then at every iterate
    /// that Newton's method accepts, with the best rotations, and once more for the result if the barrier has changed it.
    ///
    /// # Errors
    /// [`Cancelled`] if the caller cancels.
    pub(crate) fn run(
        &self,
        mut observe: Option<&mut dyn FnMut(Energies)>,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let free = match &mut observe {
            Some(observe) => self.run_without_barrier(Some(&mut **observe))?,
            None => self.run_without_barrier(None)?,
        };
        let iterations = free.iterations;
        let result = self.with_barrier(free, self.initial, &mut CachedFactor::default())?;
        if let Some(observe) = observe.filter(|_| result.iterations > iterations) {
            observe(self.energies(&result.handles, &result.handles));
        }
        Ok(result)
    }

    /// Same as [`Self::run`], without the barrier.
    pub(crate) fn run_without_barrier(
        &self,
        mut observe: Option<&mut dyn FnMut(Energies)>,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let mut notify = |handles: &[[f64; D]], rotations_at: &[[f64; D]]| {
            if let Some(observe) = &mut observe {
                observe(self.energies(handles, rotations_at));
            }
        };
        let constant = self.constant_right_side();
        let mut anderson = Anderson::new(self.settings.acceleration);
        let mut state = self.initial.map_or_else(|| self.start.clone(), <[_]>::to_vec);
        let mut plain: Option<Vec<[f64; D]>> = None;
        let mut last_energy = f64::INFINITY;
        let mut residuals = Vec::new();
        let mut switch = NewtonSwitch::of(self);
        for iteration in 1..=self.settings.iteration_limit {
            let mut next = constant.clone();
            let mut energy = self.local_energy(&state, &mut next);
            // Safeguard: an accelerated state with a higher energy than the previous state is replaced by the plain one.
            if (energy.is_nan() || energy > last_energy * (1.0 + SAFEGUARD))
                && let Some(plain) = plain.take()
            {
                state = plain;
                anderson.reset();
                next.copy_from_slice(&constant);
                energy = self.local_energy(&state, &mut next);
            }
            last_energy = energy;
            self.cancel.check()?;
            self.factor.solve(&mut next);
            self.constraints.enforce(self.terms, &mut residuals, &mut next);
            notify(&next, &state);
            let step = largest_step(&state, &next);
            if switch.as_mut().is_some_and(|switch| switch.should_switch(step)) {
                return self.newton(&next, iteration, &mut |iterate| notify(iterate, iterate));
            }
            if self.should_switch_in_space((iteration, step)) {
                let limit = self.settings.iteration_limit;
                let solved =
                    self.newton_in_space(&next, (iteration, limit), &mut |iterate| notify(iterate, iterate))?;
                if let Some(result) = solved {
                    return Ok(result);
                }
            }
            if step <= self.settings.tolerance * self.diagonal {
                return Ok(MinimizationResult::of(next, iteration, true));
            }
            if self.settings.acceleration > 0 {
                plain = Some(next.clone());
                anderson.step(&state, &mut next);
            }
            state = next;
        }
        // The plain state is returned, because the energy of the accelerated one has not been checked.
        let handles = plain.unwrap_or(state);
        Ok(MinimizationResult::of(handles, self.settings.iteration_limit, false))
    }
}
