//! Continuation: solves along a path of targets, each started from the last, to wind parts past half a turn and to stop before folds.
//!
//! In: a prefactored system and targets. Out: the result at the end of the path, or where the guard stopped. Local-global
//! iterations converge to the winding nearest to their start, so the path selects it; and what folds at the end of
//! a path did not fold at its beginning.

use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::{Minimization, MinimizationResult};
use super::settings::{Guard, Settings, Start};
use super::system::System;
use super::targets::Targets;
use super::winding;

/// Windings above this, radians, are solved step by step (150 degrees; a solve from the rigid fit jumps at 180).
const WOUND: f64 = 2.618;

/// The same with the guard, which may have to go back along the path: low enough that it does not switch paths
/// while it is active (60 degrees).
const WOUND_GUARDED: f64 = 1.047;

/// Largest rotation of a step (45 degrees).
const MAX_STEP: f64 = 0.785;

/// Steps from the rigid fit to the targets where the path does not matter.
const STRAIGHT_STEPS: usize = 8;

/// Bisections of the step in which the first fold is found: to 1/4096 of it.
const BISECTIONS: usize = 12;

/// Tolerance and limit of solves on the way.
const COARSE: (f64, usize) = (1e-4, 40);

/// The result of a path, and the fraction of its steps at which the guard stopped; `None`: the path was followed to its end.
type Followed<const D: usize> = (MinimizationResult<D>, Option<f64>);

impl<const D: usize> System<D> {
    /// Follows a path that winds parts of the shape; `None` where it does not, and its end can be solved directly.
    pub(crate) fn follow_winding(
        &self,
        path: &[Targets<D>],
        cancel: &Cancel,
    ) -> Result<Option<Followed<D>>, SolveError> {
        let limit = if self.settings().guard == Guard::Limit { WOUND_GUARDED } else { WOUND };
        let rotations = winding::rotations(self.grid(), path);
        let is_wound = rotations.last().is_some_and(|row| winding::spread(row) > limit);
        if !is_wound || self.settings().start == Start::Rest {
            return Ok(None);
        }
        let mut steps = match self.settings().guard {
            Guard::Limit => self.approach(&path[0]),
            Guard::Report => Vec::new(),
        };
        steps.extend(winding::steps(path, &rotations, MAX_STEP));
        self.follow(&steps, cancel).map(Some)
    }

    /// Follows the straight path from the rigid fit to the targets until something folds.
    pub(crate) fn follow_straight(&self, goal: &Targets<D>, cancel: &Cancel) -> Result<Followed<D>, SolveError> {
        let mut path = self.approach(goal);
        path.push(goal.clone());
        self.follow(&path, cancel)
    }

    /// The path from the rigid fit to targets, without its end.
    fn approach(&self, goal: &Targets<D>) -> Vec<Targets<D>> {
        let rigid = goal.rigid(self.grid());
        (0..STRAIGHT_STEPS).map(|step| rigid.interpolated(goal, step as f64 / STRAIGHT_STEPS as f64)).collect()
    }

    /// Solves for all targets, each from the last; with the guard, goes back from the end to the last step without folds.
    fn follow(&self, path: &[Targets<D>], cancel: &Cancel) -> Result<Followed<D>, SolveError> {
        let solve = |targets: &Targets<D>, initial: Option<&[[f64; D]]>, settings: &Settings| {
            cancel.check()?;
            let Targets { pins, handles } = targets;
            let to = self.retargeted(pins, handles, cancel)?;
            let minimization = self.minimization(&self.targets((pins, handles), &to), cancel);
            Ok::<_, SolveError>(Minimization { initial, settings, ..minimization }.run(None)?)
        };
        let coarse = Settings {
            tolerance: self.settings().tolerance.max(COARSE.0),
            iteration_limit: COARSE.1,
            ..self.settings().clone()
        };
        let mut states: Vec<MinimizationResult<D>> = Vec::with_capacity(path.len());
        let mut iterations = 0;
        for (index, targets) in path.iter().enumerate() {
            let settings = if index + 1 < path.len() { &coarse } else { self.settings() };
            let result = solve(targets, states.last().map(|state| &state.handles[..]), settings)?;
            iterations += result.iterations;
            states.push(result);
        }
        let last = path.len() - 1;
        let is_limited = self.settings().guard == Guard::Limit && !self.is_safe(&states[last].handles);
        if !is_limited || last == 0 {
            return Ok((MinimizationResult { iterations, ..states.swap_remove(last) }, None));
        }
        let mut from = last;
        // Coarse states are refined to the tolerance; the first one remains where no step is safe.
        let mut best = states[0].clone();
        while from > 0 {
            from -= 1;
            best = solve(&path[from], Some(&states[from].handles), self.settings())?;
            iterations += best.iterations;
            if self.is_safe(&best.handles) {
                break;
            }
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(low, high);
            let targets = path[from].interpolated(&path[from + 1], middle);
            let result = solve(&targets, Some(&best.handles), self.settings())?;
            iterations += result.iterations;
            if self.is_safe(&result.handles) {
                (low, best) = (middle, result);
            } else {
                high = middle;
            }
        }
        Ok((MinimizationResult { iterations, ..best }, Some((from as f64 + low) / last as f64)))
    }
}
