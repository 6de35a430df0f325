//! A problem of one time whose model is drawn to where it is at neighbouring times.
//!
//! In: a [`TimedProblem`], displacements of its points. Out: displacements of its points and handles.
//! Displacements are measured from the rigid motion that fits the pins best: where all pins move rigidly they are constant.

use super::timeline::TimedProblem;
use crate::lattice::Grid;
use crate::solve::cancel::Cancel;
use crate::solve::error::SolveError;
use crate::solve::linalg::small_matrix::{distance, minus};
use crate::solve::minimization::{Minimization, MinimizationResult};
use crate::solve::newton::CachedFactor;
use crate::solve::pins::RigidMotion;
use crate::solve::problem::Problem;
use crate::solve::settings::Settings;
use crate::solve::system::System;
use crate::solve::targets::Targets;

/// How far handles and points of the model are from where the rigid fit of the pins takes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Displacement<const D: usize> {
    /// #handles.
    pub(crate) handles: Vec<[f64; D]>,
    /// #points.
    pub(crate) points: Vec<[f64; D]>,
}

impl<const D: usize> Displacement<D> {
    /// (1 − t) · self + t · to.
    pub(crate) fn interpolated(&self, to: &Self, t: f64) -> Self {
        Self { handles: mix(&self.handles, &to.handles, t), points: mix(&self.points, &to.points, t) }
    }

    /// Farthest that a point moves to another displacement.
    pub(crate) fn farthest(&self, to: &Self) -> f64 {
        self.points.iter().zip(&to.points).map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
    }
}

fn mix<const D: usize>(from: &[[f64; D]], to: &[[f64; D]], t: f64) -> Vec<[f64; D]> {
    let between = |(a, b): (&[f64; D], &[f64; D])| std::array::from_fn(|d| a[d] * (1.0 - t) + b[d] * t);
    from.iter().zip(to).map(between).collect()
}

/// The problem of one time with its proximal term.
#[derive(Debug)]
pub(crate) struct Knot<const D: usize> {
    pub(crate) system: System<D>,
    path: Vec<Targets<D>>,
    /// The points of the model at rest.
    points: Vec<[f64; D]>,
    /// Where the rigid fit takes handles and points.
    rigid: Displacement<D>,
    factor: CachedFactor,
    /// Which drawing it belongs to.
    pub(crate) drawing: i64,
    /// The least proximal weight with which the energy is known to be convex at the state.
    convex_from: f64,
    /// The state.
    pub(crate) displacement: Displacement<D>,
}

/// How a knot is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Descent {
    /// From a state that may be far from the minimum.
    Cold,
    /// From a state near the minimum, with the factorisation of the last solve.
    Warm,
}

impl<const D: usize> Knot<D> {
    /// Samples and factors a problem; its state is the rigid fit.
    pub(crate) fn new(problem: TimedProblem<D>, settings: &Settings, cancel: &Cancel) -> Result<Self, SolveError> {
        let TimedProblem { grid, shape, path, points, drawing } = problem;
        let goal = path.last().cloned().unwrap_or(Targets { pins: Vec::new(), handles: Vec::new() });
        let Targets { pins, handles } = &goal;
        let bare = Problem { grid: &grid, shape: &shape, pins, handles, settings };
        let system = System::with_points(&bare, &points, cancel)?;
        let rigid = RigidMotion::fit(&grid, pins, handles).continuous();
        let images = |points: &[[f64; D]]| points.iter().map(|point| rigid.image(point)).collect();
        let clamped: Vec<_> = points.iter().map(|&point| grid.clamp_to_box(point)).collect();
        let rigid = Displacement { handles: images(&grid.rest_handles()), points: images(&clamped) };
        let displacement =
            Displacement { handles: vec![[0.0; D]; rigid.handles.len()], points: vec![[0.0; D]; rigid.points.len()] };
        let factor = CachedFactor::default();
        Ok(Self { system, path, points, rigid, factor, drawing, convex_from: f64::INFINITY, displacement })
    }

    pub(crate) fn grid(&self) -> &Grid<D> {
        self.system.grid()
    }

    /// The targets.
    pub(crate) fn goal(&self) -> Option<&Targets<D>> {
        self.path.last()
    }

    /// Solves for this time alone, as a frame without neighbours is solved.
    pub(crate) fn solve_alone(&mut self, cancel: &Cancel) -> Result<MinimizationResult<D>, SolveError> {
        self.system.draw_points([], 0.0, cancel)?;
        let result = match self.system.follow_winding(&self.path, cancel)? {
            Some(result) => result,
            None => self.system.least(&self.system.own_targets(), None, cancel)?,
        };
        self.take(&result.handles);
        Ok(result)
    }

    /// Solves with the points drawn to displacements with this weight, from the current state.
    pub(crate) fn solve_near(
        &mut self,
        (points, weight): (&[[f64; D]], f64),
        descent: Descent,
        cancel: &Cancel,
    ) -> Result<MinimizationResult<D>, SolveError> {
        let places = self.rigid.points.iter().zip(points);
        let places = places.map(|(rigid, by)| std::array::from_fn(|d| rigid[d] + by[d]));
        self.system.draw_points(places, weight, cancel)?;
        let initial = self.handles();
        let targets = self.system.own_targets();
        let minimization = self.system.minimization(&targets, cancel);
        let result = if descent == Descent::Warm && minimization.has_newton() {
            minimization.newton_from(initial, &mut self.factor, usize::MAX)
        } else {
            Minimization { initial: Some(&initial), ..minimization }.run(None)
        }?;
        self.take(&result.handles);
        Ok(result)
    }

    /// The handles of the state.
    pub(crate) fn handles(&self) -> Vec<[f64; D]> {
        self.displaced(&self.displacement.handles)
    }

    fn displaced(&self, by: &[[f64; D]]) -> Vec<[f64; D]> {
        let sums = self.rigid.handles.iter().zip(by);
        sums.map(|(rigid, by)| std::array::from_fn(|d| rigid[d] + by[d])).collect()
    }

    /// Whether the energy with a proximal term of this weight is convex at its state.
    pub(crate) fn is_convex(&self, weight: f64, cancel: &Cancel) -> bool {
        weight >= self.convex_from || self.system.is_convex(&self.handles(), weight, cancel)
    }

    /// Whether it is halfway to another state.
    pub(crate) fn is_convex_towards(&self, to: &Displacement<D>, weight: f64, cancel: &Cancel) -> bool {
        let middle = self.displacement.interpolated(to, 0.5).handles;
        self.system.is_convex(&self.displaced(&middle), weight, cancel)
    }

    /// Keeps what was found of the state.
    pub(crate) fn note_convex(&mut self, weight: f64) {
        self.convex_from = self.convex_from.min(weight);
    }

    fn take(&mut self, handles: &[[f64; D]]) {
        self.convex_from = f64::INFINITY;
        let points = self.system.point_images(handles);
        let by = |images: &[[f64; D]], rigid: &[[f64; D]]| images.iter().zip(rigid).map(|(a, b)| minus(a, b)).collect();
        self.displacement =
            Displacement { handles: by(handles, &self.rigid.handles), points: by(&points, &self.rigid.points) };
    }

    /// Farthest that pins' targets, the model's points and their rigid images move to the next knot.
    pub(crate) fn motion(&self, next: &Self) -> f64 {
        let farthest =
            |a: &[[f64; D]], b: &[[f64; D]]| a.iter().zip(b).map(|(a, b)| distance(a, b)).fold(0.0, f64::max);
        let surface = farthest(&self.points, &next.points).max(farthest(&self.rigid.points, &next.rigid.points));
        let (Some(from), Some(to)) = (self.goal(), next.goal()) else { return surface };
        if from.pins.len() != to.pins.len() || from.handles.len() != to.handles.len() {
            return surface;
        }
        let pins = from.pins.iter().zip(&to.pins).map(|(a, b)| distance(&a.target, &b.target));
        let handles = from.handles.iter().zip(&to.handles).map(|(a, b)| distance(&a.target, &b.target));
        pins.chain(handles).fold(surface, f64::max)
    }
}
