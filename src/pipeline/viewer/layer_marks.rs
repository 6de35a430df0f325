//! Overlay marks for viewers of a solved frame: lines of lattices, handles, folded cells, pins.
//!
//! In: a solved [`TimeSample`]. Out: points of the screen, grouped by layer.

use super::folded_model_cells::folded_model_cells;
use super::folded_outlines::PIECES;
use super::scene_lines::{faces, in_view, lines};
use crate::lattice::{Grid, SceneLattice, ScreenLattice};
use crate::pipeline::evaluate::lattice_box::{screen_box, world_grid};
use crate::pipeline::evaluate::layer_pins::region;
use crate::pipeline::evaluate::world_layer::WorldLayer;
use crate::pipeline::{LayerState, PinState, PreparedShot, TimeSample, WorldSolution};
use crate::screen::Camera;
use crate::shot::{Goal, LayerSpace, OffsetUnit, PinKey, Rotation};
use crate::space::{RotatedBox, ScreenPoint, ScreenVector};
use glam::{DMat3, DVec2, DVec3};

/// Line segments of the rim of a region.
const RIM_PIECES: usize = 48;

/// The marks of one layer.
#[derive(Clone, Debug, Default)]
pub(crate) struct LayerMarks {
    /// Index of the layer in the shot.
    pub layer: usize,
    /// Lines of the warped lattice.
    pub lines: Vec<Vec<ScreenPoint>>,
    /// Warped handles; `None` if behind the camera.
    pub handles: Vec<Option<ScreenPoint>>,
    /// Outlines of folded cells that contain part of the model; in the scene those of the faces around them.
    pub folded: Vec<Vec<ScreenPoint>>,
    /// World layers, one per handle: how its offset, in sizes of the box, changes for a frame height to the right and one up on
    /// the screen, at constant depth.
    pub handle_steps: Vec<[DVec3; 2]>,
    /// The rest box of a screen layer's lattice.
    pub rest_box: Option<RotatedBox>,
    /// The rest box of a world layer's lattice, as lower and upper corner of the box around it along the axes of the scene, metres.
    pub scene_box: Option<[[f64; 3]; 2]>,
    /// The active pins.
    pub pins: Vec<PinMark>,
    /// Distortion at the points of each line: ratio of the singular values of the warp's gradient, largest to smallest.
    pub distortion: Vec<Vec<f64>>,
}

/// A pin in a frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PinMark {
    /// Index in the layer.
    pub pin: usize,
    /// Position of the pinned point before the warp.
    pub rest: ScreenPoint,
    /// Target position.
    pub target: ScreenPoint,
    /// Rim of the pin's region, warped by the lattice; empty if the pin has no region.
    pub rim: Vec<ScreenPoint>,
    /// World layers: how the target, in metres or, if the pin's unit is the box, in sizes of the box, changes for a frame height
    /// to the right and one up on the screen, at constant depth.
    pub steps: Option<[DVec3; 2]>,
    /// The length of a frame height at the depth of the pinned point, metres; `None` for points of the screen.
    pub metres_per_height: Option<f64>,
    /// Pins that turn about three axes of the scene: the axes of their angles in view space (rightwards, upwards, towards the viewer),
    /// each as the angles after it have turned it.
    pub turn_axes: Option<[DVec3; 3]>,
}

/// Returns the marks of all warped layers of a solved frame.
#[must_use]
pub(crate) fn layer_marks(prepared: &PreparedShot, sample: &TimeSample) -> Vec<LayerMarks> {
    let marks = |(layer, state): (usize, &LayerState)| {
        let marks = LayerMarks { layer, ..LayerMarks::default() };
        let marks = match (&state.solution, &state.world) {
            (Some(solution), _) => {
                let folded = prepared.folded_outlines((sample, layer), solution);
                of_screen(marks, &solution.lattice, folded)
            }
            (None, Some(world)) => {
                let folded = folded_faces(prepared, sample, (layer, world));
                LayerMarks { folded, ..of_scene(marks, &world.lattice, &sample.camera) }
            }
            (None, None) => return None,
        };
        let lattice = state.solution.as_ref().map(|solution| &solution.lattice);
        let pins = state.pins.iter().enumerate().filter(|(_, pin)| pin.is_in_view);
        let own_steps = |place: usize, pin: usize| {
            let world = state.world.as_ref()?;
            let unit = prepared.shot.layers[layer].pins[pin].unit;
            Some(pin_steps(&world.lattice, &sample.camera, (world.pins.get(place)?.target, unit)))
        };
        let metres = |pin: usize| {
            let anchor = prepared.anchors_of(layer).get(pin)?;
            Some(steps(&sample.camera, anchor.in_scene(&sample.pose)?)[1].length())
        };
        let pin = |(place, state): (usize, &PinState)| PinMark {
            pin: state.pin,
            rest: state.rest,
            target: state.target,
            rim: lattice.map(|lattice| rim(prepared, (layer, state), lattice)).unwrap_or_default(),
            steps: own_steps(place, state.pin),
            metres_per_height: metres(state.pin),
            turn_axes: state_axes(prepared, sample, [layer, state.pin]),
        };
        Some(LayerMarks { pins: pins.map(pin).collect(), ..marks })
    };
    sample.layers.iter().enumerate().filter_map(marks).collect()
}

/// Returns the marks of layers that are not warped: their lattices at rest.
#[must_use]
pub(crate) fn resting_marks(prepared: &PreparedShot, sample: &TimeSample) -> Vec<LayerMarks> {
    let is_resting = |(_, state): &(usize, &LayerState)| state.solution.is_none() && state.world.is_none();
    let marks = |(layer, _): (usize, &LayerState)| {
        let marks = LayerMarks { layer, ..LayerMarks::default() };
        if let Some((frame, grid)) = world_grid(prepared, layer, sample.frame, &sample.pose) {
            let lattice = SceneLattice { frame, lattice: grid.at_rest() };
            return Some(of_scene(marks, &lattice, &sample.camera));
        }
        Some(of_screen(marks, &resting(prepared, sample, layer)?, Vec::new()))
    };
    sample.layers.iter().enumerate().filter(is_resting).filter_map(marks).collect()
}

/// Returns the rest lattice of a screen layer that is not warped.
fn resting(prepared: &PreparedShot, sample: &TimeSample, index: usize) -> Option<ScreenLattice> {
    let layer = &prepared.shot.layers[index];
    let LayerSpace::Screen { dims, bounds } = layer.space else { return None };
    Some(Grid::over(screen_box(prepared, sample, index, bounds)?, dims, layer.basis).at_rest())
}

fn rim(prepared: &PreparedShot, (layer, state): (usize, &PinState), lattice: &ScreenLattice) -> Vec<ScreenPoint> {
    let pin = &prepared.shot.layers[layer].pins[state.pin];
    let Some(region) = region(pin, lattice.grid.diagonal()) else { return Vec::new() };
    let turn = |k: usize| k as f64 / RIM_PIECES as f64 * std::f64::consts::TAU;
    let around = |k: usize| ScreenPoint(state.rest.0 + region.radius * DVec2::from_angle(turn(k)));
    (0..=RIM_PIECES).map(|k| lattice.warp(around(k))).collect()
}

fn of_screen(marks: LayerMarks, lattice: &ScreenLattice, folded: Vec<Vec<ScreenPoint>>) -> LayerMarks {
    let grid = &lattice.grid;
    let spans = grid.dims.map(|count| grid.basis.spans(count));
    let at = |cells: [f64; 2]| ScreenPoint(lattice.grid.point_from_spans(cells).into());
    let mut lines = Vec::new();
    for along in 0..2 {
        for line in 0..=spans[1 - along] {
            let place = |step: usize| {
                let mut place = [0.0; 2];
                place[along] = step as f64 / PIECES as f64;
                place[1 - along] = line as f64;
                at(place)
            };
            lines.push((0..=spans[along] * PIECES).map(place).collect::<Vec<_>>());
        }
    }
    LayerMarks {
        distortion: lines.iter().map(|line| line.iter().map(|&point| stretch(lattice, point)).collect()).collect(),
        lines: lines.iter().map(|line| line.iter().map(|&point| lattice.warp(point)).collect()).collect(),
        handles: lattice.handles.iter().map(|&[x, y]| Some(ScreenPoint::new(x, y))).collect(),
        folded,
        rest_box: Some(grid.bounds()),
        ..marks
    }
}

/// Returns the warped outlines of the faces around the cells in which the model folds.
fn folded_faces(
    prepared: &PreparedShot,
    sample: &TimeSample,
    (layer, world): (usize, &WorldSolution),
) -> Vec<Vec<ScreenPoint>> {
    if world.report.folded_model_cells == 0 {
        return Vec::new();
    }
    let camera = &sample.camera;
    let Some(branches) = &world.branches else {
        let shape = || {
            // The pose of the sample is deformed already.
            let (pose, camera) = prepared.view_of_positions(sample.frame);
            WorldLayer::at(prepared, layer, sample.frame, (&pose, &camera)).map(|own| own.shape()).unwrap_or_default()
        };
        return faces(&world.lattice, &folded_model_cells(&world.lattice.lattice, shape), camera);
    };
    let of_branch = |branch: usize| {
        let placed = SceneLattice { frame: world.lattice.frame, lattice: branches.lattice(branch) };
        faces(&placed, &branches.folds_of(branch).cells, camera)
    };
    (0..branches.branch_count()).flat_map(of_branch).collect()
}

/// Returns the ratio of the warp gradient's singular values, largest to smallest; 1 where there is no distortion.
fn stretch(lattice: &ScreenLattice, point: ScreenPoint) -> f64 {
    let gradient = lattice.jacobian(point);
    let square = gradient.transpose() * gradient;
    let (mean, half) = (0.5 * (square.x_axis.x + square.y_axis.y), 0.5 * (square.x_axis.x - square.y_axis.y));
    let apart = half.hypot(square.x_axis.y);
    ((mean + apart) / (mean - apart).max(1e-12)).max(1.0).sqrt()
}

fn of_scene(marks: LayerMarks, placed: &SceneLattice, camera: &Camera) -> LayerMarks {
    let SceneLattice { frame, lattice } = placed;
    let (lines, distortion) = lines(placed, camera);
    let places = || lattice.handles.iter().map(|&handle| frame.scene_from_box(handle.into()));
    let handle_steps = places().map(|place| in_box(placed, steps(camera, place))).collect();
    let handles = places().map(|place| in_view(camera, place)).collect();
    LayerMarks { lines, distortion, handles, handle_steps, scene_box: Some(bounds(placed)), ..marks }
}

/// Returns the corners of the box along the axes of the scene around the rest box of a lattice.
fn bounds(placed: &SceneLattice) -> [[f64; 3]; 2] {
    let ends = [placed.lattice.grid.lo, placed.lattice.grid.hi];
    let corner =
        |k: usize| placed.frame.scene_from_box(DVec3::from_array([0, 1, 2].map(|axis| ends[k >> axis & 1][axis])));
    let [mut low, mut high] = [corner(0); 2];
    (1..8).map(corner).for_each(|place| (low, high) = (low.min(place), high.max(place)));
    [low.to_array(), high.to_array()]
}

/// Returns the displacements of a point of the scene, metres, that move it by a frame height to the right and up at constant depth.
fn steps(camera: &Camera, at: DVec3) -> [DVec3; 2] {
    let w = camera.project_exact(at).w;
    [ScreenVector::new(1.0, 0.0), ScreenVector::new(0.0, 1.0)].map(|step| camera.scene_from_screen_vector(step, w))
}

/// Converts vectors of the scene to sizes of a lattice's box, along its axes.
fn in_box(placed: &SceneLattice, vectors: [DVec3; 2]) -> [DVec3; 2] {
    let size = DVec3::from(std::array::from_fn(|axis| placed.lattice.grid.size(axis)));
    vectors.map(|vector| placed.frame.axes().transpose() * vector / size)
}

/// Returns the axes of a pin's three angles in view space; `None` if it has none, and if it turns in the view.
fn state_axes(prepared: &PreparedShot, sample: &TimeSample, [layer, pin]: [usize; 2]) -> Option<[DVec3; 3]> {
    let world = sample.layers[layer].world.as_ref()?;
    let owner = &prepared.shot.layers[layer];
    let own = owner.pins.get(pin)?;
    let has_scene_keys = |key: &PinKey| matches!(key.goal, Goal::SceneOffset(_) | Goal::SceneTarget(_));
    let frame = prepared.key_frame(owner, sample.frame);
    let [_, y, z] = match prepared.shot.pin_targets(layer, frame).pins.get(pin)?.rotation {
        Some(Rotation::Axes(angles)) => angles,
        None if own.keys.iter().all(has_scene_keys) && !own.keys.is_empty() => [0.0; 3],
        Some(Rotation::InView(_)) | None => return None,
    };
    let view_from_scene = DMat3::from_mat4(sample.camera.view_from_scene());
    let view_from_pin = match own.unit {
        OffsetUnit::Frame => view_from_scene,
        OffsetUnit::Box => view_from_scene * world.lattice.frame.axes(),
    };
    let turn_z = view_from_pin * DMat3::from_rotation_z(z);
    Some([turn_z * DMat3::from_rotation_y(y) * DVec3::X, turn_z * DVec3::Y, view_from_pin * DVec3::Z])
}

/// Returns the steps of a pin in its unit.
fn pin_steps(placed: &SceneLattice, camera: &Camera, (target, unit): (DVec3, OffsetUnit)) -> [DVec3; 2] {
    match unit {
        OffsetUnit::Frame => steps(camera, target),
        OffsetUnit::Box => in_box(placed, steps(camera, target)),
    }
}
