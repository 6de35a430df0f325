//! Evaluation of animation tracks at one time.
//!
//! In: a clip and seconds in it. Out: the transform and morph weights of every node. Computed in f64.

use crate::scene::{Clip, Interpolation, Placement, Scene, Track, TrackValues};
use glam::{DMat4, DQuat, DVec3, Quat, Vec3};

/// The nodes of a scene at one time.
pub(super) struct Moved {
    /// #nodes: parent_from_node.
    pub(super) parent_from_node: Vec<DMat4>,
    /// #nodes: morph weights.
    pub(super) weights: Vec<Vec<f64>>,
}

/// A transform that can be interpolated.
#[derive(Clone, Copy)]
enum Local {
    Trs(DVec3, DQuat, DVec3),
    Matrix(DMat4),
}

/// Samples the nodes at `seconds` of `clip`; the rest pose without one.
pub(super) fn sample(scene: &Scene, clip: Option<&Clip>, seconds: f64) -> Moved {
    let mut locals: Vec<Local> = scene.nodes.iter().map(|node| rest(node.rest)).collect();
    let mut weights: Vec<Vec<f64>> =
        scene.nodes.iter().map(|node| node.weights.iter().copied().map(f64::from).collect()).collect();
    for track in clip.into_iter().flat_map(|clip| &clip.tracks) {
        apply(track, &Segment::at(&track.times, seconds), &mut locals[track.node], &mut weights[track.node]);
    }
    Moved { parent_from_node: locals.into_iter().map(matrix).collect(), weights }
}

fn rest(placement: Placement) -> Local {
    match placement {
        Placement::Trs { translation, rotation, scale } => {
            Local::Trs(translation.as_dvec3(), unit(rotation.as_dquat()), scale.as_dvec3())
        }
        Placement::Matrix(matrix) => Local::Matrix(matrix.as_dmat4()),
    }
}

fn matrix(local: Local) -> DMat4 {
    match local {
        Local::Trs(translation, rotation, scale) => {
            DMat4::from_scale_rotation_translation(scale, rotation, translation)
        }
        Local::Matrix(matrix) => matrix,
    }
}

fn apply(track: &Track, segment: &Segment, local: &mut Local, weights: &mut [f64]) {
    let how = track.interpolation;
    if let TrackValues::Weights(values) = &track.values {
        let targets = weights.len();
        for (target, weight) in weights.iter_mut().enumerate() {
            *weight = blend(segment, how, |item| f64::from(values[item * targets + target]), |a, b, t| a + (b - a) * t);
        }
        return;
    }
    // Matrices are never animated: loading decomposed those of animated nodes into TRS.
    let Local::Trs(translation, rotation, scale) = local else { return };
    let vector = |values: &[Vec3]| blend(segment, how, |item| values[item].as_dvec3(), |a, b, t| a.lerp(b, t));
    match &track.values {
        TrackValues::Translation(values) => *translation = vector(values),
        TrackValues::Scale(values) => *scale = vector(values),
        TrackValues::Rotation(values) => *rotation = turn(segment, how, values),
        TrackValues::Weights(_) => {}
    }
}

fn turn(segment: &Segment, how: Interpolation, values: &[Quat]) -> DQuat {
    let key = |item: usize| values[item].as_dquat();
    // `slerp` takes the shorter arc; splines use the stored values as they are.
    unit(blend(segment, how, key, |a, b, t| unit(a).slerp(unit(b), t)))
}

fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length.is_finite() && length > 0.0 { rotation / length } else { DQuat::IDENTITY }
}

/// The position of a time between two keys.
struct Segment {
    /// The key at or before the time; the first key if the time is before all keys.
    key: usize,
    /// Fraction of the way to the next key, 0..1; 0 if the value holds.
    t: f64,
    /// Seconds between the two keys.
    span: f64,
}

impl Segment {
    fn at(times: &[f32], seconds: f64) -> Self {
        let after = times.partition_point(|time| f64::from(*time) <= seconds);
        let hold = |key| Self { key, t: 0.0, span: 0.0 };
        if after == 0 {
            return hold(0);
        }
        if after == times.len() {
            return hold(after - 1);
        }
        let (from, to) = (f64::from(times[after - 1]), f64::from(times[after]));
        Self { key: after - 1, t: (seconds - from) / (to - from), span: to - from }
    }
}

/// Interpolates within a segment; `value` returns stored values by index, `mix` interpolates between two of them.
fn blend<T>(segment: &Segment, how: Interpolation, value: impl Fn(usize) -> T, mix: impl Fn(T, T, f64) -> T) -> T
where
    T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let Segment { key, t, span } = *segment;
    match how {
        Interpolation::Step => value(key),
        Interpolation::Linear if t > 0.0 => mix(value(key), value(key + 1), t),
        Interpolation::Linear => value(key),
        // Three values per key: in-tangent, value, out-tangent.
        Interpolation::CubicSpline if t > 0.0 => {
            // The Hermite form of glTF 2.0, appendix C.5; tangents are per second.
            let (t2, t3) = (t * t, t * t * t);
            value(3 * key + 1) * (2.0 * t3 - 3.0 * t2 + 1.0)
                + value(3 * key + 2) * (span * (t3 - 2.0 * t2 + t))
                + value(3 * key + 4) * (3.0 * t2 - 2.0 * t3)
                + value(3 * key + 3) * (span * (t3 - t2))
        }
        Interpolation::CubicSpline => value(3 * key + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times: &[f32], seconds: f64, how: Interpolation, values: &[f64]) -> f64 {
        blend(&Segment::at(times, seconds), how, |item| values[item], |a, b, t| a + (b - a) * t)
    }

    #[test]
    fn values_hold_outside_their_keys() {
        let times = [1.0, 2.0];
        for how in [Interpolation::Step, Interpolation::Linear] {
            assert_eq!(at(&times, -3.0, how, &[5.0, 7.0]), 5.0);
            assert_eq!(at(&times, 2.0, how, &[5.0, 7.0]), 7.0);
            assert_eq!(at(&times, 9.0, how, &[5.0, 7.0]), 7.0);
        }
        assert_eq!(at(&times, 1.75, Interpolation::Step, &[5.0, 7.0]), 5.0);
        assert_eq!(at(&times, 1.75, Interpolation::Linear, &[5.0, 7.0]), 6.5);
    }

    #[test]
    fn splines_follow_the_hermite_formula() {
        // p0 = 1, out-tangent 2, p1 = 4, in-tangent -1, span 2 s, at a quarter of the way:
        // h00 = .84375, h10 = .140625, h01 = .15625, h11 = -.046875
        let values = [9.0, 1.0, 2.0, -1.0, 4.0, 9.0];
        let expected = 0.84375 + 2.0 * 0.140_625 * 2.0 + 0.15625 * 4.0 + 2.0 * 0.046_875;
        let found = at(&[1.0, 3.0], 1.5, Interpolation::CubicSpline, &values);
        assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
        assert_eq!(at(&[1.0, 3.0], 0.0, Interpolation::CubicSpline, &values), 1.0);
        assert_eq!(at(&[1.0, 3.0], 3.0, Interpolation::CubicSpline, &values), 4.0);
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        let (from, to) = (Quat::from_rotation_z(0.1), -Quat::from_rotation_z(0.5));
        let found = turn(&Segment::at(&[0.0, 1.0], 0.5), Interpolation::Linear, &[from, to]);
        assert!(found.dot(DQuat::from_rotation_z(0.3)).abs() > 1.0 - 1e-9, "{found}");
    }
}
