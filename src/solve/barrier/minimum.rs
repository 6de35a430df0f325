//! Minima of the energy with the barrier.
//!
//! In: the minimum of the energy without the barrier. Out: the same state if every point of the barrier is clear (det J ≥ 0.2),
//! else a minimum with the barrier, in which no cell is folded. Cells that fold between their points get more points.

use super::Barrier;
use super::descent::{CAUTION, Descent, Vectors};
use super::points::FINE;
use super::potential::{ACTIVATION_DET, MIN_DET};
use super::reactions::Reactions;
use crate::smoothstep::smoothstep;
use crate::solve::cached_factor::CachedFactor;
use crate::solve::cancel::Cancelled;
use crate::solve::minimization::{Minimization, MinimizationResult};
use std::collections::BTreeMap;

/// Minimum det J of the start state where the descent starts from the problem itself.
const FIRST: f64 = 2.5 * MIN_DET;

/// Minimum det J that the previous state of a similar problem must have for the descent to start from it.
const LAST: f64 = 1.01 * MIN_DET;

/// Maximum number of refinements, each of which doubles the points per axis in the cells that fold between their points.
const REFINEMENTS: usize = 2;

impl<const D: usize> Minimization<'_, D> {
    /// Returns `free`, the minimum without the barrier, if it is clear, else a minimum with the barrier. The descent starts from
    /// `before`, the state of a similar problem, where that is given and has no point close to the pole. `cached` holds the factor
    /// and the forces of the pins there, if there are any, and receives those at the minimum.
    pub(crate) fn with_barrier(
        &self,
        free: MinimizationResult<D>,
        before: Option<&[[f64; D]]>,
        cached: &mut CachedFactor,
    ) -> Result<MinimizationResult<D>, Cancelled> {
        let Some(barrier) = self.barrier.filter(|barrier| !barrier.is_clear(&free.handles)) else { return Ok(free) };
        let reactions = self.reactions(barrier, &free.handles, &cached.take_forces())?;
        let mut result = free;
        let mut finer = BTreeMap::new();
        for _ in 0..=REFINEMENTS {
            let refined = (!finer.is_empty()).then(|| barrier.refined(&finer));
            let points = refined.as_ref().unwrap_or_else(|| barrier.points());
            let first = match before.filter(|before| points.min_det(before, LAST) >= LAST) {
                Some(before) => before.to_vec(),
                None => {
                    let share = points.max_step(&self.start, &result.handles, FIRST);
                    if share < 1.0 { blend(&self.start, &result.handles, CAUTION * share) } else { result.handles }
                }
            };
            let mut descent =
                Descent::new((self, points), reactions.clone(), result.iterations, std::mem::take(cached));
            result = descent.run(first)?;
            *cached = descent.into_cached();
            let folded = barrier.folded(&result.handles);
            if folded.is_empty() {
                break;
            }
            for cell in folded {
                *finer.entry(cell).or_insert(FINE[usize::from(D > 2)]) *= 2;
            }
        }
        Ok(result)
    }

    /// The reactions of pins and moved handles. `forces` are those at the minimum of a similar problem, if they are known.
    fn reactions(
        &self,
        barrier: &Barrier<D>,
        free: &[[f64; D]],
        forces: &[f64],
    ) -> Result<Reactions<'_, D>, Cancelled> {
        let mut reactions = Reactions::new(self);
        // The force limits of the pins rise with the remaining determinant, so that pins do not give way suddenly where the
        // barrier begins to act.
        let share = smoothstep(barrier.min_det(free) / ACTIVATION_DET);
        reactions.initialise_multipliers(&self.unconstrained_step(free)?, share);
        reactions.set_multipliers(forces);
        Ok(reactions)
    }

    /// Takes one local-global step without enforcing hard constraints. Each hard row then misses its target by its force divided
    /// by its stiffness.
    fn unconstrained_step(&self, handles: &[[f64; D]]) -> Result<Vectors<D>, Cancelled> {
        let mut next = self.constant_right_side();
        self.local_energy(handles, &mut next);
        self.cancel.check()?;
        self.factor.solve(&mut next);
        Ok(next)
    }
}

/// Returns (1 − t) · from + t · to.
fn blend<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vectors<D> {
    from.iter().zip(to).map(|(a, b)| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t)).collect()
}
