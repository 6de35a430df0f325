//! Rest boxes of lattices, on the screen and in the scene: fixed, or following the layer's model; upright, or turned with a node.
//!
//! In: a [`PreparedShot`], a layer, a pose. Out: the rest box of the layer's lattice.

use super::camera_cuts::is_cut_after;
use super::followed_box::{Bounds, BoxAxes, SmoothingWindow, thickened, union};
use super::time_sample::TimeSample;
use crate::lattice::{BoxFrame, Grid};
use crate::pipeline::PreparedShot;
use crate::pose::Pose;
use crate::screen::{self, Camera, Extent, ScreenMesh, bounds, primitive, reach_of_frame};
use crate::shot::{BoxOrientation, BoxRule, LayerSpace, WorldBoxRule};
use crate::space::{RotatedBox, ScreenBox, ScreenPoint};

/// Minimum side of a box on the screen, in frame heights.
const MIN_SIDE: f64 = 0.01;

/// Minimum side of a followed box in the scene, relative to its longest side: the cells of a flat model stay solvable.
const MIN_SIDE_RATIO: f64 = 0.25;

/// Minimum side of a box around a model without extent, metres.
const MIN_EXTENT: f64 = 1e-6;

/// Returns the rest box of a screen layer's lattice; `None` if nothing of the layer is in or near the frame.
pub(in crate::pipeline) fn screen_box(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
    rule: BoxRule,
) -> Option<RotatedBox> {
    let axes = box_axes(prepared, index, &sample.pose, &sample.camera);
    match rule {
        BoxRule::Fixed(upright) => Some(RotatedBox { upright, angle: axes.angle }),
        BoxRule::Frame => {
            let corner = ScreenPoint::new(prepared.shot.size.aspect(), 1.0);
            Some(ScreenBox::new(ScreenPoint::default(), corner).into())
        }
        BoxRule::Follow => {
            // Where nothing is near the frame there is nothing to warp: the box of neighbouring frames would not hold the pins.
            let now = screen_bounds(prepared, index, &sample.pose, &sample.mesh(), &sample.camera)?;
            let window = SmoothingWindow::new(sample.frame);
            let at = |frame: i32| (frame, screen_bounds_at(prepared, index, frame));
            let frames = window.frames_without_cut(|frame| is_cut_after(prepared, frame));
            let neighbours: Vec<_> = frames.map(at).collect();
            Some(axes.rotated_box(thickened(window.smooth(&neighbours, Some(now))?, MIN_SIDE)))
        }
    }
}

/// Returns the axes of a screen layer's box: those of the screen, unless the box turns with a node or is rotated.
fn box_axes(prepared: &PreparedShot, index: usize, pose: &Pose, camera: &Camera) -> BoxAxes {
    let BoxOrientation { node, angle } = &prepared.shot.layers[index].orientation;
    let of_node = node.as_ref().and_then(|(name, axis)| {
        let placed = pose.scene_from_node[prepared.scene.node_named(name)?].as_dmat4();
        let origin = placed.w_axis.truncate();
        let seen = camera.project_exact(origin);
        let up = camera.direction_seen(origin, placed.col(*axis).truncate());
        let axes = BoxAxes { origin: seen.point().0, angle: f64::atan2(-up.0.x, up.0.y) };
        (seen.w > 0.0 && axes.origin.is_finite() && axes.angle.is_finite()).then_some(axes)
    });
    let axes = of_node.unwrap_or_default();
    BoxAxes { angle: axes.angle + angle, ..axes }
}

/// Returns the bounds of a layer on the screen along the axes of its box: in the frame of its node if the box turns with one, so that
/// the box of a figure that turns or moves with the node has the same bounds in every frame.
pub(in crate::pipeline) fn screen_bounds(
    prepared: &PreparedShot,
    layer: usize,
    pose: &Pose,
    mesh: &ScreenMesh,
    camera: &Camera,
) -> Option<Bounds<2>> {
    let BoxAxes { origin, angle } = box_axes(prepared, layer, pose, camera);
    let reach = reach_of_frame(prepared.shot.size);
    let counts = |part: usize, corners: &[u32; 3]| prepared.assignment.share(layer, part).meets(corners);
    let parts = &prepared.assignment.parts_of_layer[layer];
    let extent = Extent { parts, counts: &counts, near: camera.near(), reach, origin, angle };
    let bounds = bounds(&prepared.scene, pose, mesh, extent)?;
    Some([bounds.min.0.to_array(), bounds.max.0.to_array()])
}

/// Returns the bounds of a layer on the screen at a whole frame; those of all layers are computed together and cached.
fn screen_bounds_at(prepared: &PreparedShot, layer: usize, frame: i32) -> Option<Bounds<2>> {
    let frame = prepared.same_view(frame);
    prepared.cache.screen_bounds.at(layer, frame, || {
        let (pose, camera) = prepared.view_of_positions(f64::from(frame));
        let mesh = screen::project(&pose, &camera);
        let of_layer = |layer: usize| screen_bounds(prepared, layer, &pose, &mesh, &camera);
        (0..prepared.shot.layers.len()).map(of_layer).collect()
    })
}

/// Returns the coordinate frame and rest grid of a world layer's lattice; `None` for screen layers and for layers without geometry.
pub(in crate::pipeline) fn world_grid(
    prepared: &PreparedShot,
    index: usize,
    frame: f64,
    pose: &Pose,
) -> Option<(BoxFrame, Grid<3>)> {
    let layer = &prepared.shot.layers[index];
    let LayerSpace::World { dims, bounds } = layer.space else { return None };
    let (placed, [lo, hi]) = match bounds {
        WorldBoxRule::Fixed(corners) => (BoxFrame::SCENE, corners),
        WorldBoxRule::Follow => {
            let window = SmoothingWindow::new(frame);
            let at = |frame: i32| (frame, world_bounds_at(prepared, index, frame));
            let neighbours: Vec<_> = window.frames().map(at).collect();
            let [lo, hi] = window.smooth(&neighbours, world_bounds(prepared, index, pose))?;
            let longest = (0..3).map(|axis| hi[axis] - lo[axis]).fold(0.0, f64::max);
            let least = (longest * MIN_SIDE_RATIO).max(MIN_EXTENT);
            (box_frame(prepared, index, pose), thickened([lo, hi], least))
        }
    };
    Some((placed, Grid { dims, basis: layer.basis, lo, hi, angle: 0.0 }))
}

/// Returns the rigid frame of the node that a layer's box follows: the one named, or the one that carries the layer.
fn box_frame(prepared: &PreparedShot, index: usize, pose: &Pose) -> BoxFrame {
    let named = prepared.shot.layers[index].orientation.node.as_ref();
    let named = named.and_then(|(name, _)| prepared.scene.node_named(name));
    let node = named.or(prepared.assignment.carriers[index]);
    node.map(|node| pose.scene_from_node[node].as_dmat4()).map_or(BoxFrame::SCENE, BoxFrame::of)
}

/// Returns the bounds of a layer's triangles and lines in the frame of its box.
fn world_bounds(prepared: &PreparedShot, index: usize, pose: &Pose) -> Option<Bounds<3>> {
    let frame = box_frame(prepared, index, pose);
    let of_part = |&part: &usize| {
        let posed = &pose.parts[part];
        let source = primitive(&prepared.scene, posed);
        let share = prepared.assignment.share(index, part);
        let triangles = source.triangles.iter().filter(|corners| share.meets(corners));
        let corners = triangles.flatten().chain(source.lines.iter().flatten());
        let places = corners.map(|&corner| posed.positions[corner as usize].0.as_dvec3());
        let places = places.filter(|place| place.is_finite()).map(|place| frame.box_from_scene(place).to_array());
        places.map(|place| [place; 2]).reduce(union)
    };
    prepared.assignment.parts_of_layer[index].iter().filter_map(of_part).reduce(union)
}

/// Returns the bounds of a world layer at a whole frame, in the frame of its box; those of all layers are computed
/// together and cached.
fn world_bounds_at(prepared: &PreparedShot, layer: usize, frame: i32) -> Option<Bounds<3>> {
    let frame = prepared.same_view(frame);
    prepared.cache.world_bounds.at(layer, frame, || {
        let (pose, _) = prepared.view_of_positions(f64::from(frame));
        let is_world = |layer: usize| matches!(prepared.shot.layers[layer].space, LayerSpace::World { .. });
        let of_layer = |layer: usize| is_world(layer).then(|| world_bounds(prepared, layer, &pose)).flatten();
        (0..prepared.shot.layers.len()).map(of_layer).collect()
    })
}
