//! Screen layers: solved on the screen, over the projected scene.
//!
//! In: a [`Moment`] that is projected, and a layer. Out: the layer's lattice and pins; its shape and box on the screen.

use super::follow::{FollowWindow, thickened};
use super::layer_pins::{fade, faded_weight, held_border, moved_handles, region};
use super::{LayerState, Moment, PinState, Pinned, PipelineError, Rest, Setup, strokes, whole_layer};
use crate::lattice::Grid;
use crate::pose::Pose;
use crate::screen::{Camera, Extent, ScreenMesh, bounds, clip_near, primitive, reach_of_frame};
use crate::shot::{BoxRule, Goal, Layer, LayerSpace, OffsetUnit, PinTargets, Rotation, Source};
use crate::solve::{Cancel, PointPin, Problem, Shape, SolveError, Solver, Targets};
use crate::space::{ScreenBox, ScreenPoint, ScreenVector};

/// A lattice box is never thinner than this, in frame heights.
const MIN_SIDE: f64 = 0.01;

/// A layer of the screen and what its pins are tied to: the shot's own, or one that a host drives.
#[derive(Clone, Copy, Debug)]
pub struct LayerTask<'a> {
    /// Which layer of the shot's it is: its nodes are the shape.
    pub index: usize,
    /// Lattice, settings, pins and handles.
    pub layer: &'a Layer,
    /// One a pin of that layer.
    pub anchors: &'a [Pinned],
    /// Weights of its pins, 0..=1, in their order; those that are missing weigh 1.
    pub weights: &'a [f64],
}

/// A layer of the screen at one moment, all but solved: what does not depend on where pins and handles go.
#[derive(Debug)]
pub struct Prepared {
    frame: f64,
    rest_box: ScreenBox,
    grid: Grid<2>,
    /// One a pin of the layer.
    rests: Vec<Rest>,
    /// Weights of the first pins of the layer; of the others 1.
    weights: Vec<f64>,
    border: Border,
    /// `None`: neither pins nor handles act.
    solver: Option<Solver<2>>,
}

/// What happens at the edge of a layer's box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Border {
    /// It moves as the pins want.
    Free,
    /// Its handles stay at rest: the layer moves others by keys.
    Held,
    /// It rests, and takes no handles away from the pins.
    Rests,
}

impl Setup {
    /// Solves a screen layer, or takes its lattice from a file.
    pub(super) fn solve_layer(
        &self,
        moment: &Moment,
        index: usize,
        bounds: BoxRule,
    ) -> Result<LayerState, PipelineError> {
        let layer = &self.shot.layers[index];
        if let Some(loaded) = &self.loaded[index] {
            return Ok(self.transferred(moment, (index, bounds), loaded));
        }
        if layer.pins.is_empty() && layer.handles.is_empty() {
            return Ok(LayerState::default());
        }
        if self.has_trajectory(index) {
            return self.solve_on_trajectory(moment, index);
        }
        // The whole way of the pins at this frame's anchors: how they came decides how they are wound.
        let path = self.shot.pin_path(index, self.key_frame(layer, moment.frame));
        let task = LayerTask { index, layer, anchors: &self.anchors[index], weights: &[] };
        match self.prepare(moment, &task, &path, &Cancel::never())? {
            Some(prepared) => prepared.solve(layer, &path),
            None => Ok(LayerState::default()),
        }
    }

    /// Everything of a screen layer's solve that does not depend on where its pins go; `path` tells what they hold, as
    /// [`Shot::pin_path`](crate::shot::Shot::pin_path) does. `None` where nothing of the layer is in reach, and for layers of the scene.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where the problem is malformed, or the solve is cancelled.
    pub fn prepare(
        &self,
        moment: &Moment,
        task: &LayerTask,
        path: &[PinTargets],
        cancel: &Cancel,
    ) -> Result<Option<Prepared>, PipelineError> {
        let LayerTask { index, layer, .. } = *task;
        let Some(mut prepared) = self.unprepared(moment, task) else { return Ok(None) };
        let Some((_, goal)) = path.last().map(|targets| prepared.targets(layer, targets)) else {
            return Ok(Some(prepared));
        };
        if !(goal.pins.is_empty() && goal.handles.is_empty()) {
            let shape = self.shape(moment, index);
            let Targets { pins, handles } = &goal;
            let settings = match prepared.border {
                Border::Rests => whole_layer::compliant(&layer.settings),
                Border::Free | Border::Held => layer.settings.clone(),
            };
            let problem = Problem { grid: &prepared.grid, shape: &shape, pins, handles, settings: &settings };
            let solver = Solver::build(&problem, cancel).map_err(|source| prepared.fault(layer, source))?;
            prepared.solver = Some(solver);
        }
        Ok(Some(prepared))
    }

    /// Box, grid and pins of a screen layer, without a solver.
    pub(super) fn unprepared(&self, moment: &Moment, task: &LayerTask) -> Option<Prepared> {
        let LayerTask { index, layer, anchors, weights } = *task;
        let LayerSpace::Screen { dims, bounds } = layer.space else { return None };
        let rest_box = self.lattice_box(moment, index, bounds)?;
        let mesh = moment.mesh();
        Some(Prepared {
            frame: moment.frame,
            rest_box,
            grid: Grid::over(rest_box, dims, layer.basis),
            rests: anchors.iter().map(|pinned| pinned.rest(&mesh, &moment.camera)).collect(),
            weights: weights.to_vec(),
            border: self.border(layer, bounds),
            solver: None,
        })
    }

    /// Where a layer moves a whole plate from edge to edge, nothing is known beyond the edge, and a background must not
    /// slide; with a scene the plate follows what the geometry does instead.
    fn border(&self, layer: &Layer, bounds: BoxRule) -> Border {
        match (&self.shot.source, bounds, &layer.matte) {
            (Source::Frame, BoxRule::Frame, None) if layer.handles.is_empty() => Border::Rests,
            (Source::Frame, BoxRule::Frame, None) => Border::Held,
            _ => Border::Free,
        }
    }

    /// Whether a layer moves a whole picture whose border rests.
    pub(super) fn border_rests(&self, layer: &Layer) -> bool {
        match layer.space {
            LayerSpace::Screen { bounds, .. } => self.border(layer, bounds) == Border::Rests,
            LayerSpace::World { .. } => false,
        }
    }

    /// The layer's triangles and lines on the screen, cut at the near plane.
    pub(super) fn shape(&self, moment: &Moment, index: usize) -> Shape<2> {
        let (mesh, near) = (moment.mesh(), moment.camera.near());
        let mut shape = Shape::default();
        for &part in &self.parts_of_layer[index] {
            let vertices = &mesh.parts[part].vertices;
            let base = shape.points.len() as u32;
            // Hidden vertices keep their index; no triangle that is left uses them.
            let place =
                |vertex: &crate::screen::Projected| if vertex.w > 0.0 { vertex.point().0.to_array() } else { [0.0; 2] };
            shape.points.extend(vertices.iter().map(place));
            let source = primitive(&self.scene, &moment.pose.parts[part]);
            source.lines.iter().for_each(|line| strokes::add(&mut shape, line, (vertices, base), near));
            for (number, corners) in source.triangles.iter().enumerate() {
                let ends = corners.map(|corner| vertices[corner as usize]);
                if ends.iter().all(|end| end.depth >= near && end.w > 0.0 && end.h.is_finite()) {
                    shape.triangles.push(corners.map(|corner| corner + base));
                    self.paint(index, (part, number), &mut shape);
                    continue;
                }
                let (cut, count) = clip_near(ends, near);
                for cut in &cut[..count] {
                    let first = shape.points.len() as u32;
                    let point =
                        |corner: &crate::screen::Corner| ends[corner.from].lerp(ends[corner.to], corner.share).point();
                    shape.points.extend(cut.iter().map(|corner| point(corner).0.to_array()));
                    shape.triangles.push([first, first + 1, first + 2]);
                }
                self.paint(index, (part, number), &mut shape);
            }
        }
        shape
    }

    /// The rest box of a layer's lattice; `None` where nothing of the layer is in reach.
    pub(super) fn lattice_box(&self, moment: &Moment, index: usize, rule: BoxRule) -> Option<ScreenBox> {
        match rule {
            BoxRule::Fixed(fixed) => Some(fixed),
            BoxRule::Frame => {
                Some(ScreenBox::new(ScreenPoint::default(), ScreenPoint::new(self.shot.size.aspect(), 1.0)))
            }
            BoxRule::Follow => {
                let now = self.bounds_of(index, &moment.pose, &moment.mesh(), &moment.camera).map(corners);
                let window = FollowWindow::new(moment.frame);
                let neighbours: Vec<_> = window.frames().map(|frame| (frame, self.bounds_at(index, frame))).collect();
                let [min, max] = thickened(window.smooth(&neighbours, now)?, MIN_SIDE);
                Some(ScreenBox::new(ScreenPoint(min.into()), ScreenPoint(max.into())))
            }
        }
    }

    pub(super) fn bounds_of(&self, layer: usize, pose: &Pose, mesh: &ScreenMesh, camera: &Camera) -> Option<ScreenBox> {
        let reach = reach_of_frame(self.shot.size);
        let extent = Extent { parts: &self.parts_of_layer[layer], near: camera.near(), reach };
        bounds(&self.scene, pose, mesh, extent)
    }
}

impl Prepared {
    /// The lattice's rest state.
    #[must_use]
    pub fn grid(&self) -> &Grid<2> {
        &self.grid
    }

    /// Where the layer's pins are before the warp, one a pin.
    #[must_use]
    pub fn rests(&self) -> &[Rest] {
        &self.rests
    }

    /// Solves for the end of a path of the same pins and handles. The same path gives the same bits, whatever was solved
    /// before.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where pins or handles are not those that were prepared, or no numbers.
    pub fn solve(&self, layer: &Layer, path: &[PinTargets]) -> Result<LayerState, PipelineError> {
        self.solve_cancellable(layer, path, &Cancel::never())
    }

    /// Like [`Self::solve`], unless it is cancelled.
    ///
    /// # Errors
    /// As [`Self::solve`], and [`SolveError::Cancelled`] as the source.
    pub fn solve_cancellable(
        &self,
        layer: &Layer,
        path: &[PinTargets],
        cancel: &Cancel,
    ) -> Result<LayerState, PipelineError> {
        let Some(solver) = &self.solver else { return Ok(LayerState::default()) };
        let (mut states, way): (Vec<_>, Vec<_>) = path.iter().map(|targets| self.targets(layer, targets)).unzip();
        let (Some(pins), Some(Targets { pins: points, handles })) = (states.pop(), way.last()) else {
            return Ok(LayerState::default());
        };
        let mut solution = solver.with_cancel(cancel).follow(&way).map_err(|source| self.fault(layer, source))?;
        if self.border == Border::Rests {
            let whole_pins = path.last().map(|targets| {
                let weights: Vec<f64> = pins.iter().map(|state| state.presence * self.weight(state.pin)).collect();
                whole_layer::whole_pins(&pins, targets, &weights)
            });
            let whole = whole_pins.map(|pins| whole_layer::finish(&mut solution, &pins));
            return Ok(LayerState { solution: Some(solution), pins, whole, world: None });
        }
        let presence = pins.iter().map(|pin| pin.presence).fold(0.0, f64::max);
        if handles.is_empty() && presence < 1.0 {
            fade(&mut solution, (solver, points), presence);
        }
        Ok(LayerState { solution: Some(solution), pins, ..LayerState::default() })
    }

    /// The pins that act, and everything the solver is told, for one place of the path.
    pub(super) fn targets(&self, layer: &Layer, targets: &PinTargets) -> (Vec<PinState>, Targets<2>) {
        let (states, pins) = self.point_pins(layer, targets);
        let mut handles = moved_handles(layer, &self.grid, targets);
        if self.border != Border::Free {
            handles.extend(held_border(&self.grid, &handles));
        }
        (states, Targets { pins, handles })
    }

    /// The weight of a pin of the layer.
    fn weight(&self, pin: usize) -> f64 {
        self.weights.get(pin).copied().unwrap_or(1.0)
    }

    fn fault(&self, layer: &Layer, source: SolveError) -> PipelineError {
        PipelineError::Solve { layer: layer.name.clone(), frame: self.frame, source }
    }

    /// The pins that act, as the overlay and the solver want them.
    fn point_pins(&self, layer: &Layer, targets: &PinTargets) -> (Vec<PinState>, Vec<PointPin<2>>) {
        let mut states = Vec::new();
        let mut points = Vec::new();
        for (pin, (rest, target)) in self.rests.iter().zip(&targets.pins).enumerate() {
            if rest.presence <= 0.0 {
                continue;
            }
            let goal = match target.goal {
                Goal::Offset(offset) => match layer.pins[pin].unit {
                    OffsetUnit::Frame => rest.point + offset,
                    OffsetUnit::Box => rest.point + ScreenVector(offset.0 * self.rest_box.size()),
                },
                Goal::Target(place) => rest.point + ScreenVector((place - rest.point).0 * layer.strength),
                // Those are of world layers; on the screen the checks refuse them.
                Goal::SceneOffset(_) | Goal::SceneTarget(_) => rest.point,
            };
            let is_turned = target.rotation.is_some() || target.log_scale.is_some();
            // Where the border rests, discs of the flow turn and scale.
            let gradient = (is_turned && self.border != Border::Rests).then(|| {
                let angle = match target.rotation {
                    Some(Rotation::InView(angle)) => angle,
                    _ => 0.0,
                };
                let (sin, cos) = angle.sin_cos();
                let scale = target.log_scale.unwrap_or(0.0).exp();
                [[scale * cos, scale * sin], [-scale * sin, scale * cos]]
            });
            states.push(PinState { pin, rest: rest.point, target: goal, presence: rest.presence, is_in_view: true });
            points.push(PointPin {
                at: rest.point.0.to_array(),
                target: goal.0.to_array(),
                weight: faded_weight(rest.presence * self.weight(pin)),
                gradient,
                region: region(&layer.pins[pin], self.rest_box.size().length()),
            });
        }
        (states, points)
    }
}

/// Lower left and upper right corner.
pub(super) fn corners(bounds: ScreenBox) -> [[f64; 2]; 2] {
    [bounds.min.0.to_array(), bounds.max.0.to_array()]
}
