//! Solves along a path of targets, each from the last: to wind parts past half a turn, and to stop before a fold.
//!
//! In: a solver and waypoints. Out: a solution. Local-global iterations fall into the winding that is nearest to where
//! they start, so the way decides; and what folds at the end of a way did not at its beginning.

use super::iterate::Run;
use super::settings::{Guard, Start};
use super::solver::Solver;
use super::waypoint::{self, Waypoint};
use super::{Settings, Solution, SolveError};
use crate::lattice::Lattice;

/// Parts wound up farther than this, radians, are solved step by step (150 degrees; a plain start jumps at 180).
const WOUND: f64 = 2.618;

/// The same where the guard may have to go back along the path: before anything folds, so that it never changes paths
/// while it holds something back (60 degrees).
const GUARDED: f64 = 1.047;

/// Most turn of a step (45 degrees).
const STEP: f64 = 0.785;

/// Steps from the rigid fit to the targets where nothing is wound.
const STRAIGHT_STEPS: usize = 8;

/// Least determinant that the guard allows: cells squeezed to a hundredth are as good as folded.
const LEAST_DET: f64 = 0.01;

/// Halvings of the step in which the first fold is found: to 1/4096 of it.
const HALVINGS: usize = 12;

/// Tolerance and limit of solves on the way.
const COARSE: (f64, usize) = (1e-4, 40);

impl<const D: usize> Solver<D> {
    /// Solves for the last waypoint of a path. Where pins and handles wind parts of the shape up on the way (in the plane,
    /// pairs of them against each other by more than 150 degrees), the path decides in which direction and how often:
    /// every step is solved from the last. Elsewhere this is [`Self::update`], and the path does not matter. With the
    /// guard the way begins at the rigid fit of the first waypoint, where nothing folds.
    ///
    /// # Errors
    /// As [`Self::update`], for any waypoint.
    pub fn follow(&self, path: &[Waypoint<D>]) -> Result<Solution<D>, SolveError> {
        let Some(goal) = path.last() else { return Ok(self.solve()) };
        let limit = if self.settings().guard == Guard::Limit { GUARDED } else { WOUND };
        let turns = waypoint::turns(self.grid(), path);
        let is_wound = turns.last().is_some_and(|row| waypoint::spread(row) > limit);
        if !is_wound || self.settings().start == Start::Rest {
            return self.update(&goal.pins, &goal.handles);
        }
        let mut steps = match self.settings().guard {
            Guard::Limit => self.approach(&path[0]),
            Guard::Report => Vec::new(),
        };
        steps.extend(waypoint::steps(path, &turns, STEP));
        let (run, stopped_at) = self.walk(&steps)?;
        Ok(self.finish(goal, run, stopped_at))
    }

    /// From the rigid fit straight to the targets, as far as nothing folds. `None` where the way ends unfolded.
    pub(crate) fn walk_straight(&self, goal: &Waypoint<D>) -> Result<(Run<D>, Option<f64>), SolveError> {
        let mut path = self.approach(goal);
        path.push(goal.clone());
        self.walk(&path)
    }

    /// The way from the rigid fit to a waypoint, without its end.
    fn approach(&self, goal: &Waypoint<D>) -> Vec<Waypoint<D>> {
        let rigid = goal.rigid(self.grid());
        (0..STRAIGHT_STEPS).map(|step| rigid.towards(goal, step as f64 / STRAIGHT_STEPS as f64)).collect()
    }

    /// Solves every waypoint from the last; with the guard, goes back from the end to where nothing folds, and tells at
    /// which share of the path that is.
    fn walk(&self, path: &[Waypoint<D>]) -> Result<(Run<D>, Option<f64>), SolveError> {
        let coarse = Settings {
            tolerance: self.settings().tolerance.max(COARSE.0),
            iteration_limit: COARSE.1,
            ..self.settings().clone()
        };
        let mut states: Vec<Run<D>> = Vec::with_capacity(path.len());
        let mut iterations = 0;
        for (index, waypoint) in path.iter().enumerate() {
            let settings = if index + 1 < path.len() { &coarse } else { self.settings() };
            let run = self.settle(waypoint, states.last().map(|run| &run.handles[..]), settings)?;
            iterations += run.iterations;
            states.push(run);
        }
        let last = path.len() - 1;
        let is_limited = self.settings().guard == Guard::Limit && !self.is_safe(&states[last].handles);
        if !is_limited || last == 0 {
            return Ok((Run { iterations, ..states.swap_remove(last) }, None));
        }
        let mut from = last;
        // Coarse states once more to the tolerance; the first of all is what remains where no step is safe.
        let mut best = states[0].clone();
        while from > 0 {
            from -= 1;
            best = self.settle(&path[from], Some(&states[from].handles), self.settings())?;
            iterations += best.iterations;
            if self.is_safe(&best.handles) {
                break;
            }
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            let run =
                self.settle(&path[from].towards(&path[from + 1], middle), Some(&best.handles), self.settings())?;
            iterations += run.iterations;
            if self.is_safe(&run.handles) {
                (low, best) = (middle, run);
            } else {
                high = middle;
            }
        }
        Ok((Run { iterations, ..best }, Some((from as f64 + low) / last as f64)))
    }

    /// Nothing that holds some of the shape folds, nor is near to it.
    pub(crate) fn is_safe(&self, handles: &[[f64; D]]) -> bool {
        let lattice = Lattice { grid: self.grid().clone(), handles: handles.to_vec() };
        self.folds(&lattice).least_det >= LEAST_DET
    }
}
