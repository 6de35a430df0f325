//! World layers: shape, pins and handles at one time.
//!
//! In: a pose and its camera. Out: a [`WorldLayer`], and the problems that are solved for it.

use super::lattice_box::world_grid;
use super::layer_pins::{faded_weight, moved_handles, region};
use super::part_triangle_ranges::{PartTriangleRanges, held_triangle, links_of_shape};
use super::screen_layer::is_branching;
use crate::lattice::{BoxFrame, Grid};
use crate::pipeline::prepare::anchors::presence;
use crate::pipeline::{PinAnchor, PinState, PreparedShot, ScenePin};
use crate::pose::Pose;
use crate::screen::{Camera, primitive};
use crate::shot::{Goal, OffsetUnit, PinTarget, PinTargets, Rotation};
use crate::solve::{ModelPoint, PointPin, Shape, Targets, TimedProblem};
use crate::space::{ScenePoint, ScreenPoint, ScreenVector};
use glam::{DMat3, DVec3};

/// A world layer at one time, ready to be solved.
pub(in crate::pipeline) struct WorldLayer<'a> {
    pub(in crate::pipeline) prepared: &'a PreparedShot,
    pose: &'a Pose,
    camera: &'a Camera,
    pub(in crate::pipeline) index: usize,
    pub(in crate::pipeline) frame: BoxFrame,
    pub(in crate::pipeline) grid: Grid<3>,
    /// Positions of the parts in the shape, if the lattice may branch.
    pub(in crate::pipeline) starts: Vec<PartTriangleRanges>,
}

/// A pin as seen by the solver and by the user.
pub(in crate::pipeline) struct WorldPin {
    pub(in crate::pipeline) state: PinState,
    pub(in crate::pipeline) in_scene: ScenePin,
    point: PointPin<3>,
}

impl<'a> WorldLayer<'a> {
    /// Returns the layer at a (fractional) frame; `None` for screen layers, and for layers without pins, handles or geometry.
    pub(in crate::pipeline) fn at(
        prepared: &'a PreparedShot,
        index: usize,
        time: f64,
        (pose, camera): (&'a Pose, &'a Camera),
    ) -> Option<Self> {
        let layer = &prepared.shot.layers[index];
        let is_still = layer.pins.is_empty() && layer.handles.is_empty();
        let (frame, grid) = world_grid(prepared, index, time, pose).filter(|_| !is_still)?;
        let starts = if is_branching(layer) { part_starts(prepared, index, pose) } else { Vec::new() };
        Some(Self { prepared, pose, camera, index, frame, grid, starts })
    }

    /// Returns the layer's active pins at a time, and the targets of pins and handles.
    pub(in crate::pipeline) fn goal(&self, time: f64) -> (Vec<WorldPin>, Targets<3>) {
        let layer = &self.prepared.shot.layers[self.index];
        let targets = self.prepared.shot.pin_targets(self.index, self.prepared.key_frame(layer, time));
        let pins = self.pins(&targets);
        let points = pins.iter().map(|pin| pin.point).collect();
        (pins, Targets { pins: points, handles: moved_handles(layer, &self.grid, &targets) })
    }

    /// Returns the problem for a trajectory at a time; `None` if neither pins nor handles act.
    pub(in crate::pipeline) fn timed_problem(&self, time: f64, points: &[PinAnchor]) -> Option<TimedProblem<3>> {
        let (_, goal) = self.goal(time);
        if goal.pins.is_empty() && goal.handles.is_empty() {
            return None;
        }
        let layer = &self.prepared.shot.layers[self.index];
        let place = |anchor: &PinAnchor| {
            let at = self.frame.box_from_scene(anchor.in_scene(self.pose)?).to_array();
            Some(ModelPoint { at, triangle: held_triangle(anchor, &self.starts) })
        };
        let points = points.iter().filter_map(place).collect();
        let drawing = self.prepared.shot.drawing(self.index, self.prepared.key_frame(layer, time));
        Some(TimedProblem { grid: self.grid.clone(), shape: self.shape(), path: vec![goal], points, drawing, take: 0 })
    }

    /// Returns the layer's triangles and lines in the frame of its box.
    pub(in crate::pipeline) fn shape(&self) -> Shape<3> {
        let mut shape = Shape::default();
        for &part in &self.prepared.assignment.parts_of_layer[self.index] {
            let stiffness = self.prepared.stiffness_of(self.index, part);
            let posed = &self.pose.parts[part];
            let base = shape.points.len() as u32;
            let place = |point: &ScenePoint| self.frame.box_from_scene(point.0.as_dvec3()).to_array();
            shape.points.extend(posed.positions.iter().map(place));
            let source = primitive(&self.prepared.scene, posed);
            for (number, corners) in source.triangles.iter().enumerate().filter(|(_, corners)| stiffness.meets(corners))
            {
                shape.triangles.push(corners.map(|corner| corner + base));
                stiffness.extend((number, corners), &mut shape);
            }
            let lines = source.lines.iter().map(|line| line.iter().map(|vertex| vertex + base).collect());
            shape.strokes.extend(lines);
        }
        let links = self.prepared.links_of(self.index);
        shape.links = links.map(|links| links_of_shape(links, &self.starts));
        shape
    }

    /// Returns the active pins.
    fn pins(&self, targets: &PinTargets) -> Vec<WorldPin> {
        let anchors = self.prepared.anchors_of(self.index).iter().zip(&targets.pins).enumerate();
        anchors.filter_map(|(pin, (anchor, target))| self.pin((pin, anchor), target)).collect()
    }

    fn pin(&self, (pin, anchor): (usize, &PinAnchor), target: &PinTarget) -> Option<WorldPin> {
        let rest = anchor.in_scene(self.pose)?;
        let seen = self.camera.project_exact(rest);
        // A target on the screen is undefined for a point that is not in front of the camera. Offsets need no fading:
        // the nearer the point, the smaller they are in metres.
        let presence = match target.goal {
            Goal::Target(_) => presence(seen.depth, self.camera),
            _ => 1.0,
        };
        let layer = &self.prepared.shot.layers[self.index];
        if presence <= 0.0 || layer.pins[pin].is_muted {
            return None;
        }
        let goal = rest + self.displacement(pin, rest, target.goal)?;
        let reached = self.camera.project_exact(goal);
        let is_in_view = [seen, reached].iter().all(|place| place.w > 0.0 && place.depth >= self.camera.near());
        let [at, to] = [rest, goal].map(|place| self.frame.box_from_scene(place).to_array());
        let region = region(&layer.pins[pin], self.grid.diagonal());
        let (weight, gradient) = (faded_weight(presence * layer.pins[pin].weight), self.gradient(pin, target));
        let triangle = held_triangle(anchor, &self.starts);
        let point = PointPin { weight, gradient, region, triangle, ..PointPin::new(at, to) };
        let [from, towards] =
            [seen, reached].map(|place| if is_in_view { place.point() } else { ScreenPoint::default() });
        let state = PinState { pin, rest: from, target: towards, presence, is_in_view };
        Some(WorldPin { state, in_scene: ScenePin { rest, target: goal }, point })
    }

    /// Returns the displacement of a pin in scene space. That of a mirrored pin is the reflection of that of the pin it
    /// follows.
    fn displacement(&self, pin: usize, rest: DVec3, goal: Goal) -> Option<DVec3> {
        let Some(mirrored) = &self.prepared.mirrored_pins_of(self.index)[pin] else {
            return Some(self.unmirrored(pin, rest, goal));
        };
        let followed = self.unmirrored(pin, mirrored.source.in_scene(self.pose)?, goal);
        Some(mirrored.reflection(self.pose).direction(followed))
    }

    /// Returns the displacement of a point at `rest` by a pin's goal.
    fn unmirrored(&self, pin: usize, rest: DVec3, goal: Goal) -> DVec3 {
        let seen = self.camera.project_exact(rest);
        let layer = &self.prepared.shot.layers[self.index];
        match goal {
            Goal::SceneOffset(offset) => match layer.pins[pin].unit {
                OffsetUnit::Frame => offset.into(),
                OffsetUnit::Box => {
                    let size: [f64; 3] = std::array::from_fn(|axis| self.grid.size(axis));
                    self.frame.axes() * (DVec3::from(offset) * DVec3::from(size))
                }
            },
            Goal::SceneTarget(place) => (DVec3::from(place) - rest) * layer.strength,
            Goal::Offset(offset) => self.camera.scene_from_screen_vector(offset, seen.w.max(0.0)),
            Goal::Target(place) => {
                let across = ScreenVector((place - seen.point()).0 * layer.strength);
                self.camera.scene_from_screen_vector(across, seen.w)
            }
        }
    }

    /// Returns the gradient that a pin prescribes, in the frame of the box, by columns: the images of its axes.
    fn gradient(&self, pin: usize, target: &PinTarget) -> Option<[[f64; 3]; 3]> {
        if target.rotation.is_none() && target.log_scale.is_none() {
            return None;
        }
        let axes = self.frame.axes();
        let mirrored = self.prepared.mirrored_pins_of(self.index)[pin];
        let reflection = mirrored.map(|mirrored| mirrored.reflection(self.pose));
        let mirror = |scene: DMat3| reflection.map_or(scene, |reflection| reflection.gradient(scene));
        let in_box = |scene: DMat3| axes.transpose() * mirror(scene) * axes;
        let rotation = match target.rotation {
            None => DMat3::IDENTITY,
            Some(Rotation::InView(angle)) => {
                let towards = self.camera.scene_from_view().z_axis.truncate();
                in_box(DMat3::from_axis_angle(towards, angle))
            }
            Some(Rotation::Axes([x, y, z])) => {
                let turn = DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
                match self.prepared.shot.layers[self.index].pins[pin].unit {
                    OffsetUnit::Frame => in_box(turn),
                    OffsetUnit::Box if reflection.is_none() => turn,
                    OffsetUnit::Box => in_box(axes * turn * axes.transpose()),
                }
            }
        };
        Some((rotation * target.log_scale.unwrap_or(0.0).exp()).to_cols_array_2d())
    }
}

/// Returns the positions of a layer's parts in its shape.
fn part_starts(prepared: &PreparedShot, index: usize, pose: &Pose) -> Vec<PartTriangleRanges> {
    let mut count = 0;
    let of_part = |&part: &usize| {
        let stiffness = prepared.stiffness_of(index, part);
        let triangles = primitive(&prepared.scene, &pose.parts[part]).triangles.iter();
        let mut starts = vec![count];
        for corners in triangles {
            count += u32::from(stiffness.meets(corners));
            starts.push(count);
        }
        PartTriangleRanges { part, starts }
    };
    prepared.assignment.parts_of_layer[index].iter().map(of_part).collect()
}
