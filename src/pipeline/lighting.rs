//! Which lights a shot is drawn with.
//!
//! In: the pose's own lights and the shot's wishes. Out: lights with exposure applied, or the neutral rig.

use crate::pose::{Pose, PosedLight};
use crate::scene::LightKind;
use crate::screen::Camera;
use crate::shot::Shot;
use crate::space::{ScenePoint, SceneVector};
use glam::Vec3;

/// The neutral rig in the camera's own axes: direction towards the light (x right, y up, z towards the viewer) and
/// illuminance in lux. Key, fill and rim of a plain three-light portrait; a white matte card facing the key is at 0.8.
const NEUTRAL_RIG: [(Vec3, f32); 3] =
    [(Vec3::new(-0.6, 0.8, 0.9), 2.2), (Vec3::new(1.0, 0.1, 0.6), 0.5), (Vec3::new(0.5, 0.7, -1.0), 1.2)];

/// The neutral rig as seen from a camera: fixed in the scene, so it does not follow a camera that moves later.
#[must_use]
pub(super) fn neutral_rig(camera: &Camera) -> Vec<PosedLight> {
    let axes = camera.scene_from_view().as_mat4();
    let light = |(towards, lux): (Vec3, f32)| PosedLight {
        kind: LightKind::Directional,
        color: Vec3::splat(lux),
        position: ScenePoint::default(),
        direction: SceneVector(-axes.transform_vector3(towards).normalize()),
        range: f32::INFINITY,
    };
    NEUTRAL_RIG.into_iter().map(light).collect()
}

/// The lights of a pose: its own, else the rig; gained by the shot's exposure.
#[must_use]
pub(super) fn lights(shot: &Shot, pose: &Pose, rig: &[PosedLight]) -> Vec<PosedLight> {
    let gain = shot.exposure_stops.exp2();
    let lights = if pose.lights.is_empty() { rig } else { &pose.lights };
    lights.iter().map(|light| PosedLight { color: light.color * gain, ..*light }).collect()
}

/// Strength of the neutral surroundings: the shot's, else 1 without lights and 0 with.
#[must_use]
pub(super) fn environment(shot: &Shot, pose: &Pose) -> f32 {
    let plain = if pose.lights.is_empty() { 1.0 } else { 0.0 };
    shot.environment.unwrap_or(plain) * shot.exposure_stops.exp2()
}
