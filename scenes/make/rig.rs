//! The gnome's skeleton, its walk cycle and its joint weights.
//!
//! In: a phase of the walk. Out: joint rotations, and the height of the hips at which the lower foot stands on the
//! ground. At rest all joints are aligned with the axes of the scene; the gnome looks along +z, and its left side is
//! +x.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use std::f64::consts::TAU;

/// A joint at rest.
pub(crate) struct Joint {
    /// Name of its node.
    pub(crate) name: &'static str,
    /// Index of the parent; `None` for the root.
    pub(crate) parent: Option<usize>,
    /// Position of the joint, metres.
    pub(crate) at: DVec3,
    /// End of its bone, metres.
    pub(crate) end: DVec3,
    /// Points closer to the bone than this have its full weight, metres.
    radius: f64,
}

/// Name, parent, and the start, end and radius of the bone.
const fn joint(name: &'static str, parent: Option<usize>, at: [f64; 3], end: [f64; 3], radius: f64) -> Joint {
    Joint { name, parent, at: DVec3::from_array(at), end: DVec3::from_array(end), radius }
}

/// Index of the head.
pub(crate) const HEAD: usize = 3;
/// Index of the tip of the hat.
pub(crate) const HAT: usize = 4;

/// All joints, parents first.
pub(crate) const JOINTS: [Joint; 15] = [
    joint("Hips", None, [0.0, 0.36, 0.0], [0.0, 0.44, 0.0], 0.19),
    joint("Spine", Some(0), [0.0, 0.44, 0.0], [0.0, 0.56, 0.0], 0.19),
    joint("Chest", Some(1), [0.0, 0.56, 0.0], [0.0, 0.66, 0.0], 0.12),
    joint("Head", Some(2), [0.0, 0.68, 0.0], [0.0, 0.98, 0.0], 0.1),
    joint("HatTip", Some(3), [0.0, 1.08, -0.02], [0.0, 1.38, -0.12], 0.1),
    joint("UpperArmLeft", Some(2), [0.155, 0.605, 0.0], [0.275, 0.49, 0.0], 0.07),
    joint("ForearmLeft", Some(5), [0.275, 0.49, 0.0], [0.375, 0.36, 0.03], 0.065),
    joint("UpperArmRight", Some(2), [-0.155, 0.605, 0.0], [-0.275, 0.49, 0.0], 0.07),
    joint("ForearmRight", Some(7), [-0.275, 0.49, 0.0], [-0.375, 0.36, 0.03], 0.065),
    joint("ThighLeft", Some(0), [0.10, 0.33, 0.0], [0.105, 0.20, 0.01], 0.085),
    joint("ShinLeft", Some(9), [0.105, 0.20, 0.01], [0.11, 0.08, 0.0], 0.07),
    joint("FootLeft", Some(10), [0.11, 0.08, 0.0], [0.12, 0.05, 0.11], 0.07),
    joint("ThighRight", Some(0), [-0.10, 0.33, 0.0], [-0.105, 0.20, 0.01], 0.085),
    joint("ShinRight", Some(12), [-0.105, 0.20, 0.01], [-0.11, 0.08, 0.0], 0.07),
    joint("FootRight", Some(13), [-0.11, 0.08, 0.0], [-0.12, 0.05, 0.11], 0.07),
];

/// Points under heel and toe of the left foot, at rest.
const SOLE: [DVec3; 2] = [DVec3::new(0.115, 0.0, -0.05), DVec3::new(0.12, 0.0, 0.13)];

/// Distance that the gnome walks per cycle, metres; it is chosen so that the feet hardly slide.
pub(crate) const STRIDE: f64 = 0.56;

/// The inverse bind matrix of a joint.
pub(crate) fn joint_from_mesh(joint: &Joint) -> DMat4 {
    DMat4::from_translation(-joint.at)
}

/// Translation of a joint relative to its parent, at rest.
pub(crate) fn offset(joint: &Joint) -> DVec3 {
    joint.at - joint.parent.map_or(DVec3::ZERO, |parent| JOINTS[parent].at)
}

/// The pose of the skeleton at one phase of the walk.
pub(crate) struct Stance {
    /// One rotation per joint.
    pub(crate) rotations: [DQuat; JOINTS.len()],
    /// Position of the hips.
    pub(crate) hips: DVec3,
}

fn pitch(degrees: f64) -> DQuat {
    DQuat::from_rotation_x(degrees.to_radians())
}

fn yaw(degrees: f64) -> DQuat {
    DQuat::from_rotation_y(degrees.to_radians())
}

fn roll(degrees: f64) -> DQuat {
    DQuat::from_rotation_z(degrees.to_radians())
}

/// Rotations of thigh, shin and foot of a leg. At phase 0 it is stretched forwards and touches the ground.
fn leg(phase: f64) -> [DQuat; 3] {
    let angle = phase * TAU;
    let lift = (-angle.sin()).max(0.0);
    let forwards = 34.0 * angle.cos() + 10.0 * lift;
    let knee = 6.0 + 62.0 * lift * lift;
    let toe_up = -8.0 + 26.0 * angle.cos();
    [pitch(-forwards), pitch(knee), pitch(forwards - knee - toe_up)]
}

/// Rotations of upper arm and forearm; `side` is 1 for the left arm, -1 for the right.
fn arm(phase: f64, side: f64) -> [DQuat; 2] {
    let swing = (phase * TAU).cos();
    let late = ((phase - 0.06) * TAU).cos();
    [pitch(-6.0 - 40.0 * swing) * roll(-16.0 * side), pitch(-28.0 - 24.0 * late) * roll(6.0 * side)]
}

/// The walk at a phase. A cycle of two steps has length 1; phases 0 and 1 are the same.
pub(crate) fn walk(phase: f64) -> Stance {
    let (turn, bounce) = ((phase * TAU).cos(), (2.0 * phase * TAU).cos());
    let lag = (2.0 * (phase - 0.12) * TAU).cos();
    let mut rotations = [DQuat::IDENTITY; JOINTS.len()];
    rotations[0] = yaw(-7.0 * turn) * roll(3.5 * (phase * TAU).sin());
    rotations[1] = pitch(5.0 + 2.0 * bounce) * yaw(6.0 * turn);
    rotations[2] = yaw(9.0 * turn) * roll(-4.0 * (phase * TAU).sin());
    rotations[HEAD] = pitch(-5.0 - 3.0 * lag) * yaw(-14.0 - 8.0 * turn) * roll(5.0 * (phase * TAU).sin());
    rotations[HAT] = pitch(-8.0 + 12.0 * lag) * roll(9.0 * ((phase - 0.1) * TAU).sin());
    rotations[5..7].copy_from_slice(&arm(phase + 0.5, 1.0));
    rotations[7..9].copy_from_slice(&arm(phase, -1.0));
    rotations[9..12].copy_from_slice(&leg(phase));
    rotations[12..15].copy_from_slice(&leg(phase + 0.5));
    let sway = DVec3::new(0.018 * (phase * TAU).sin(), 0.0, 0.0);
    let standing = Stance { rotations, hips: JOINTS[0].at + sway };
    let hips = standing.hips - DVec3::Y * lowest(&standing);
    Stance { hips, ..standing }
}

/// Height of the lower sole.
fn lowest(stance: &Stance) -> f64 {
    let mut placed: Vec<DAffine3> = Vec::new();
    for (joint, rotation) in JOINTS.iter().zip(stance.rotations) {
        let parent = joint.parent.map_or(DAffine3::IDENTITY, |parent| placed[parent]);
        let at = if joint.parent.is_none() { stance.hips } else { offset(joint) };
        placed.push(parent * DAffine3::from_rotation_translation(rotation, at));
    }
    let feet = [(11, 1.0), (14, -1.0)];
    let soles = feet.iter().flat_map(|(foot, side)| SOLE.map(|sole| (*foot, sole * DVec3::new(*side, 1.0, 1.0))));
    soles.map(|(foot, sole)| placed[foot].transform_point3(sole - JOINTS[foot].at).y).fold(f64::INFINITY, f64::min)
}

/// The normalised weights of the given joints at a point, the four largest. They decrease with the sixth power of the
/// distance from the bone.
pub(crate) fn joint_weights(at: DVec3, joints: &[usize]) -> [(u8, f64); 4] {
    let mut shares: Vec<(u8, f64)> = joints.iter().map(|&joint| (joint as u8, share(at, &JOINTS[joint]))).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares.resize(4, (0, 0.0));
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    std::array::from_fn(|index| (shares[index].0, shares[index].1 / total))
}

fn share(at: DVec3, joint: &Joint) -> f64 {
    let bone = joint.end - joint.at;
    let along = ((at - joint.at).dot(bone) / bone.length_squared()).clamp(0.0, 1.0);
    let outside = (at.distance(joint.at + bone * along) - joint.radius).max(0.0);
    let near = (0.03 / (0.03 + outside)).powi(6);
    // Bones of one side have almost no weight on the other side.
    let side = (0.5 + at.x * joint.end.x.signum() / 0.06).clamp(0.0, 1.0);
    if joint.end.x == 0.0 { near } else { near * side + 1e-12 }
}
