//! Poses: a skeleton bends, and pins follow it.
//!
//! In: joints and rotations. Out: for each pinned joint, the nearest vertex of the body and its position in the pose.

use super::Figure;
use super::mesh::{Mesh, rounded};
use glam::DVec2;

/// A joint. The part between it and its parent moves rigidly.
pub(crate) struct Joint {
    name: &'static str,
    parent: Option<&'static str>,
    at: DVec2,
}

impl Joint {
    pub(crate) const fn new(name: &'static str, parent: &'static str, at: DVec2) -> Self {
        Self { name, parent: Some(parent), at }
    }

    /// The joint that does not move.
    pub(crate) const fn root(name: &'static str, at: DVec2) -> Self {
        Self { name, parent: None, at }
    }
}

/// A pose of a figure.
pub(crate) struct Pose {
    pub(crate) name: &'static str,
    /// Joints with the angle in degrees, counter-clockwise, by which everything beyond them is rotated.
    turns: Vec<(&'static str, f64)>,
    /// Joints whose nearest vertex is pinned.
    pins: Vec<&'static str>,
}

impl Pose {
    pub(crate) fn new(name: &'static str, turns: &[(&'static str, f64)], pins: &[&'static str]) -> Self {
        Self { name, turns: turns.to_vec(), pins: pins.to_vec() }
    }
}

/// The rigid motion of a bone.
#[derive(Clone, Copy)]
struct Bone {
    from: DVec2,
    to: DVec2,
    turn: DVec2,
}

impl Bone {
    fn image(&self, at: DVec2) -> DVec2 {
        self.to + self.turn.rotate(at - self.from)
    }
}

/// Vertices and targets of a pose's pins.
pub(crate) fn pins(figure: &Figure, mesh: &Mesh, pose: &Pose) -> Vec<(usize, DVec2)> {
    pose.pins
        .iter()
        .map(|name| {
            let joint = joint(figure, name);
            let body = mesh.vertices[..mesh.body_vertices].iter().enumerate();
            let nearest = body.min_by(|a, b| a.1.distance(joint.at).total_cmp(&b.1.distance(joint.at)));
            let (vertex, at) = nearest.expect("the body has vertices");
            (vertex, rounded(bone(figure, pose, joint.parent).image(*at)))
        })
        .collect()
}

fn joint<'a>(figure: &'a Figure, name: &str) -> &'a Joint {
    figure.joints.iter().find(|joint| joint.name == name).expect("poses name joints that are there")
}

/// The motion of the bone that begins at a joint.
fn bone(figure: &Figure, pose: &Pose, name: Option<&'static str>) -> Bone {
    let Some(name) = name else { return Bone { from: DVec2::ZERO, to: DVec2::ZERO, turn: DVec2::X } };
    let joint = joint(figure, name);
    let parent = bone(figure, pose, joint.parent);
    let degrees = pose.turns.iter().find(|turn| turn.0 == name).map_or(0.0, |turn| turn.1);
    let turn = DVec2::from_angle(degrees.to_radians()).rotate(parent.turn);
    Bone { from: joint.at, to: parent.image(joint.at), turn }
}
