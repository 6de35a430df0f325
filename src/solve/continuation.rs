//! Continuation: solves along a path of targets, each started from the previous result, to wind parts beyond half a turn.
//!
//! In: a prefactored system and targets. Out: the result at the end of the path. Local-global iterations converge to the winding
//! nearest to their start, so the path determines the winding.

use super::cancel::Cancel;
use super::error::SolveError;
use super::minimization::{Minimization, MinimizationResult};
use super::settings::{Settings, Start};
use super::system::System;
use super::targets::Targets;
use super::winding;

/// Winding above which a path is solved step by step, in radians (150 degrees; a solve from the rigid fit jumps at 180).
const WOUND: f64 = 2.618;

/// Largest rotation of a step, in radians (45 degrees).
const MAX_STEP: f64 = 0.785;

/// Tolerance and iteration limit of the solves before the last.
const COARSE: (f64, usize) = (1e-4, 40);

impl<const D: usize> System<D> {
    /// Solves along a path that winds parts of the shape. Returns `None` where the path does not, or where the settings start at
    /// rest; its end is then solved directly.
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

    /// Solves for each of the targets in turn, starting from the previous result; all but the last are solved coarsely. Returns
    /// `None` for an empty path.
    fn follow(&self, path: &[Targets<D>], cancel: &Cancel) -> Result<Option<MinimizationResult<D>>, SolveError> {
        let coarse = Settings {
            tolerance: self.settings().tolerance.max(COARSE.0),
            iteration_limit: COARSE.1,
            ..self.settings().clone()
        };
        let mut last: Option<MinimizationResult<D>> = None;
        for (index, targets) in path.iter().enumerate() {
            cancel.check()?;
            let settings = if index + 1 < path.len() { &coarse } else { self.settings() };
            let to = self.retargeted(targets, cancel)?;
            let minimization = self.minimization(&self.targets(targets, &to), cancel);
            let initial = last.as_ref().map(|state| &state.handles[..]);
            let result = Minimization { initial, settings, ..minimization }.run(None)?;
            let iterations = result.iterations + last.as_ref().map_or(0, |state| state.iterations);
            last = Some(MinimizationResult { iterations, ..result });
        }
        Ok(last)
    }
}
