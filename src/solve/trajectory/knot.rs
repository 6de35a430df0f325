//! The problem of one time, with a proximal term towards the states of neighbouring times.
//!
//! In: a [`TimedProblem`], displacements of its points. Out: displacements of its points and handles. Displacements are relative
//! to the rigid motion that fits the pins best, so they are constant where all pins move rigidly, and in a frame that rotates with
//! the model.

use super::displacement::Displacement;
use super::timeline::TimedProblem;
use crate::lattice::Grid;
use crate::solve::cached_factor::CachedFactor;
use crate::solve::cancel::Cancel;
use crate::solve::error::SolveError;
use crate::solve::linalg::small_matrix::minus;
use crate::solve::minimization::{Minimization, MinimizationResult};
use crate::solve::point_weights::PointWeights;
use crate::solve::problem::Problem;
use crate::solve::rigid_motion::RigidMotion;
use crate::solve::settings::Settings;
use crate::solve::system::System;
use crate::solve::targets::Targets;
use crate::solve::upright::Upright;
use crate::solve::winding::{Winding, wrapped};

/// Distance from rest, in box diagonals, below which the points of a state with resting pins are set to rest exactly.
const REST_TOLERANCE: f64 = 0.01;

/// Angle, in radians, below which a rotation is rounding.
const ROUNDING: f64 = 1e-9;

/// Number of Newton steps of a warm solve in space. Neighbours move meanwhile, so converging against them would be wasted.
const STEPS_IN_SPACE: usize = 2;

/// The problem of one time with its proximal term.
#[derive(Debug)]
pub(crate) struct Knot<const D: usize> {
    pub(crate) system: System<D>,
    path: Vec<Targets<D>>,
    /// Rest positions of the model's points, over the upright box.
    pub(super) points: Vec<[f64; D]>,
    /// Angle of the box, in radians.
    pub(crate) angle: f64,
    /// Rotation of the model since the first knot, in radians; that of the box at the first knot.
    pub(crate) model_angle: f64,
    /// The grid, rotated as the box is relative to the frame of the model.
    pub(super) in_model: Grid<D>,
    pub(super) rigid: RigidImage<D>,
    factor: CachedFactor,
    /// Whether all pins and handles are at rest.
    pub(crate) is_resting: bool,
    /// Whether the state is rest whatever its neighbours do.
    pub(crate) holds_rest: bool,
    /// The drawing that the knot belongs to.
    pub(crate) drawing: i64,
    /// Number of cuts of the camera before the knot.
    pub(crate) take: i64,
    /// The state.
    pub(crate) displacement: Displacement<D>,
}

/// Images of handles and points under the rigid fit of the pins.
#[derive(Debug)]
pub(super) struct RigidImage<const D: usize> {
    handles: Vec<[f64; D]>,
    pub(super) points: Vec<[f64; D]>,
}

/// A proximal term: it draws the displacements of the points to given ones.
pub(crate) struct Proximal<const D: usize> {
    pub(crate) displacement: Displacement<D>,
    pub(crate) weights: PointWeights,
}

/// How a solve starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Descent {
    /// From a state that may be far from the minimum.
    Cold,
    /// From a state near the minimum: in the plane with the factorisation of the previous solve, in space by a few steps, which may
    /// not reach the minimum.
    Warm,
}

impl<const D: usize> Knot<D> {
    /// Samples and factors a problem. The initial state is the rigid fit, in the frame of the box.
    pub(crate) fn new(problem: TimedProblem<D>, settings: &Settings, cancel: &Cancel) -> Result<Self, SolveError> {
        let rotated = problem.grid.clone();
        let TimedProblem { grid, shape, path, points, drawing, take } = Upright::of(&rotated).problem(problem);
        let goal = path.last().cloned().unwrap_or(Targets { pins: Vec::new(), handles: Vec::new() });
        let Targets { pins, handles } = &goal;
        let bare = Problem { grid: &grid, shape: &shape, pins, handles, settings };
        let system = System::with_points(&bare, &points, cancel)?;
        let is_resting = goal.are_at_rest(&grid);
        let rigid = RigidMotion::fit_continuous(&grid, &goal);
        let images = |points: Vec<[f64; D]>| match is_resting {
            true => points,
            false => points.iter().map(|point| rigid.image(point)).collect(),
        };
        let rigid = RigidImage { handles: images(system.rest()), points: images(system.point_targets()) };
        let points = points.iter().map(|point| point.at).collect();
        let displacement = Displacement {
            handles: vec![[0.0; D]; rigid.handles.len()],
            copies: system.copy_names(),
            points: vec![[0.0; D]; rigid.points.len()],
            box_angle: 0.0,
        };
        Ok(Self {
            system,
            path,
            points,
            angle: rotated.angle,
            model_angle: rotated.angle,
            in_model: grid,
            rigid,
            factor: CachedFactor::default(),
            is_resting,
            holds_rest: false,
            drawing,
            take,
            displacement,
        })
    }

    /// Sets the angle of the box relative to the frame of the model; the state stays as it is.
    pub(crate) fn set_box_angle(&mut self, angle: f64) {
        self.in_model.angle = angle;
        self.displacement.box_angle = angle;
    }

    /// Continues the rotation of the model from the knot before, if the box has rotated in between.
    pub(crate) fn follow_rotation(&mut self, before: &Self) {
        let in_box = if self.angle == before.angle { 0.0 } else { rotation_between(&before.points, &self.points) };
        self.set_box_angle(before.in_model.angle - in_box);
        self.model_angle = before.model_angle + wrapped(self.angle - before.angle + in_box);
    }

    pub(crate) fn grid(&self) -> &Grid<D> {
        self.system.grid()
    }

    /// The targets at this time.
    pub(crate) fn goal(&self) -> Option<&Targets<D>> {
        self.path.last()
    }

    /// Continues the winding of the pins from the time before. If all pins and handles are at rest and nothing is wound, the state is
    /// rest from now on.
    pub(crate) fn follow_winding(&mut self, winding: &mut Winding) {
        self.path.iter().for_each(|targets| winding.advance(self.system.grid(), targets));
        self.holds_rest = self.is_resting && !winding.is_wound();
    }

    /// Whether another time has the same problem, as where keys hold a pose over a still model.
    pub(crate) fn is_held_by(&self, other: &Self) -> bool {
        self.drawing == other.drawing
            && self.take == other.take
            && self.grid() == other.grid()
            && self.points == other.points
            && self.goal() == other.goal()
            && self.displacement.copies == other.displacement.copies
    }

    /// Sets the state to that of another time. Copies of handles that did not exist then are interpolated from the others and the
    /// points.
    pub(crate) fn start_from(&mut self, state: &Displacement<D>) {
        self.displacement = self.transferred(state);
    }

    /// Same as [`Self::start_from`], returned as the result of a solve.
    pub(crate) fn at(&mut self, state: &Displacement<D>) -> MinimizationResult<D> {
        self.start_from(state);
        let handles = self.handles();
        MinimizationResult {
            has_given_way: self.system.gives_way(&handles),
            ..MinimizationResult::of(handles, 0, true)
        }
    }

    /// Sets the state to rest, where all pins and handles are at rest.
    pub(crate) fn at_rest(&mut self) -> MinimizationResult<D> {
        let mut rest = self.displacement.clone();
        rest.handles.fill([0.0; D]);
        rest.points.fill([0.0; D]);
        self.at(&rest)
    }

    /// The state of another time, expressed by the unknowns of this one.
    fn transferred(&self, state: &Displacement<D>) -> Displacement<D> {
        let &Displacement { ref copies, box_angle, .. } = &self.displacement;
        let has_handles = state.has_handles_of(box_angle);
        if *copies == state.copies && has_handles {
            return Displacement { box_angle, ..state.clone() };
        }
        let count = self.rigid.handles.len();
        let known = if has_handles { state.handles_by_name(copies, count) } else { vec![None; count] };
        let handles = self.system.interpolated(&known, &state.points, &Cancel::never());
        let handles = handles.unwrap_or_else(|| known.iter().map(|known| known.unwrap_or([0.0; D])).collect());
        Displacement { handles, copies: copies.clone(), points: state.points.clone(), box_angle }
    }

    /// Solves this time without a proximal term, like a single frame.
    pub(crate) fn solve_alone(&mut self, cancel: &Cancel) -> Result<MinimizationResult<D>, SolveError> {
        self.system.set_proximal_targets([], &PointWeights::ZERO, cancel)?;
        let result = match self.system.follow_winding(&self.path, cancel)? {
            Some(result) => result,
            None => self.system.least(&self.system.own_targets(), None, cancel)?,
        };
        self.set_state(&result.handles);
        Ok(result)
    }

    /// Solves a time between knots, from the displacements of the proximal term. Rest stays rest exactly.
    pub(crate) fn solve_between(
        &mut self,
        proximal: &Proximal<D>,
        cancel: &Cancel,
    ) -> Result<MinimizationResult<D>, SolveError> {
        let Proximal { displacement, weights } = proximal;
        if self.rests_at(displacement) {
            return Ok(self.at(displacement));
        }
        self.start_from(displacement);
        self.solve_proximal((&displacement.points, weights), Descent::Cold, cancel)
    }

    /// Solves from the current state with a proximal term of these weights towards the given displacements of the points.
    pub(crate) fn solve_proximal(
        &mut self,
        (points, weights): (&[[f64; D]], &PointWeights),
        descent: Descent,
        cancel: &Cancel,
    ) -> Result<MinimizationResult<D>, SolveError> {
        let places = self.rigid.points.iter().zip(points);
        let places = places.map(|(rigid, by)| displaced(&self.in_model, rigid, by));
        self.system.set_proximal_targets(places, weights, cancel)?;
        let initial = self.handles();
        let targets = self.system.own_targets();
        let minimization = self.system.minimization(&targets, cancel);
        let is_warm = descent == Descent::Warm;
        let in_few_steps = match is_warm && D == 3 {
            true => minimization.newton_in_space(&initial, (0, STEPS_IN_SPACE), &mut |_| ())?,
            false => None,
        };
        let result = match in_few_steps {
            Some(result) => result,
            None if is_warm && minimization.has_newton() => {
                minimization.newton_from(initial, &mut self.factor, usize::MAX)?
            }
            None => Minimization { initial: Some(&initial), ..minimization }.run(None)?,
        };
        self.set_state(&result.handles);
        Ok(result)
    }

    /// Whether pins, handles and the given state are all at rest.
    fn rests_at(&self, state: &Displacement<D>) -> bool {
        self.is_resting && state.points.iter().chain(&state.handles).all(|by| *by == [0.0; D])
    }

    /// Positions of the handles in the present state.
    pub(crate) fn handles(&self) -> Vec<[f64; D]> {
        self.displaced_handles(&self.displacement.handles)
    }

    fn displaced_handles(&self, by: &[[f64; D]]) -> Vec<[f64; D]> {
        self.rigid.handles.iter().zip(by).map(|(rigid, by)| displaced(&self.in_model, rigid, by)).collect()
    }

    /// Whether the energy with a proximal term of these weights is convex at the present state.
    pub(crate) fn is_convex(&self, weights: &PointWeights) -> bool {
        self.system.is_convex(&self.handles(), weights, &Cancel::never())
    }

    /// Same as [`Self::is_convex`], at the mean of this state and that of the next knot.
    pub(crate) fn is_convex_halfway(&self, next: &Self, weights: &PointWeights) -> bool {
        let halfway = self.displacement.interpolated(&self.transferred(&next.displacement), 0.5).handles;
        self.system.is_convex(&self.displaced_handles(&halfway), weights, &Cancel::never())
    }

    /// Sets the state to the solved handles. If all pins rest and all points are near rest, the state becomes rest exactly, which
    /// is the global minimum: a moving neighbour would otherwise draw it away by fractions of a pixel. Points are farther from
    /// rest only where the model has been wound around, or a snap is spread over the knot.
    fn set_state(&mut self, handles: &[[f64; D]]) {
        let points = self.system.point_images(handles);
        let by = |images: &[[f64; D]], rigid: &[[f64; D]]| -> Vec<[f64; D]> {
            images.iter().zip(rigid).map(|(a, b)| self.in_model.rotated(minus(a, b))).collect()
        };
        let (handles, points) = (by(handles, &self.rigid.handles), by(&points, &self.rigid.points));
        (self.displacement.handles, self.displacement.points) = (handles, points);
        let nearness = REST_TOLERANCE * self.grid().diagonal();
        let is_near = |by: &[f64; D]| by.iter().all(|along| along.abs() < nearness);
        if self.is_resting && self.displacement.points.iter().all(is_near) {
            self.displacement.handles.fill([0.0; D]);
            self.displacement.points.fill([0.0; D]);
        }
    }
}

/// Moves a point over the upright box by a vector in the frame of the model, in which `in_model` is the grid.
fn displaced<const D: usize>(in_model: &Grid<D>, point: &[f64; D], by: &[f64; D]) -> [f64; D] {
    let by = in_model.rotated_back(*by);
    std::array::from_fn(|d| point[d] + by[d])
}

/// Angle of the rotation that maps points to others best, in radians, within ±π; 0 in space, and for points in one place.
fn rotation_between<const D: usize>(from: &[[f64; D]], to: &[[f64; D]]) -> f64 {
    if D != 2 || from.is_empty() {
        return 0.0;
    }
    let mean = |points: &[[f64; D]]| -> [f64; D] {
        std::array::from_fn(|d| points.iter().map(|point| point[d]).sum::<f64>() / points.len() as f64)
    };
    let (from_mean, to_mean) = (mean(from), mean(to));
    let (mut cross, mut dot) = (0.0, 0.0);
    for (from, to) in from.iter().zip(to) {
        let (a, b) = (minus(from, &from_mean), minus(to, &to_mean));
        cross += a[0] * b[1] - a[1] * b[0];
        dot += a[0] * b[0] + a[1] * b[1];
    }
    let angle = cross.atan2(dot);
    // Where the model rotates with its box, rounding does not.
    if angle.abs() < ROUNDING { 0.0 } else { angle }
}

/// Whether the lattice branches at one of two knots.
pub(super) fn have_branches<const D: usize>(knots: [&Knot<D>; 2]) -> bool {
    knots.iter().any(|knot| knot.system.has_branches())
}
