//! Converts the lattices of a shot to lattice objects placed in its scene, for programs that have such objects (Blender).
//!
//! In: a [`PreparedShot`], a layer, frames. Out: a [`LatticeObject`] that moves every vertex of the layer exactly as
//! pinwarp does, or the reason why none exists.

use crate::export::blender::{BlenderLayer, BlenderMethod, CameraNode, LatticeBlend, LatticeObject, LatticePose};
use crate::lattice::{Basis, Grid, Lattice, SceneLattice, ScreenLattice};
use crate::pipeline::{LayerState, PipelineError, PreparedShot, TimeSample};
use crate::pose::Pose;
use crate::screen::{Camera, Projected, primitive};
use crate::shot::LayerSpace;
use crate::space::ScreenVector;
use glam::{DMat4, DVec3};

/// Maximum relative difference of w between the vertices of a layer that counts as flat.
const FLATNESS: f64 = 1e-6;

/// Distance by which vertices may leave the box and still count as inside, relative to its side.
const BOX_TOLERANCE: f64 = 1e-7;

/// Frames of a layer; `None` where it is not warped.
type Poses = Vec<(i32, Option<LatticePose>)>;

/// The reason why a layer cannot be a lattice object.
type Reason = String;

impl PreparedShot {
    /// Returns the form in which a layer is exported to Blender: a lattice object or baked meshes.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn blender_layer(&self, index: usize, frames: &[i32]) -> Result<BlenderLayer, PipelineError> {
        let name = self.shot.layers[index].name.clone();
        let method = match self.lattice_object(index, frames)? {
            Ok(lattice) => BlenderMethod::Lattice(lattice),
            Err(reason) => BlenderMethod::Baked(reason),
        };
        Ok(BlenderLayer { name, method })
    }

    /// Returns the node of the shot's camera, or that the camera is added.
    #[must_use]
    pub(crate) fn blender_camera(&self) -> CameraNode {
        self.camera_node().map_or(CameraNode::Added, CameraNode::OfScene)
    }

    fn lattice_object(&self, index: usize, frames: &[i32]) -> Result<Result<LatticeObject, Reason>, PipelineError> {
        if self.assignment.is_sharing[index] {
            return Ok(Err(
                "it shares a mesh with another layer or with what rests, and moves its vertices by weights".into(),
            ));
        }
        let mut poses = Poses::new();
        let mut built = None;
        for &frame in frames {
            let sample = self.sample_at(f64::from(frame))?;
            if branches(&sample.layers[index]) {
                return Ok(Err("its lattice branches, and lattice objects do not".into()));
            }
            let Some((basis, dims)) = built_of(&sample.layers[index]) else {
                poses.push((frame, None));
                continue;
            };
            match blend_of(basis) {
                Ok(blend) => built = Some((blend, dims)),
                Err(reason) => return Ok(Err(reason)),
            }
            match self.lattice_pose(&sample, index) {
                Ok(pose) => poses.push((frame, pose)),
                Err(reason) => return Ok(Err(format!("in frame {frame} {reason}"))),
            }
        }
        let still = || "it is not warped in any of the frames".to_owned();
        let Some((blend, dims)) = built else { return Ok(Err(still())) };
        let mut nodes: Vec<usize> =
            self.assignment.parts_of_layer[index].iter().map(|&part| self.assignment.node_of_part[part]).collect();
        nodes.dedup();
        Ok(filled(poses, dims).map(|frames| LatticeObject { nodes, dims, blend, frames }).ok_or_else(still))
    }

    fn lattice_pose(&self, sample: &TimeSample, index: usize) -> Result<Option<LatticePose>, Reason> {
        let frame = sample.frame as i32;
        match (self.shot.layers[index].space, &sample.layers[index]) {
            (LayerSpace::World { .. }, state) => {
                let Some(world) = &state.world else { return Ok(None) };
                let (rest, _) = self.view(sample.frame);
                self.all_inside(&rest, index, &world.lattice)?;
                Ok(Some(world_pose(frame, &world.lattice)))
            }
            (LayerSpace::Screen { .. }, state) => {
                let Some(solution) = &state.solution else { return Ok(None) };
                let corners = self.corners_seen(sample, index);
                let Some(&(anchor, seen)) = corners.first() else { return Ok(None) };
                check_flat(&corners, &solution.lattice.grid)?;
                Ok(Some(card_pose(frame, &solution.lattice, (&sample.camera, anchor, seen))))
            }
        }
    }

    fn all_inside(&self, rest: &Pose, index: usize, lattice: &SceneLattice) -> Result<(), Reason> {
        let grid = &lattice.lattice.grid;
        for &part in &self.assignment.parts_of_layer[index] {
            let posed = &rest.parts[part];
            let source = primitive(&self.scene, posed);
            let mut corners = source.triangles.iter().flatten().chain(source.lines.iter().flatten());
            let place = |corner: u32| lattice.frame.box_from_scene(posed.positions[corner as usize].0.as_dvec3());
            if corners.any(|&corner| !is_inside(grid, place(corner).to_array())) {
                return Err(
                    "some vertices lie outside the lattice's box, where pinwarp's lattice extrapolates rigidly".into(),
                );
            }
        }
        Ok(())
    }

    /// Returns positions of a layer's drawn vertices in the scene and on the screen.
    fn corners_seen(&self, sample: &TimeSample, index: usize) -> Vec<(DVec3, Projected)> {
        let of_part = |&part: &usize| {
            let posed = &sample.pose.parts[part];
            let source = primitive(&self.scene, posed);
            let corners = source.triangles.iter().flatten().chain(source.lines.iter().flatten());
            let places = corners.map(|&corner| corner as usize).map(move |corner| {
                (posed.positions[corner].0.as_dvec3(), sample.camera.project(posed.positions[corner]))
            });
            places.collect::<Vec<_>>()
        };
        self.assignment.parts_of_layer[index].iter().flat_map(of_part).collect()
    }
}

/// Whether a layer's lattice has several branches.
fn branches(state: &LayerState) -> bool {
    let on_screen = state.solution.as_ref().is_some_and(|solution| solution.branches.is_some());
    on_screen || state.world.as_ref().is_some_and(|world| world.branches.is_some())
}

/// Returns the basis and the number of handles along each axis of a layer's lattice; `None` if the layer is not warped.
fn built_of(state: &LayerState) -> Option<(Basis, [usize; 3])> {
    let on_screen = state.solution.as_ref().map(|solution| &solution.lattice.grid);
    let in_scene = state.world.as_ref().map(|world| &world.lattice.lattice.grid);
    let flat = on_screen.map(|grid| (grid.basis, [grid.dims[0], grid.dims[1], 1]));
    flat.or(in_scene.map(|grid| (grid.basis, grid.dims)))
}

fn blend_of(basis: Basis) -> Result<LatticeBlend, Reason> {
    match basis {
        Basis::Bspline => Ok(LatticeBlend::Bspline),
        Basis::Bilinear => Ok(LatticeBlend::Linear),
        Basis::Bernstein => Err("Blender's lattices do not support Bernstein polynomials".to_owned()),
        Basis::Barytri => Err("Blender's lattices do not support barycentric cells".to_owned()),
    }
}

/// Fills frames without a warp with a lattice at rest at the placement of the previous frame, or of the first warped one.
fn filled(poses: Poses, dims: [usize; 3]) -> Option<Vec<LatticePose>> {
    let mut last = poses.iter().find_map(|(_, pose)| pose.as_ref()).map(|pose| pose.scene_from_lattice)?;
    let count = dims.iter().product();
    let fill = |(frame, pose): (i32, Option<LatticePose>)| {
        let pose =
            pose.unwrap_or_else(|| LatticePose { frame, scene_from_lattice: last, moved: vec![[0.0; 3]; count] });
        last = pose.scene_from_lattice;
        pose
    };
    Some(poses.into_iter().map(fill).collect())
}

fn is_inside<const D: usize>(grid: &Grid<D>, point: [f64; D]) -> bool {
    let point = grid.upright_from_point(point);
    (0..D).all(|axis| {
        let slack = BOX_TOLERANCE * grid.size(axis);
        (grid.lo[axis] - slack..=grid.hi[axis] + slack).contains(&point[axis])
    })
}

/// Checks that a screen lattice is equivalent to a lattice in the scene: a shift on the screen must be the same shift
/// of every vertex in the scene.
fn check_flat(corners: &[(DVec3, Projected)], grid: &Grid<2>) -> Result<(), Reason> {
    let ws = || corners.iter().map(|(_, seen)| seen.w);
    let (least, most) = (ws().fold(f64::INFINITY, f64::min), ws().fold(f64::NEG_INFINITY, f64::max));
    if least <= 0.0 || most - least > FLATNESS * most {
        return Err(
            "its vertices stand at several distances from a perspective camera, so no lattice of the scene moves \
                    them as one of the screen does"
                .into(),
        );
    }
    if corners.iter().any(|(_, seen)| !is_inside(grid, seen.point().0.to_array())) {
        return Err("some vertices lie outside the lattice's box, where pinwarp's lattice extrapolates rigidly".into());
    }
    Ok(())
}

/// Returns the distance between the first and the last handle of an axis, relative to the box: the outermost handles of
/// a B-spline lie outside the box.
fn handle_extent(basis: Basis, count: usize) -> f64 {
    (count - 1) as f64 / basis.spans(count) as f64
}

fn extents<const D: usize>(grid: &Grid<D>) -> [f64; D] {
    std::array::from_fn(|axis| grid.size(axis) * handle_extent(grid.basis, grid.dims[axis]))
}

/// Returns the displacements of the handles from rest, relative to the size of the lattice.
fn moved<const D: usize>(lattice: &Lattice<D>) -> Vec<[f64; 3]> {
    let extents = extents(&lattice.grid);
    let rest = lattice.grid.at_rest().handles;
    let of_handle = |(handle, rest): (&[f64; D], &[f64; D])| {
        let by = lattice.grid.rotated_back(std::array::from_fn(|axis| handle[axis] - rest[axis]));
        std::array::from_fn(|axis| if axis < D { by[axis] / extents[axis] } else { 0.0 })
    };
    lattice.handles.iter().zip(&rest).map(of_handle).collect()
}

fn world_pose(frame: i32, placed: &SceneLattice) -> LatticePose {
    let grid = &placed.lattice.grid;
    let center = DVec3::from(std::array::from_fn(|axis| 0.5 * (grid.lo[axis] + grid.hi[axis])));
    let [x, y, z] = extents(grid);
    let axes = placed.frame.axes();
    let columns = [axes.x_axis * x, axes.y_axis * y, axes.z_axis * z];
    let scene_from_lattice = affine(columns, placed.frame.scene_from_box(center));
    LatticePose { frame, scene_from_lattice, moved: moved(&placed.lattice) }
}

/// Returns the lattice of a flat layer: in the plane parallel to the image plane through `anchor`, which projects to `seen`.
fn card_pose(frame: i32, lattice: &ScreenLattice, (camera, anchor, seen): (&Camera, DVec3, Projected)) -> LatticePose {
    let grid = &lattice.grid;
    let across = |x: f64, y: f64| camera.scene_from_screen_vector(ScreenVector::new(x, y), seen.w);
    let [width, height] = extents(grid);
    let [right, up] = [[width, 0.0], [0.0, height]].map(|side| grid.rotated(side));
    let center = [0, 1].map(|axis| 0.5 * (grid.lo[axis] + grid.hi[axis]));
    let at = seen.point().0;
    let origin = anchor + across(center[0] - at.x, center[1] - at.y);
    let columns = [across(right[0], right[1]), across(up[0], up[1]), camera.towards_viewer().as_dvec3()];
    LatticePose { frame, scene_from_lattice: affine(columns, origin), moved: moved(lattice) }
}

fn affine([x, y, z]: [DVec3; 3], origin: DVec3) -> DMat4 {
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), origin.extend(1.0))
}
