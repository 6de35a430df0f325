//! Converts the warp of layers to deformed meshes, for programs without compatible lattices.
//!
//! In: a [`PreparedShot`], frames, layers. Out: a [`BakedScene`]: every vertex in the space of its node, frame by frame.

use crate::export::blender::nominal_rate;
use crate::export::gltf::{AddedCamera, BakedNode, BakedPart, BakedScene, BakedShape, NodeMotion, SampledNode};
use crate::pipeline::{PipelineError, PreparedShot, TimeSample};
use crate::pose::{LocalPose, Pose, PosedPart, local_pose};
use crate::raster::geometry::{PartPoint, PartWarp, vertex_triangles};
use crate::scene::{Packed, Primitive};
use crate::screen::{Camera, Projected, primitive};
use crate::space::ScreenVector;
use glam::{DMat3, DMat4, DQuat, DVec3, Vec3, Vec4};
use rayon::prelude::*;

/// Minimum number of vertices per parallel task.
const CHUNK: usize = 2048;

/// How frames of the shot map to times of an exported file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BakeTimes {
    /// The clip keeps its times, delayed if a frame would lie before 0.
    Clip,
    /// Frame N lies at N / rate seconds, so that programs which count frames from 0 show the frame numbers of the shot.
    /// If a frame would lie before 0, all are delayed by whole seconds.
    Frames,
}

/// Returns the number of frames, in whole seconds, by which `first` must be delayed to lie at 0 or later.
fn frames_to_zero(first: i32, rate: f64) -> i32 {
    let second = rate.ceil().max(1.0) as i32;
    let lacking = (-first).max(0);
    (lacking + second - 1) / second * second
}

impl PreparedShot {
    /// Returns the scene with the layers chosen by `includes_layer` as deformed meshes. `on_frame` is called after every frame.
    ///
    /// # Errors
    /// [`PipelineError::Solve`] if a layer cannot be solved.
    pub(crate) fn bake(
        &self,
        frames: &[i32],
        times: BakeTimes,
        includes_layer: impl Fn(usize) -> bool,
        mut on_frame: impl FnMut(i32),
    ) -> Result<BakedScene<'_>, PipelineError> {
        let mut frames = frames.to_vec();
        frames.sort_unstable();
        let layers = || (0..self.shot.layers.len()).filter(|&layer| includes_layer(layer));
        let owned = |part: &usize| layers().any(|layer| self.assignment.parts_of_layer[layer].contains(part));
        let parts: Vec<usize> = (0..self.assignment.layer_of_part.len()).filter(owned).collect();
        let mut nodes = self.at_rest(&parts, frames.first().copied().unwrap_or_default());
        for &frame in frames.iter().filter(|_| !parts.is_empty()) {
            let sample = self.sample_at(f64::from(frame))?;
            let warps = sample.warps(&self.assignment, &includes_layer);
            let mut shapes = parts.iter().map(|&part| {
                let node_from_scene = node_from_scene(&sample.pose, sample.pose.parts[part].node);
                let source = primitive(&self.scene, &sample.pose.parts[part]);
                shape(&sample, (part, &warps[part]), source, node_from_scene)
            });
            nodes.iter_mut().flat_map(|node| &mut node.parts).for_each(|part| part.shapes.extend(shapes.next()));
            on_frame(frame);
        }
        let times_secs = frames.iter().map(|&frame| self.file_secs(frame, &frames, times)).collect();
        let (clip, camera, motion) = (self.clip.clip, self.added_camera(&frames), self.motion(&frames, times));
        Ok(BakedScene { scene: &self.scene, clip, frames, times_secs, motion, nodes, camera })
    }

    /// Removes all meshes that do not belong to a layer from the packed file of the scene.
    pub(crate) fn hide_all_but(&self, layer: usize, packed: &mut Packed) {
        let own = &self.assignment.parts_of_layer[layer];
        let others = self.assignment.node_of_part.iter().enumerate().filter(|(part, _)| !own.contains(part));
        for (_, &node) in others {
            let node = &mut packed.json["nodes"][self.scene.file_from_scene[node]];
            node.as_object_mut().and_then(|node| node.remove("mesh"));
        }
    }

    /// Returns the unwarped vertices in a frame, without shapes yet: one node for each that has any of `parts`.
    fn at_rest(&self, parts: &[usize], frame: i32) -> Vec<BakedNode> {
        let (rest, _) = self.view(f64::from(frame));
        let mut nodes: Vec<BakedNode> = Vec::new();
        for posed in parts.iter().map(|&part| &rest.parts[part]) {
            let source = primitive(&self.scene, posed);
            // Meshes that are only placed by their node keep the values of their file.
            let base = if source.influences.is_empty() && source.targets.is_empty() {
                let (positions, normals) = (source.positions.clone(), source.normals.clone());
                BakedShape { positions, normals, tangents: source.tangents.clone() }
            } else {
                in_node(posed, node_from_scene(&rest, posed.node))
            };
            let part = BakedPart { primitive: posed.primitive, base, shapes: Vec::new() };
            match nodes.last_mut() {
                Some(last) if last.node == posed.node => last.parts.push(part),
                _ => nodes.push(BakedNode { node: posed.node, parts: vec![part] }),
            }
        }
        nodes
    }

    /// Returns the time of a frame in the exported file, seconds.
    fn file_secs(&self, frame: i32, frames: &[i32], times: BakeTimes) -> f64 {
        match times {
            BakeTimes::Clip => self.shot.frames.seconds(f64::from(frame)) + self.shift_secs(frames),
            BakeTimes::Frames => f64::from(frame + self.file_frames(frames)) / nominal_rate(self.shot.frames.rate),
        }
    }

    /// Returns the delay of a clip relative to its own file that puts no frame before 0, seconds.
    fn shift_secs(&self, frames: &[i32]) -> f64 {
        let first = frames.first().copied().unwrap_or_default();
        (-self.shot.frames.seconds(f64::from(first))).max(0.0)
    }

    /// Returns the delay of a file with [`BakeTimes::Frames`] relative to the shot, in frames; 0 if all its frames are 0 or later.
    #[must_use]
    pub(crate) fn file_frames(&self, frames: &[i32]) -> i32 {
        let first = frames.iter().copied().min().unwrap_or_default();
        frames_to_zero(first, self.shot.frames.rate)
    }

    /// Returns the node animation: the clip's own keys if the file can play them unchanged, sampled poses otherwise
    /// (for example for a looped clip).
    fn motion(&self, frames: &[i32], times: BakeTimes) -> NodeMotion {
        if times == BakeTimes::Clip && !self.clip.is_looped {
            return NodeMotion::Keys { shift_secs: self.shift_secs(frames) };
        }
        let clip = self.clip.clip.and_then(|clip| self.scene.clips.get(clip));
        let mut moving: Vec<usize> = clip.iter().flat_map(|clip| &clip.tracks).map(|track| track.node).collect();
        moving.sort_unstable();
        moving.dedup();
        let seconds = |&frame: &i32| self.shot.frames.seconds(f64::from(frame));
        let poses: Vec<LocalPose> =
            frames.iter().map(seconds).map(|seconds| local_pose(&self.scene, self.clip, seconds)).collect();
        NodeMotion::Sampled(moving.into_iter().map(|node| sampled(node, &poses)).collect())
    }

    /// Returns the camera to add, if the shot's camera is not a node of the file.
    fn added_camera(&self, frames: &[i32]) -> Option<AddedCamera> {
        if self.camera_node().is_some() {
            return None;
        }
        let at = |frame: i32| self.view(f64::from(frame)).1;
        let camera = at(frames.first().copied().unwrap_or(self.shot.frames.first));
        let moving = if self.has_moving_camera() { frames } else { &[] };
        Some(AddedCamera {
            scene_from_camera: camera.scene_from_view().as_mat4(),
            lens: camera.lens(),
            near: camera.near() as f32,
            motion: moving.iter().map(|&frame| at(frame).scene_from_view().as_mat4()).collect(),
        })
    }
}

/// Samples the local transform and morph weights of a node at the given poses, with continuous quaternion signs.
fn sampled(node: usize, poses: &[LocalPose]) -> SampledNode {
    let mut sampled = SampledNode { node, translations: vec![], rotations: vec![], scales: vec![], weights: vec![] };
    let mut last = DQuat::IDENTITY;
    for pose in poses {
        let (scale, rotation, translation) = pose.parent_from_node[node].to_scale_rotation_translation();
        last = if rotation.dot(last) < 0.0 { -rotation } else { rotation };
        sampled.translations.push(translation.as_vec3());
        sampled.rotations.push(Vec4::from(last.as_quat()));
        sampled.scales.push(scale.as_vec3());
        sampled.weights.extend(pose.weights[node].iter().map(|&weight| weight as f32));
    }
    sampled
}

/// Returns the inverse of a node's placement; `None` if the node is scaled to zero along an axis and thus invisible.
fn node_from_scene(pose: &Pose, node: usize) -> Option<DMat4> {
    let placed = pose.scene_from_node[node].as_dmat4();
    let is_invertible = placed.determinant().abs() > f64::MIN_POSITIVE;
    is_invertible.then(|| placed.inverse())
}

/// Transforms a part to the space of its node.
fn in_node(posed: &PosedPart, node_from_scene: Option<DMat4>) -> BakedShape {
    let Some(node_from_scene) = node_from_scene else {
        let (positions, normals) = (vec![Vec3::ZERO; posed.positions.len()], vec![Vec3::Z; posed.positions.len()]);
        return BakedShape { positions, normals, tangents: posed.tangents.clone() };
    };
    let place = |point: DVec3| node_from_scene.transform_point3(point).as_vec3();
    let linear = DMat3::from_mat4(node_from_scene);
    // Scene normals are node normals times the inverse transpose of the placement P, so the way back is Pᵀ.
    let turned = |by: DMat3, direction: Vec3| (by * direction.as_dvec3()).try_normalize().unwrap_or(DVec3::Z).as_vec3();
    let back = linear.inverse().transpose();
    let side = linear.determinant().signum() as f32;
    let tangent = |tangent: &Vec4| turned(linear, tangent.truncate()).extend(tangent.w * side);
    BakedShape {
        positions: posed.positions.par_iter().with_min_len(CHUNK).map(|point| place(point.0.as_dvec3())).collect(),
        normals: posed.normals.par_iter().with_min_len(CHUNK).map(|normal| turned(back, normal.0)).collect(),
        tangents: posed.tangents.iter().map(tangent).collect(),
    }
}

/// Returns a warped part at one time, in the space of its node.
///
/// World layers have already deformed the pose. Screen layers move each vertex parallel to the image plane at its own
/// depth, so that it projects to the point where the lattice puts it.
fn shape(
    sample: &TimeSample,
    (part, warp): (usize, &PartWarp),
    source: &Primitive,
    node_from_scene: Option<DMat4>,
) -> BakedShape {
    let mut baked = in_node(&sample.pose.parts[part], node_from_scene);
    if let Some(node_from_scene) = node_from_scene.filter(|_| !warp.is_rest()) {
        let scene_points = &sample.pose.parts[part].positions;
        let triangles = if warp.has_branches() { vertex_triangles(source) } else { Vec::new() };
        let on = |vertex: usize| PartPoint {
            weights: warp.weights_of(vertex),
            triangle: triangles.get(vertex).copied().unwrap_or_default(),
        };
        baked.positions.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(vertex, position)| {
            let by = across(&sample.camera, (warp, on(vertex)), sample.camera.project(scene_points[vertex]));
            let moved = scene_points[vertex].0.as_dvec3() + by;
            *position = node_from_scene.transform_point3(moved).as_vec3();
        });
    }
    baked
}

/// Returns the displacement in the scene by which a screen warp moves a vertex at its depth; zero behind the camera.
fn across(camera: &Camera, (warp, on): (&PartWarp, PartPoint), seen: Projected) -> DVec3 {
    if seen.w <= 0.0 {
        return DVec3::ZERO;
    }
    let by: ScreenVector = warp.warp(seen.point(), on) - seen.point();
    camera.scene_from_screen_vector(by, seen.w)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_count_frames_from_zero() {
        assert_eq!([0, 7, -1, -24, -25].map(|first| frames_to_zero(first, 24.0)), [0, 0, 24, 24, 48]);
    }
}
