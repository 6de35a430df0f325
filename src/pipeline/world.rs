//! World layers: solved in the scene before anything is projected; they move the meshes themselves.
//!
//! In: a pose and its camera. Out: the lattice of each world layer, and the pose with its meshes moved.

use super::anchors::presence;
use super::follow::{Bounds, FollowWindow, thickened, union};
use super::layer_pins::{fade, faded_weight, moved_handles, region};
use super::{LayerState, PinState, PipelineError, Setup};
use crate::lattice::{BoxFrame, Grid, SceneLattice};
use crate::pose::{Pose, PosedPart};
use crate::screen::{Camera, Projected, primitive};
use crate::shot::{Goal, LayerSpace, OffsetUnit, PinTarget, PinTargets, Rotation, WorldBoxRule};
use crate::solve::{PointPin, Problem, Shape, Solution, SolveReport, Solver};
use crate::space::{ScenePoint, SceneVector, ScreenPoint, ScreenVector};
use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;

/// A followed box is never thinner than this part of its longest side: a flat model keeps cells that can be solved.
const LEAST_SIDE: f64 = 0.25;

/// Nor is a box without any extent, metres.
const LEAST_EXTENT: f64 = 1e-6;

/// Least vertices a thread takes at once.
const CHUNK: usize = 2048;

/// The solved lattice of a world layer.
#[derive(Clone, Debug)]
pub struct WorldSolution {
    /// The lattice.
    pub lattice: SceneLattice,
    /// How good it is; pin errors in metres.
    pub report: SolveReport,
    /// One a pin that acts.
    pub pins: Vec<ScenePin>,
}

/// A pin of a world layer, scene space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScenePin {
    /// Where its point is before the warp.
    pub rest: DVec3,
    /// Where it has to go.
    pub target: DVec3,
}

/// A world layer at one time, on its way to be solved.
struct WorldLayer<'a> {
    setup: &'a Setup,
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

impl Setup {
    /// One a layer: solved where it is a world layer.
    pub(super) fn solve_worlds(
        &self,
        frame: f64,
        pose: &Pose,
        camera: &Camera,
    ) -> Result<Vec<LayerState>, PipelineError> {
        let solve = |index: usize| {
            let layer = &self.shot.layers[index];
            let is_still = layer.pins.is_empty() && layer.handles.is_empty();
            match self.world_grid(index, frame, pose) {
                Some((placed, grid)) if !is_still => {
                    WorldLayer { setup: self, pose, camera, index, frame: placed, grid }.solve(frame)
                }
                _ => Ok(LayerState::default()),
            }
        };
        (0..self.shot.layers.len()).map(solve).collect()
    }

    /// Frame and rest grid of a world layer's lattice; `None` for other layers and where there is nothing to hold.
    pub(super) fn world_grid(&self, index: usize, frame: f64, pose: &Pose) -> Option<(BoxFrame, Grid<3>)> {
        let layer = &self.shot.layers[index];
        let LayerSpace::World { dims, bounds } = layer.space else { return None };
        let (placed, [lo, hi]) = match bounds {
            WorldBoxRule::Fixed(corners) => (BoxFrame::SCENE, corners),
            WorldBoxRule::Follow => {
                let window = FollowWindow::new(frame);
                let at = |frame: i32| (frame, self.world_bounds_at(index, frame));
                let neighbours: Vec<_> = window.frames().map(at).collect();
                let [lo, hi] = window.smooth(&neighbours, self.world_bounds_of(index, pose))?;
                let longest = (0..3).map(|axis| hi[axis] - lo[axis]).fold(0.0, f64::max);
                (self.box_frame(index, pose), thickened([lo, hi], (longest * LEAST_SIDE).max(LEAST_EXTENT)))
            }
        };
        Some((placed, Grid { dims, basis: layer.basis, lo, hi }))
    }

    /// The rigid frame of the node that carries a layer, which its box goes along with.
    fn box_frame(&self, index: usize, pose: &Pose) -> BoxFrame {
        let carrier = self.carriers[index].map(|node| pose.scene_from_node[node].as_dmat4());
        carrier.map_or(BoxFrame::SCENE, BoxFrame::of)
    }

    /// Bounds of a layer's triangles and lines in the frame of its box.
    pub(super) fn world_bounds_of(&self, index: usize, pose: &Pose) -> Option<Bounds<3>> {
        let frame = self.box_frame(index, pose);
        let of_part = |&part: &usize| {
            let posed = &pose.parts[part];
            let source = primitive(&self.scene, posed);
            let corners = source.triangles.iter().flatten().chain(source.lines.iter().flatten());
            let places = corners.map(|&corner| posed.positions[corner as usize].0.as_dvec3());
            let places = places.filter(|place| place.is_finite()).map(|place| frame.box_from_scene(place).to_array());
            places.map(|place| [place; 2]).reduce(union)
        };
        self.parts_of_layer[index].iter().filter_map(of_part).reduce(union)
    }

    /// Moves the meshes of all solved world layers. A surface turns as the lattice does: tangents by its gradient,
    /// normals by the cofactors of it (the inverse transpose, up to a factor that unit length takes away).
    pub(super) fn move_meshes(&self, pose: &mut Pose, layers: &[LayerState]) {
        for (index, state) in layers.iter().enumerate() {
            let Some(world) = &state.world else { continue };
            for &part in &self.parts_of_layer[index] {
                move_part(&mut pose.parts[part], &world.lattice);
            }
        }
    }
}

fn move_part(part: &mut PosedPart, lattice: &SceneLattice) {
    let moved: Vec<(Vec3, DMat3)> = part
        .positions
        .par_iter()
        .with_min_len(CHUNK)
        .map(|point| {
            let (place, gradient) = lattice.warp_with_gradient(point.0.as_dvec3());
            (place.as_vec3(), gradient)
        })
        .collect();
    for (vertex, (place, gradient)) in moved.into_iter().enumerate() {
        part.positions[vertex] = ScenePoint(place);
        if let Some(normal) = part.normals.get_mut(vertex) {
            let [x, y, z] = [gradient.x_axis, gradient.y_axis, gradient.z_axis];
            let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
            *normal = SceneVector(turned(cofactors, normal.0));
        }
        if let Some(tangent) = part.tangents.get_mut(vertex) {
            *tangent = turned(gradient, tangent.truncate()).extend(tangent.w);
        }
    }
}

/// A direction turned; the old one where the lattice squashes it to nothing.
fn turned(by: DMat3, direction: Vec3) -> Vec3 {
    (by * direction.as_dvec3()).try_normalize().map_or(direction, |turned| turned.as_vec3())
}

impl WorldLayer<'_> {
    fn solve(&self, frame: f64) -> Result<LayerState, PipelineError> {
        let layer = &self.setup.shot.layers[self.index];
        let targets = self.setup.shot.pin_targets(self.index, self.setup.key_frame(layer, frame));
        let pins = self.pins(&targets);
        if pins.is_empty() && layer.handles.is_empty() {
            return Ok(LayerState::default());
        }
        let points: Vec<_> = pins.iter().map(|pin| pin.point).collect();
        let (handles, shape) = (moved_handles(layer, &self.grid, &targets), self.shape());
        let problem =
            Problem { grid: &self.grid, shape: &shape, pins: &points, handles: &handles, settings: &layer.settings };
        let solver = Solver::new(&problem).map_err(|source| PipelineError::Solve {
            layer: layer.name.clone(),
            frame,
            source,
        })?;
        let mut solution = solver.solve();
        let presence = pins.iter().map(|pin| pin.state.presence).fold(0.0, f64::max);
        if handles.is_empty() && presence < 1.0 {
            fade(&mut solution, (&solver, &points), presence);
        }
        let Solution { lattice, report } = solution;
        let in_scene = pins.iter().map(|pin| pin.in_scene).collect();
        let lattice = SceneLattice { frame: self.frame, lattice };
        let world = Some(WorldSolution { lattice, report, pins: in_scene });
        let pins = pins.into_iter().map(|pin| pin.state).collect();
        Ok(LayerState { world, pins, ..LayerState::default() })
    }

    /// The layer's triangles and lines in the frame of the box.
    fn shape(&self) -> Shape<3> {
        let mut shape = Shape::default();
        for &part in &self.setup.parts_of_layer[self.index] {
            let posed = &self.pose.parts[part];
            let base = shape.points.len() as u32;
            let place = |point: &ScenePoint| self.frame.box_from_scene(point.0.as_dvec3()).to_array();
            shape.points.extend(posed.positions.iter().map(place));
            let source = primitive(&self.setup.scene, posed);
            for (number, corners) in source.triangles.iter().enumerate() {
                shape.triangles.push(corners.map(|corner| corner + base));
                self.setup.paint(self.index, (part, number), &mut shape);
            }
            let lines = source.lines.iter().map(|line| line.iter().map(|vertex| vertex + base).collect());
            shape.strokes.extend(lines);
        }
        shape
    }

    /// The pins that act.
    fn pins(&self, targets: &PinTargets) -> Vec<WorldPin> {
        let anchors = self.setup.anchors[self.index].iter().zip(&targets.pins).enumerate();
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
        let layer = &self.setup.shot.layers[self.index];
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
        let layer = &self.setup.shot.layers[self.index];
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
                match self.setup.shot.layers[self.index].pins[pin].unit {
                    OffsetUnit::Frame => in_box(turn),
                    OffsetUnit::Box => turn,
                }
            }
        };
        Some((rotation * target.log_scale.unwrap_or(0.0).exp()).to_cols_array_2d())
    }
}
