//! Validates `camera`, `hide` and `show`.
//!
//! In: raw values. Out: a [`CameraRule`] whose keys are complete and of one kind, and a [`Visibility`].

use super::{Check, Kind};
use crate::shot::raw::{RawCamera, RawCameraState, RawLookAt, RawShotCamera};
use crate::shot::{CameraAim, CameraKey, CameraLens, CameraRule, Ease, LookAt, OwnCamera, Visibility};

/// Default vertical field of view in degrees: a portrait lens.
const DEFAULT_FOV_DEGREES: f64 = 30.0;

impl Check<'_> {
    /// Checks the camera; `implicit_frame`: the frame of the implicit key of a camera without keys.
    pub(super) fn camera(&mut self, raw: Option<RawCamera>, (implicit_frame, source): (i32, Kind)) -> CameraRule {
        match raw {
            None => CameraRule::Automatic,
            Some(RawCamera::Named(name)) => CameraRule::Named(name),
            Some(RawCamera::Own(_)) if source != Kind::Scene => {
                self.fault(
                    "camera",
                    "only a shot with a scene has a camera of its own",
                    "remove it, or give a `scene`",
                );
                CameraRule::Automatic
            }
            Some(RawCamera::Own(camera)) => CameraRule::Own(self.own_camera(&camera, implicit_frame)),
        }
    }

    fn own_camera(&mut self, raw: &RawShotCamera, implicit_frame: i32) -> OwnCamera {
        if raw.keys.is_empty() {
            self.exclusive(&raw.state, "camera");
            return OwnCamera { keys: vec![camera_key((f64::from(implicit_frame), Ease::default()), &raw.state)] };
        }
        let mut keys: Vec<CameraKey> = Vec::with_capacity(raw.keys.len());
        for (index, key) in raw.keys.iter().enumerate() {
            let path = format!("camera.keys[{index}]");
            let state = merged(&key.state, &raw.state);
            self.exclusive(&state, &path);
            let key = camera_key((key.frame, key.ease), &state);
            if keys.last().is_some_and(|last| last.frame >= key.frame) {
                let what = format!("frame {} is not later than that of the key before", key.frame);
                self.fault(&format!("{path}.frame"), what, "order the keys by frame");
            }
            if keys.first().is_some_and(|first| first.kind() != key.kind()) {
                let hint = "give all keys the same of distance or position (with or without look_at), fov or ortho";
                self.fault(&path, "its values are of another kind than those of the first key", hint);
            }
            keys.push(key);
        }
        OwnCamera { keys }
    }

    /// Reports values that are mutually exclusive.
    fn exclusive(&mut self, state: &RawCameraState, key: &str) {
        let is_turned = state.yaw.is_some() || state.pitch.is_some();
        if state.position.is_some() && state.distance.is_some() {
            self.fault(key, "a camera has a position or a distance, not both", "remove one of them");
        } else if state.position.is_some() && state.look_at.is_some() && is_turned {
            let hint = "remove yaw and pitch, or look_at";
            self.fault(key, "position and look_at say already where the camera looks", hint);
        }
        if state.fov.is_some() && state.ortho.is_some() {
            self.fault(key, "a camera has a fov or is ortho, not both", "remove one of them");
        }
    }

    pub(super) fn visibility(&mut self, (hide, show): (Vec<String>, Vec<String>), source: Kind) -> Visibility {
        for (key, patterns) in [("hide", &hide), ("show", &show)] {
            if source != Kind::Scene && !patterns.is_empty() {
                self.fault(key, "names nodes of a scene, and the shot has none", "remove it, or give a `scene`");
            }
        }
        Visibility { hide, show }
    }
}

/// Returns a key's values, with the table's as defaults.
fn merged(key: &RawCameraState, table: &RawCameraState) -> RawCameraState {
    // Of mutually exclusive values, a key's value replaces both of the table's.
    let is_placed = key.position.is_some() || key.distance.is_some();
    let has_lens = key.fov.is_some() || key.ortho.is_some();
    RawCameraState {
        look_at: key.look_at.clone().or_else(|| table.look_at.clone()),
        distance: key.distance.or(table.distance.filter(|_| !is_placed)),
        position: key.position.or(table.position.filter(|_| !is_placed)),
        yaw: key.yaw.or(table.yaw),
        pitch: key.pitch.or(table.pitch),
        roll: key.roll.or(table.roll),
        fov: key.fov.or(table.fov.filter(|_| !has_lens)),
        ortho: key.ortho.or(table.ortho.filter(|_| !has_lens)),
    }
}

fn camera_key((frame, ease): (f64, Ease), state: &RawCameraState) -> CameraKey {
    let look_at = state.look_at.as_ref().map(|look_at| match look_at {
        RawLookAt::Point(point) => LookAt::Point(*point),
        RawLookAt::Nodes(pattern) => LookAt::Nodes(pattern.clone()),
    });
    let (yaw, pitch) = (state.yaw.unwrap_or(0.0), state.pitch.unwrap_or(0.0));
    let aim = match (state.position, look_at) {
        (Some(position), Some(look_at)) => CameraAim::Towards { position, look_at },
        (Some(position), None) => CameraAim::Along { position, yaw, pitch },
        (None, look_at) => {
            CameraAim::Orbit { look_at: look_at.unwrap_or(LookAt::Scene), distance: state.distance, yaw, pitch }
        }
    };
    let lens = match state.ortho {
        Some(height) => CameraLens::Ortho(height),
        None => CameraLens::Fov(state.fov.unwrap_or(DEFAULT_FOV_DEGREES)),
    };
    CameraKey { frame, aim, roll: state.roll.unwrap_or(0.0), lens, ease }
}
