//! World layers: solved in the scene before anything is projected; they move the meshes themselves.
//!
//! In: a pose and its camera. Out: the lattice of each world layer, and a [`TimeSample`] whose meshes are moved.

use super::anchors::presence;
use super::lattice_box::world_grid;
use super::layer_pins::{faded_weight, moved_handles, region};
use super::layer_solve::{factor, solve_layer};
use super::moved_meshes::move_meshes;
use super::{LayerState, PinState, PipelineError, PreparedShot, ScenePin, TimeSample, WorldSolution};
use crate::lattice::{BoxFrame, Grid, SceneLattice};
use crate::pose::Pose;
use crate::screen::{Camera, Projected, primitive, project};
use crate::shot::{Goal, OffsetUnit, PinTarget, PinTargets, Rotation};
use crate::solve::{Cancel, PointPin, Shape, Solution, Targets};
use crate::space::{ScenePoint, ScreenPoint, ScreenVector};
use glam::{DMat3, DVec3};

/// A world layer at one time, on its way to be solved.
struct WorldLayer<'a> {
    prepared: &'a PreparedShot,
    pose: &'a Pose,
    camera: &'a Camera,
    index: usize,
    frame: BoxFrame,
    grid: Grid<3>,
}

/// A pin as the solver and as the user sees it.
struct WorldPin {
    state: PinState,
    in_scene: ScenePin,
    point: PointPin<3>,
}

impl PreparedShot {
    /// Poses and projects a (fractional) frame: the layers of the scene are solved, those of the screen are not.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] where a layer of the scene cannot be solved.
    pub fn unsolved_at(&self, frame: f64) -> Result<TimeSample, PipelineError> {
        let (mut pose, camera) = self.view(frame);
        let layers = solve_all(self, frame, &pose, &camera)?;
        move_meshes((&self.scene, &self.assignment), &mut pose, &layers);
        let mesh = Some(project(&pose, &camera));
        Ok(TimeSample { frame, pose, camera, mesh, layers })
    }
}

/// One state a layer: solved where it is a world layer.
fn solve_all(
    prepared: &PreparedShot,
    frame: f64,
    pose: &Pose,
    camera: &Camera,
) -> Result<Vec<LayerState>, PipelineError> {
    let solve = |index: usize| {
        let layer = &prepared.shot.layers[index];
        let is_still = layer.pins.is_empty() && layer.handles.is_empty();
        match world_grid(prepared, index, frame, pose) {
            Some((placed, grid)) if !is_still => {
                WorldLayer { prepared, pose, camera, index, frame: placed, grid }.solve(frame)
            }
            _ => Ok(LayerState::default()),
        }
    };
    (0..prepared.shot.layers.len()).map(solve).collect()
}

impl WorldLayer<'_> {
    fn solve(&self, frame: f64) -> Result<LayerState, PipelineError> {
        let layer = &self.prepared.shot.layers[self.index];
        let targets = self.prepared.shot.pin_targets(self.index, self.prepared.key_frame(layer, frame));
        let pins = self.pins(&targets);
        let points = pins.iter().map(|pin| pin.point).collect();
        let goal = Targets { pins: points, handles: moved_handles(layer, &self.grid, &targets) };
        let fault = |source| PipelineError::Solve { layer: layer.name.clone(), frame, source };
        let never = Cancel::never();
        let solver = factor(&self.grid, || self.shape(), &goal, &layer.settings, &never).map_err(fault)?;
        let Some(solver) = solver else { return Ok(LayerState::default()) };
        let presence = pins.iter().map(|pin| pin.state.presence);
        let Solution { lattice, report, .. } = solve_layer(&solver, &[], &goal, presence, &never).map_err(fault)?;
        let in_scene = pins.iter().map(|pin| pin.in_scene).collect();
        let lattice = SceneLattice { frame: self.frame, lattice };
        let world = Some(WorldSolution { lattice, report, pins: in_scene });
        let pins = pins.into_iter().map(|pin| pin.state).collect();
        Ok(LayerState { world, pins, ..LayerState::default() })
    }

    /// The layer's triangles and lines in the frame of the box.
    fn shape(&self) -> Shape<3> {
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
        shape
    }

    /// The pins that act.
    fn pins(&self, targets: &PinTargets) -> Vec<WorldPin> {
        let anchors = self.prepared.anchors_of(self.index).iter().zip(&targets.pins).enumerate();
        anchors.filter_map(|(pin, (pinned, target))| self.pin(pin, pinned.in_scene(self.pose)?, target)).collect()
    }

    fn pin(&self, pin: usize, rest: DVec3, target: &PinTarget) -> Option<WorldPin> {
        let seen = self.camera.project_exact(rest);
        // A place on the screen says nothing about a point that is not in front of the camera. Offsets fade by
        // themselves: the nearer the point, the fewer metres they are.
        let presence = match target.goal {
            Goal::Target(_) => presence(seen.depth, self.camera),
            _ => 1.0,
        };
        if presence <= 0.0 {
            return None;
        }
        let goal = rest + self.displacement(pin, (rest, seen), target.goal);
        let reached = self.camera.project_exact(goal);
        let is_in_view = [seen, reached].iter().all(|place| place.w > 0.0 && place.depth >= self.camera.near());
        let [at, to] = [rest, goal].map(|place| self.frame.box_from_scene(place).to_array());
        let layer = &self.prepared.shot.layers[self.index];
        let region = region(&layer.pins[pin], self.grid.diagonal());
        let (weight, gradient) = (faded_weight(presence), self.gradient(pin, target));
        let point = PointPin { weight, gradient, region, ..PointPin::new(at, to) };
        let [from, towards] =
            [seen, reached].map(|place| if is_in_view { place.point() } else { ScreenPoint::default() });
        let state = PinState { pin, rest: from, target: towards, presence, is_in_view };
        Some(WorldPin { state, in_scene: ScenePin { rest, target: goal }, point })
    }

    /// How far a pin has to go in scene space.
    fn displacement(&self, pin: usize, (rest, seen): (DVec3, Projected), goal: Goal) -> DVec3 {
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

    /// The gradient a pin holds, in the frame of the box: images of its axes.
    fn gradient(&self, pin: usize, target: &PinTarget) -> Option<[[f64; 3]; 3]> {
        if target.rotation.is_none() && target.log_scale.is_none() {
            return None;
        }
        let axes = self.frame.axes();
        let in_box = |scene: DMat3| axes.transpose() * scene * axes;
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
                    OffsetUnit::Box => turn,
                }
            }
        };
        Some((rotation * target.log_scale.unwrap_or(0.0).exp()).to_cols_array_2d())
    }
}
