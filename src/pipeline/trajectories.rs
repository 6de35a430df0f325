//! Screen layers with a temporal weight: solved over a range of frames instead of frame by frame.
//!
//! In: a [`PreparedShot`], a layer. Out: its [`Trajectory`], computed once; the layer's state at any time. The range is the shot's own,
//! so a frame depends on the shot and its number alone.

use super::layer_pins::fade;
use super::screen_layer::{LayerSolver, LayerTask, border_rests, unfactored};
use super::screen_shape::screen_shape;
use super::watched_trajectory::WatchedTrajectory;
use super::{LayerState, PinAnchor, PipelineError, PreparedShot, TimeSample};
use crate::screen::primitive;
use crate::shot::{Layer, LayerSpace, PinTargets};
use crate::solve::{
    Cancel, Coupling, Guard, Problem, Settings, SolveError, Solver, Spread, Targets, TimedProblem, Timeline, Trajectory,
};
use glam::DVec3;
use std::sync::{Arc, PoisonError};

/// Knots a frame.
const KNOTS_PER_FRAME: u32 = 2;

/// A speed that needs no reason: a pixel of 1080 lines a frame, in frame heights.
const LEAST_SPEED: f64 = 1.0 / 1080.0;

/// Points of the model that a trajectory watches.
const WATCHED_POINTS: usize = 256;

/// Whether the frames of a layer are solved together.
pub(super) fn has_trajectory(prepared: &PreparedShot, index: usize) -> bool {
    let layer = &prepared.shot.layers[index];
    let is_moved = !layer.pins.is_empty() || !layer.handles.is_empty();
    let is_screen = matches!(layer.space, LayerSpace::Screen { .. });
    let Settings { temporal, guard, .. } = layer.settings;
    // A layer on twos jumps because it is asked to.
    temporal > 0.0
        && guard == Guard::Report
        && layer.step <= 1
        && is_moved
        && is_screen
        && prepared.layer_inputs.loaded[index].is_none()
        // Its lattice is compliant, and what is left depends on this frame's pins.
        && !border_rests(&prepared.shot.source, layer)
}

/// The state of a layer whose frames are solved together.
pub(super) fn solve(prepared: &PreparedShot, sample: &TimeSample, index: usize) -> Result<LayerState, PipelineError> {
    let layer = &prepared.shot.layers[index];
    let kept = trajectory(prepared, index)?;
    let timeline = LayerTimeline { prepared, index, points: &kept.points };
    let Some((solver, targets)) = timeline.unfactored(sample) else { return Ok(LayerState::default()) };
    let (states, goal) = solver.targets(layer, &targets);
    let Some(problem) = timeline.problem(sample, &solver, &targets) else { return Ok(LayerState::default()) };
    let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame: sample.frame, source };
    let shape = problem.shape.clone();
    let solved = kept.trajectory.solve_at(sample.frame, problem, &layer.settings, &Cancel::never());
    let mut solution = solved.map_err(fault)?;
    let presence = states.iter().map(|pin| pin.presence).fold(0.0, f64::max);
    if goal.handles.is_empty() && presence < 1.0 {
        let Targets { pins, handles } = &goal;
        let (grid, settings) = (solver.grid(), &layer.settings);
        let solver = Solver::new(&Problem { grid, shape: &shape, pins, handles, settings }).map_err(fault)?;
        fade(&mut solution, (&solver, pins), presence);
    }
    Ok(LayerState { solution: Some(solution), pins: states, ..LayerState::default() })
}

/// A snap of a layer that is spread over a frame.
pub(super) fn spread_at(prepared: &PreparedShot, index: usize, frame: i32) -> Result<Option<Spread>, PipelineError> {
    if !has_trajectory(prepared, index) {
        return Ok(None);
    }
    let kept = trajectory(prepared, index)?;
    let holds = |spread: &&Spread| (spread.frames[0]..=spread.frames[1]).contains(&f64::from(frame));
    Ok(kept.trajectory.spreads().iter().find(holds).copied())
}

fn trajectory(prepared: &PreparedShot, index: usize) -> Result<Arc<WatchedTrajectory>, PipelineError> {
    let mut kept = prepared.cache.trajectories.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.get(&index) {
        return Ok(Arc::clone(known));
    }
    let layer = &prepared.shot.layers[index];
    let [first, last] = prepared.shot.solve_range.map(f64::from);
    let coupling = Coupling {
        first,
        last,
        knots_per_frame: KNOTS_PER_FRAME,
        weight: layer.settings.temporal,
        least_speed: LEAST_SPEED,
    };
    let points = watched_points(prepared, index, first);
    let timeline = LayerTimeline { prepared, index, points: &points };
    let trajectory = Trajectory::solve(&timeline, coupling, &Cancel::never()).map_err(|fault| match fault {
        Fault::Solve(source) => PipelineError::Solve { layer: layer.name.clone(), frame: first, source },
        Fault::Pose(error) => error,
    })?;
    let solved = Arc::new(WatchedTrajectory { trajectory, points });
    kept.insert(index, Arc::clone(&solved));
    Ok(solved)
}

/// Points spread evenly over the area of a layer's triangles in a frame; of a layer of lines its vertices.
fn watched_points(prepared: &PreparedShot, index: usize, frame: f64) -> Vec<PinAnchor> {
    let (pose, _) = prepared.view(frame);
    let mut areas = Vec::new();
    let mut total = 0.0;
    for &part in &prepared.assignment.parts_of_layer[index] {
        let positions = &pose.parts[part].positions;
        let share = prepared.assignment.share(index, part);
        for (triangle, corners) in primitive(&prepared.scene, &pose.parts[part]).triangles.iter().enumerate() {
            let [a, b, c]: [DVec3; 3] = corners.map(|corner| positions[corner as usize].0.as_dvec3());
            total += (b - a).cross(c - a).length() * share.of(corners);
            areas.push((total, part, (triangle, *corners)));
        }
    }
    if total > 0.0 {
        let pick = |k: usize| {
            let wanted = total * (k as f64 + 0.5) / WATCHED_POINTS as f64;
            let (_, part, (triangle, corners)) =
                areas[areas.partition_point(|area| area.0 < wanted).min(areas.len() - 1)];
            PinAnchor::Surface { part, triangle, corners, barycentric: [1.0 / 3.0; 3] }
        };
        return (0..WATCHED_POINTS).map(pick).collect();
    }
    let vertices = prepared.assignment.parts_of_layer[index].iter().flat_map(|&part| {
        let lines = &primitive(&prepared.scene, &pose.parts[part]).lines;
        lines.iter().flatten().map(move |&vertex| (part, vertex))
    });
    let vertices: Vec<(usize, u32)> = vertices.collect();
    let step = vertices.len().div_ceil(WATCHED_POINTS).max(1);
    let pinned = |&(part, vertex): &(usize, u32)| PinAnchor::Surface {
        part,
        // A line has none.
        triangle: usize::MAX,
        corners: [vertex; 3],
        barycentric: [1.0, 0.0, 0.0],
    };
    vertices.iter().step_by(step).map(pinned).collect()
}

/// A layer of the screen as a function of time.
struct LayerTimeline<'a> {
    prepared: &'a PreparedShot,
    index: usize,
    points: &'a [PinAnchor],
}

/// What goes wrong at a knot.
enum Fault {
    Solve(SolveError),
    Pose(PipelineError),
}

impl From<SolveError> for Fault {
    fn from(source: SolveError) -> Self {
        Self::Solve(source)
    }
}

impl LayerTimeline<'_> {
    fn layer(&self) -> &Layer {
        &self.prepared.shot.layers[self.index]
    }

    /// The layer's box and pins at a time, and where they have to go.
    fn unfactored(&self, sample: &TimeSample) -> Option<(LayerSolver, PinTargets)> {
        let layer = self.layer();
        let task = LayerTask { index: self.index, layer, anchors: self.prepared.anchors_of(self.index), weights: &[] };
        let targets = self.prepared.shot.pin_targets(self.index, self.prepared.key_frame(layer, sample.frame));
        Some((unfactored(self.prepared, sample, &task)?, targets))
    }

    /// `None` where neither pins nor handles act. The first knot is solved alone: there the whole way of the pins counts.
    fn problem(&self, sample: &TimeSample, solver: &LayerSolver, targets: &PinTargets) -> Option<TimedProblem<2>> {
        let layer = self.layer();
        let (_, goal) = solver.targets(layer, targets);
        if goal.pins.is_empty() && goal.handles.is_empty() {
            return None;
        }
        let shot = &self.prepared.shot;
        let mut path = Vec::new();
        if sample.frame <= f64::from(shot.solve_range[0]) {
            let way = shot.pin_path(self.index, self.prepared.key_frame(layer, sample.frame));
            path.extend(way.iter().map(|targets| solver.targets(layer, targets).1));
        }
        path.pop();
        path.push(goal);
        let mesh = sample.mesh();
        let points = self.points.iter().map(|point| point.rest(&mesh, &sample.camera).point.0.to_array());
        let (grid, shape) = (solver.grid().clone(), screen_shape(self.prepared, sample, self.index));
        Some(TimedProblem { grid, shape, path, points: points.collect() })
    }
}

impl Timeline<2> for LayerTimeline<'_> {
    type Error = Fault;

    fn settings(&self) -> &Settings {
        &self.layer().settings
    }

    fn at(&self, time: f64) -> Result<Option<TimedProblem<2>>, Fault> {
        let sample = self.prepared.unsolved_at(time).map_err(Fault::Pose)?;
        let Some((solver, targets)) = self.unfactored(&sample) else { return Ok(None) };
        Ok(self.problem(&sample, &solver, &targets))
    }
}
