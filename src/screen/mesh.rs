//! A pose projected to the screen.
//!
//! In: a [`Pose`], a camera. Out: a [`ScreenMesh`]: the screen position of every vertex.

use super::camera::{Camera, Projected};
use crate::pose::{Pose, PosedPart};
use crate::scene::{Primitive, Scene};
use rayon::prelude::*;

/// A projected pose: one part for each of [`Pose::parts`], in that order.
#[derive(Clone, Debug, Default)]
pub struct ScreenMesh {
    /// One per part of the pose.
    pub parts: Vec<ScreenPart>,
}

/// The projected vertices of one posed part.
#[derive(Clone, Debug, Default)]
pub struct ScreenPart {
    /// #vertices; those nearer than the near plane are valid only as input of `clip_near`.
    pub vertices: Vec<Projected>,
}

/// Projects every vertex of a pose.
#[must_use]
pub(crate) fn project(pose: &Pose, camera: &Camera) -> ScreenMesh {
    let part = |part: &PosedPart| ScreenPart {
        vertices: part.positions.par_iter().with_min_len(4096).map(|&point| camera.project(point)).collect(),
    };
    ScreenMesh { parts: pose.parts.iter().map(part).collect() }
}

/// Returns the primitive that a posed part was made from.
#[must_use]
pub fn primitive<'a>(scene: &'a Scene, part: &PosedPart) -> &'a Primitive {
    &scene.meshes[part.mesh].primitives[part.primitive]
}
