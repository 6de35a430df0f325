//! Screen layers: solved on the screen, over the projected scene.
//!
//! In: a [`Moment`] that is projected, and a layer. Out: the layer's lattice and pins; its shape and box on the screen.

use super::follow::{FollowWindow, thickened};
use super::layer_pins::{fade, faded_weight, held_border, moved_handles, region};
use super::{LayerState, Moment, PinState, PipelineError, Setup, strokes};
use crate::lattice::Grid;
use crate::pose::Pose;
use crate::screen::{Camera, Extent, ScreenMesh, bounds, clip_near, primitive, reach_of_frame};
use crate::shot::{BoxRule, Goal, Layer, OffsetUnit, PinTargets, Rotation, Source};
use crate::solve::{PointPin, Problem, Shape, Solver, Waypoint};
use crate::space::{ScreenBox, ScreenPoint, ScreenVector};

/// A lattice box is never thinner than this, in frame heights.
const MIN_SIDE: f64 = 0.01;

impl Setup {
    /// Solves a screen layer, or takes its lattice from a file.
    pub(super) fn solve_layer(
        &self,
        moment: &Moment,
        index: usize,
        (dims, bounds): ([usize; 2], BoxRule),
    ) -> Result<LayerState, PipelineError> {
        let layer = &self.shot.layers[index];
        if let Some(loaded) = &self.loaded[index] {
            return Ok(self.transferred(moment, (index, bounds), loaded));
        }
        if layer.pins.is_empty() && layer.handles.is_empty() {
            return Ok(LayerState::default());
        }
        let Some(rest_box) = self.lattice_box(moment, index, bounds) else {
            return Ok(LayerState::default());
        };
        let grid = Grid::over(rest_box, dims, layer.basis);
        // The whole way of the pins at this frame's anchors: how they came decides how they are wound.
        let path = self.shot.pin_path(index, self.key_frame(layer, moment.frame));
        let waypoint = |targets: &PinTargets| {
            let (states, pins) = self.point_pins(moment, index, (rest_box, targets));
            let mut handles = moved_handles(layer, &grid, targets);
            if self.is_border_held(layer, bounds) {
                handles.extend(held_border(&grid, &handles));
            }
            (states, Waypoint { pins, handles })
        };
        let (mut states, way): (Vec<_>, Vec<_>) = path.iter().map(waypoint).unzip();
        let pins = states.pop().unwrap_or_default();
        let Some(Waypoint { pins: points, handles }) = way.last() else { return Ok(LayerState::default()) };
        if points.is_empty() && handles.is_empty() {
            return Ok(LayerState::default());
        }
        let presence = pins.iter().map(|pin| pin.presence).fold(0.0, f64::max);
        let shape = self.shape(moment, index);
        let problem = Problem { grid: &grid, shape: &shape, pins: points, handles, settings: &layer.settings };
        let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame: moment.frame, source };
        let solver = Solver::new(&problem).map_err(fault)?;
        let mut solution = solver.follow(&way).map_err(fault)?;
        if handles.is_empty() && presence < 1.0 {
            fade(&mut solution, (&solver, points), presence);
        }
        Ok(LayerState { solution: Some(solution), pins, world: None })
    }

    /// Whether the layer moves a whole plate from edge to edge. Beyond the edge nothing is known, and a background must not
    /// slide; with a scene the plate follows what the geometry does instead.
    fn is_border_held(&self, layer: &Layer, bounds: BoxRule) -> bool {
        self.shot.source == Source::Frame && bounds == BoxRule::Frame && layer.matte.is_none()
    }

    /// The pins that act, as the overlay and the solver want them.
    fn point_pins(
        &self,
        moment: &Moment,
        index: usize,
        (rest_box, targets): (ScreenBox, &PinTargets),
    ) -> (Vec<PinState>, Vec<PointPin<2>>) {
        let layer = &self.shot.layers[index];
        let mut states = Vec::new();
        let mut points = Vec::new();
        for (pin, (pinned, target)) in self.anchors[index].iter().zip(&targets.pins).enumerate() {
            let rest = pinned.rest(&moment.mesh, &moment.camera);
            if rest.presence <= 0.0 {
                continue;
            }
            let goal = match target.goal {
                Goal::Offset(offset) => match layer.pins[pin].unit {
                    OffsetUnit::Frame => rest.point + offset,
                    OffsetUnit::Box => rest.point + ScreenVector(offset.0 * rest_box.size()),
                },
                Goal::Target(place) => rest.point + ScreenVector((place - rest.point).0 * layer.strength),
                // Those are of world layers; on the screen the checks refuse them.
                Goal::SceneOffset(_) | Goal::SceneTarget(_) => rest.point,
            };
            let gradient = (target.rotation.is_some() || target.log_scale.is_some()).then(|| {
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
                weight: faded_weight(rest.presence),
                gradient,
                region: region(&layer.pins[pin], rest_box.size().length()),
            });
        }
        (states, points)
    }

    /// The layer's triangles and lines on the screen, cut at the near plane.
    pub(super) fn shape(&self, moment: &Moment, index: usize) -> Shape<2> {
        let near = moment.camera.near();
        let mut shape = Shape::default();
        for &part in &self.parts_of_layer[index] {
            let vertices = &moment.mesh.parts[part].vertices;
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
                let now = self.bounds_of(index, &moment.pose, &moment.mesh, &moment.camera).map(corners);
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

/// Lower left and upper right corner.
pub(super) fn corners(bounds: ScreenBox) -> [[f64; 2]; 2] {
    [bounds.min.0.to_array(), bounds.max.0.to_array()]
}
