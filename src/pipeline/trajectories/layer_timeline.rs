//! A screen layer as a function of time, from which its trajectory is solved.
//!
//! In: a [`PreparedShot`] and a layer. Out: the layer's problem at any time.

use crate::lattice::Grid;
use crate::pipeline::evaluate::camera_cuts::take_at;
use crate::pipeline::evaluate::part_triangle_ranges::held_triangle;
use crate::pipeline::evaluate::screen_layer::{LayerSolver, LayerTask, is_branching, unfactored};
use crate::pipeline::evaluate::screen_shape::{ScreenShape, screen_shape_with_starts};
use crate::pipeline::{PinAnchor, PreparedShot, TimeSample};
use crate::screen::primitive;
use crate::shot::{Layer, LayerSpace, PinTargets};
use crate::solve::{ModelPoint, Settings, SolveError, TimedProblem, Timeline, knots_per_gib};

/// Number of knots per frame.
pub(super) const KNOTS_PER_FRAME: u32 = 1;

/// Number of triangles above which models are posed and sampled one time after the other, not in parallel.
const HEAVY: usize = 250_000;

/// Returns the time of a layer's first knot. For layers on twos this is mid-exposure, so that drawings change half a
/// frame away from the knots.
pub(in crate::pipeline) fn first_knot(prepared: &PreparedShot, index: usize) -> f64 {
    let first = f64::from(prepared.shot.solve_range[0]);
    if prepared.shot.layers[index].step > 1 { prepared.mid_exposure_time(first) } else { first }
}

/// Callbacks of the caller that waits for a trajectory.
#[derive(Clone, Copy)]
pub(in crate::pipeline) struct Watcher<'a> {
    /// Whether the trajectory is no longer wanted.
    pub(in crate::pipeline) is_cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Receives the number of completed parts and the total.
    pub(in crate::pipeline) progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Watcher<'_> {
    /// Waits until the end and ignores progress.
    pub(in crate::pipeline) const NONE: Self = Self { is_cancelled: &|| false, progress: &|_, _| () };
}

/// A screen layer as a function of time.
pub(in crate::pipeline) struct LayerTimeline<'a> {
    pub(in crate::pipeline) prepared: &'a PreparedShot,
    pub(in crate::pipeline) index: usize,
    pub(in crate::pipeline) points: &'a [PinAnchor],
    pub(in crate::pipeline) watcher: Watcher<'a>,
}

impl LayerTimeline<'_> {
    fn layer(&self) -> &Layer {
        &self.prepared.shot.layers[self.index]
    }

    /// Returns the number of triangles in the parts of the layer.
    fn triangle_count(&self) -> usize {
        let PreparedShot { scene, assignment, .. } = self.prepared;
        let (pose, _) = self.prepared.view(f64::from(self.prepared.shot.solve_range[0]));
        let parts = assignment.parts_of_layer[self.index].iter();
        parts.map(|&part| primitive(scene, &pose.parts[part]).triangles.len()).sum()
    }

    /// Returns the layer's box and pins at a time, without a factored matrix, and the pins' targets.
    pub(in crate::pipeline) fn unfactored(&self, sample: &TimeSample) -> Option<(LayerSolver, PinTargets)> {
        let layer = self.layer();
        let task = LayerTask { index: self.index, layer, anchors: self.prepared.anchors_of(self.index), weights: &[] };
        let targets = self.prepared.shot.pin_targets(self.index, self.prepared.key_frame(layer, sample.frame));
        Some((unfactored(self.prepared, sample, &task)?, targets))
    }

    /// Returns the problem at a time; `None` if neither pins nor handles act. The first knot, and the first after a cut
    /// of the camera, has no predecessor and is solved along the whole path of the pins.
    pub(in crate::pipeline) fn problem(
        &self,
        sample: &TimeSample,
        solver: &mut LayerSolver,
        targets: &PinTargets,
    ) -> Option<TimedProblem<2>> {
        let layer = self.layer();
        let (_, goal) = solver.targets(layer, targets);
        if goal.pins.is_empty() && goal.handles.is_empty() {
            return None;
        }
        let ScreenShape { shape, starts } = screen_shape_with_starts(self.prepared, sample, self.index);
        if is_branching(layer) {
            solver.hold_triangles(self.prepared.anchors_of(self.index), &starts);
        }
        let (_, goal) = solver.targets(layer, targets);
        let shot = &self.prepared.shot;
        let take = take_at(self.prepared, sample.frame);
        let mut path = Vec::new();
        let is_first = sample.frame <= first_knot(self.prepared, self.index)
            || take_at(self.prepared, sample.frame - 1.0 / f64::from(KNOTS_PER_FRAME)) < take;
        if is_first {
            let way = shot.pin_path(self.index, self.prepared.key_frame(layer, sample.frame));
            path.extend(way.iter().map(|targets| solver.targets(layer, targets).1));
        }
        path.pop();
        path.push(goal);
        let mesh = sample.mesh();
        let points = self.points.iter().map(|point| ModelPoint {
            at: point.rest(&mesh, &sample.camera).point.0.to_array(),
            triangle: held_triangle(point, solver.starts()),
        });
        let grid = solver.grid().clone();
        let drawing = shot.drawing(self.index, self.prepared.key_frame(layer, sample.frame));
        Some(TimedProblem { grid, shape, path, points: points.collect(), drawing, take })
    }
}

impl Timeline<2> for LayerTimeline<'_> {
    type Error = SolveError;

    fn settings(&self) -> &Settings {
        &self.layer().settings
    }

    /// A time that cannot be posed is a gap; the error is reported when its own frame is rendered.
    fn at(&self, time: f64) -> Result<Option<TimedProblem<2>>, SolveError> {
        if (self.watcher.is_cancelled)() {
            return Err(SolveError::Cancelled);
        }
        let Ok(sample) = self.prepared.unsolved_at(time) else { return Ok(None) };
        let Some((mut solver, targets)) = self.unfactored(&sample) else { return Ok(None) };
        Ok(self.problem(&sample, &mut solver, &targets))
    }

    fn window(&self) -> usize {
        match self.layer().space {
            LayerSpace::Screen { dims, .. } => {
                let grid = Grid { dims, basis: self.layer().basis, lo: [0.0; 2], hi: [1.0; 2], angle: 0.0 };
                knots_per_gib(&grid, is_branching(self.layer()).then(|| self.triangle_count()))
            }
            LayerSpace::World { .. } => usize::MAX,
        }
    }

    fn is_light(&self) -> bool {
        self.triangle_count() < HEAVY
    }

    fn progress(&self, done: usize, of: usize) {
        (self.watcher.progress)(done, of);
    }
}
