//! Continuation: solves along a path of targets, each started from the last, to wind parts past half a turn.
//!
//! In: a prefactored system and targets. Out: the result at the end of the path. Local-global iterations converge to the winding
//! nearest to their start, so the path selects it.

use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::{Minimization, MinimizationResult};
use super::settings::{Settings, Start};
use super::system::System;
use super::targets::Targets;
use super::winding;

/// Windings above this, radians, are solved step by step (150 degrees; a solve from the rigid fit jumps at 180).
const WOUND: f64 = 2.618;

/// Largest rotation of a step (45 degrees).
const MAX_STEP: f64 = 0.785;

/// Tolerance and limit of solves on the way.
const COARSE: (f64, usize) = (1e-4, 40);

impl<const D: usize> System<D> {
    /// Follows a path that winds parts of the shape; `None` where it does not, and its end can be solved directly.
    pub(crate) fn follow_winding(
        &self,
        path: &[Targets<D>],
        cancel: &Cancel,
    ) -> Result<Option<MinimizationResult<D>>, SolveError> {
        let rotations = winding::rotations(self.grid(), path);
        let is_wound = rotations.last().is_some_and(|row| winding::spread(row) > WOUND);
        if !is_wound || self.settings().start == Start::Rest {
            return Ok(None);
        }
        self.follow(&winding::steps(path, &rotations, MAX_STEP), cancel)
    }

    /// Solves for all targets, each from the last, coarsely but for the end; `None`: there are none.
    fn follow(&self, path: &[Targets<D>], cancel: &Cancel) -> Result<Option<MinimizationResult<D>>, SolveError> {
        let coarse = Settings {
            tolerance: self.settings().tolerance.max(COARSE.0),
            iteration_limit: COARSE.1,
            ..self.settings().clone()
        };
        let mut last: Option<MinimizationResult<D>> = None;
        for (index, Targets { pins, handles }) in path.iter().enumerate() {
            cancel.check()?;
            let settings = if index + 1 < path.len() { &coarse } else { self.settings() };
            let to = self.retargeted(pins, handles, cancel)?;
            let minimization = self.minimization(&self.targets((pins, handles), &to), cancel);
            let initial = last.as_ref().map(|state| &state.handles[..]);
            let result = Minimization { initial, settings, ..minimization }.run(None)?;
            let iterations = result.iterations + last.as_ref().map_or(0, |state| state.iterations);
            last = Some(MinimizationResult { iterations, ..result });
        }
        Ok(last)
    }
}
