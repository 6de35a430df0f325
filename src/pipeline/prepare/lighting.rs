//! Chooses the lights of a shot.
//!
//! In: the lights of the pose and the settings of the shot. Out: lights with exposure applied, or the neutral rig.

use crate::pose::{Pose, PosedLight};
use crate::scene::LightKind;
use crate::screen::Camera;
use crate::shot::Shot;
use crate::space::{ScenePoint, SceneVector};
use glam::Vec3;

/// The neutral rig in camera axes: direction towards the light (x right, y up, z towards the viewer) and illuminance in
/// lux. Key, fill and rim light of a plain three-light portrait; a white matte card that faces the key has a radiance
/// of 0.8.
const NEUTRAL_RIG: [(Vec3, f32); 3] =
    [(Vec3::new(-0.6, 0.8, 0.9), 2.2), (Vec3::new(1.0, 0.1, 0.6), 0.5), (Vec3::new(0.5, 0.7, -1.0), 1.2)];

/// Places the neutral rig relative to a camera and fixes it in the scene, so that it does not follow later camera moves.
#[must_use]
pub(in crate::pipeline) fn neutral_rig(camera: &Camera) -> Vec<PosedLight> {
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

/// Returns the lights of a pose, or the rig if it has none, scaled by the shot's exposure.
#[must_use]
pub(in crate::pipeline) fn lights(shot: &Shot, pose: &Pose, rig: &[PosedLight]) -> Vec<PosedLight> {
    let gain = shot.exposure_stops.exp2();
    let lights = if pose.lights.is_empty() { rig } else { &pose.lights };
    lights.iter().map(|light| PosedLight { color: light.color * gain, ..*light }).collect()
}

/// Returns the strength of the neutral environment light: that of the shot, or else 1 without lights and 0 with lights;
/// scaled by the shot's exposure.
#[must_use]
pub(in crate::pipeline) fn environment(shot: &Shot, pose: &Pose) -> f32 {
    let plain = if pose.lights.is_empty() { 1.0 } else { 0.0 };
    shot.environment.unwrap_or(plain) * shot.exposure_stops.exp2()
}
