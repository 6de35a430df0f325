//! Cuts: frames between which the camera jumps, such as where its keys hold.
//!
//! In: a [`PreparedShot`] and a frame. Out: whether a cut follows it. What is smoothed or coupled over frames stops there.

use crate::pipeline::PreparedShot;
use crate::pipeline::prepare::cameras::CameraSource;
use crate::pose::placed_nodes;
use glam::DQuat;
use std::sync::PoisonError;

/// A cut changes the picture of still meshes at least so much.
const LEAST_CHANGE: f64 = 0.1;

/// A cut changes the picture at least this many times more than the camera's motion before and after it: a fast pan is not a cut.
const RATIO: f64 = 8.0;

/// Largest change of a mesh that counts; also that of a mesh that gets in front of or behind the camera.
const LARGEST_CHANGE: f64 = 2.0;

/// Whether the camera jumps between a frame and the next.
pub(in crate::pipeline) fn is_cut_after(prepared: &PreparedShot, frame: i32) -> bool {
    let can_move = match prepared.camera {
        CameraSource::Automatic(_) => false,
        CameraSource::Node(_) => prepared.clip.clip.is_some(),
        CameraSource::Own { .. } => prepared.has_moving_camera(),
    };
    if !can_move {
        return false;
    }
    let by = known_change(prepared, frame);
    let beside = |step: i32| known_change(prepared, frame.saturating_add(step));
    by >= LEAST_CHANGE && [-1, 1].into_iter().all(|step| by >= RATIO * beside(step))
}

/// Number of cuts from the first frame over which layers are solved to a time, in frames. A time between two frames belongs to the frame before.
pub(in crate::pipeline) fn take_at(prepared: &PreparedShot, time: f64) -> i64 {
    let [first, last] = prepared.shot.solve_range;
    let cuts =
        prepared.cache.cuts.get_or_init(|| (first..last).filter(|&frame| is_cut_after(prepared, frame)).collect());
    cuts.partition_point(|&frame| f64::from(frame) + 1.0 <= time) as i64
}

/// Returns a time of a frame's exposure, moved to the frame if a cut lies between: the shutter never sees two takes. A camera that moves
/// within the frame of its cut, as baked ones do, is not seen there either.
pub(in crate::pipeline) fn exposure_time(prepared: &PreparedShot, frame: i32, time: f64) -> f64 {
    let own = f64::from(frame);
    let take = take_at(prepared, own);
    let is_before_cut = time > own && take_at(prepared, time.max(own + 1.0)) > take;
    if is_before_cut || take_at(prepared, time) < take { own } else { time }
}

/// The same as [`picture_change`], computed once per frame.
fn known_change(prepared: &PreparedShot, frame: i32) -> f64 {
    let known = || prepared.cache.picture_changes.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(&change) = known().get(&frame) {
        return change;
    }
    let change = picture_change(prepared, frame);
    known().insert(frame, change);
    change
}

/// How much the camera's motion from a frame to the next changes the picture of still meshes, on average: the move of their origins in
/// frame heights, the logarithm of their size, and the rotation of the camera in radians.
fn picture_change(prepared: &PreparedShot, frame: i32) -> f64 {
    let [(from, now), (to, _)] = [frame, frame.saturating_add(1)].map(|frame| {
        let pose = placed_nodes(&prepared.scene, prepared.clip, prepared.shot.frames.seconds(f64::from(frame)));
        (prepared.camera.at((&prepared.shot, &prepared.scene), f64::from(frame), &pose), pose)
    });
    let [a, b] = [&from, &to].map(|camera| DQuat::from_mat4(&camera.scene_from_view()));
    let rotation = a.angle_between(b);
    let of_node = |&node: &usize| {
        let origin = now.scene_from_node[node].w_axis.truncate().as_dvec3();
        let [a, b] = [&from, &to].map(|camera| {
            let seen = camera.project_exact(origin);
            (seen.w > 0.0).then(|| (seen.point().0, camera.frame_height_at(seen.w)))
        });
        match (a, b) {
            (Some((a, size)), Some((b, next))) => (a.distance(b) + (next / size).ln().abs()).min(LARGEST_CHANGE),
            (None, None) => 0.0,
            _ => LARGEST_CHANGE,
        }
    };
    let nodes = &prepared.assignment.node_of_part;
    rotation + nodes.iter().map(of_node).sum::<f64>() / nodes.len().max(1) as f64
}
