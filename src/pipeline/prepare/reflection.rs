//! Reflections of directions at the plane of symmetry of a model, as it stands at one time.
//!
//! In: a plane at rest and the node with which it moves. Out: a [`Reflection`] for every pose.

use crate::pipeline::PinAnchor;
use crate::pose::Pose;
use crate::screen::Camera;
use crate::space::ScreenVector;
use glam::{DMat3, DVec3};

/// A pin that takes the keys of another one, mirrored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::pipeline) struct MirroredPin {
    /// The anchor of the other pin.
    pub(in crate::pipeline) source: PinAnchor,
    /// The node with which the plane moves; `None`: it rests.
    pub(super) carrier: Option<usize>,
    /// Normal of the plane in the space of that node.
    pub(super) normal: DVec3,
}

/// A reflection of directions at one time, in scene space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::pipeline) struct Reflection {
    normal: DVec3,
}

impl MirroredPin {
    /// Returns the reflection at the time of a pose.
    pub(in crate::pipeline) fn reflection(&self, pose: &Pose) -> Reflection {
        let normal = self.carrier.map_or(self.normal, |node| {
            // Normals are transformed by the inverse transpose.
            let scene_from_carrier = DMat3::from_mat4(pose.scene_from_node[node].as_dmat4());
            scene_from_carrier.inverse().transpose() * self.normal
        });
        Reflection { normal: normal.normalize_or(DVec3::X) }
    }
}

impl Reflection {
    /// Returns the reflection of a direction in scene space.
    pub(in crate::pipeline) fn direction(&self, direction: DVec3) -> DVec3 {
        direction - 2.0 * self.normal.dot(direction) * self.normal
    }

    /// Returns the gradient that is the mirror image of a gradient in scene space: S G S, S the reflection.
    pub(in crate::pipeline) fn gradient(&self, gradient: DMat3) -> DMat3 {
        let reflect = DMat3::from_cols(self.direction(DVec3::X), self.direction(DVec3::Y), self.direction(DVec3::Z));
        reflect * gradient * reflect
    }

    /// Returns the reflection as a camera sees it.
    pub(in crate::pipeline) fn seen_by(&self, camera: &Camera) -> ScreenReflection {
        ScreenReflection { normal: camera.view_from_scene().transform_vector3(self.normal) }
    }
}

/// A reflection at one time as seen by a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::pipeline) struct ScreenReflection {
    /// In view space.
    normal: DVec3,
}

impl ScreenReflection {
    /// Returns the reflection of a direction on the screen; what turns it away from the view plane is lost.
    pub(in crate::pipeline) fn direction(&self, direction: ScreenVector) -> ScreenVector {
        let across = self.normal.truncate();
        ScreenVector(direction.0 - 2.0 * across.dot(direction.0) * across)
    }

    /// Returns the factor of angles on the screen: −1 for a model seen from the front, 1 for one seen from the side.
    pub(in crate::pipeline) fn turn(&self) -> f64 {
        2.0 * self.normal.z.powi(2) - 1.0
    }
}
