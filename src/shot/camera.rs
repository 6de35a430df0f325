//! The camera and visibility of a shot: plain data, and the keys in effect at a time.
//!
//! In: what `check/camera.rs` accepted. Out: types for the pipeline, which resolves them against the scene.

use super::Ease;
use super::keys::Span;

/// The camera of a shot.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum CameraRule {
    /// The scene's first camera; without any, one that shows the whole scene.
    #[default]
    Automatic,
    /// A camera of the scene, by the name of its node or its own; else a standard view, such as `front` or `side:body`.
    Named(String),
    /// A camera defined by the shot.
    Own(OwnCamera),
}

/// A camera defined by the shot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct OwnCamera {
    /// At least one; frames strictly increasing, all of the same `CameraKey::kind`.
    pub keys: Vec<CameraKey>,
}

/// A keyframe of a camera. Angles are in degrees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraKey {
    /// Its frame.
    pub frame: f64,
    /// Position and orientation.
    pub aim: CameraAim,
    /// Rotation about the view axis in degrees, counter-clockwise.
    pub roll: f64,
    /// The lens.
    pub lens: CameraLens,
    /// Easing of the segment that starts at this key.
    pub ease: Ease,
}

/// Position and orientation of a camera. Yaw rotates it around the scene's y axis (0: at +z, 90: at +x), pitch raises
/// it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CameraAim {
    /// Orbits its target.
    Orbit {
        /// The centre of the orbit.
        look_at: LookAt,
        /// Distance in metres; `None`: the smallest at which all of the target is visible.
        distance: Option<f64>,
        /// Yaw in degrees.
        yaw: f64,
        /// Pitch in degrees.
        pitch: f64,
    },
    /// At a fixed position, looking at a target.
    Towards {
        /// Position in metres.
        position: [f64; 3],
        /// The target in the middle of the frame.
        look_at: LookAt,
    },
    /// At a fixed position, with the orientation of an orbiting camera of this yaw and pitch.
    Along {
        /// Position in metres.
        position: [f64; 3],
        /// Yaw in degrees.
        yaw: f64,
        /// Pitch in degrees.
        pitch: f64,
    },
}

/// The target of a camera.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LookAt {
    /// The centre of everything visible.
    Scene,
    /// The centre of the nodes that match a pattern, with their subtrees.
    Nodes(String),
    /// The centre of a layer.
    Layer(String),
    /// A point in scene space, in metres.
    Point([f64; 3]),
}

/// The projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum CameraLens {
    /// Perspective: the vertical field of view in degrees.
    Fov(f64),
    /// Orthographic: the visible height in metres.
    Ortho(f64),
}

impl CameraKey {
    /// Returns the kind of the key; only keys of the same kind can be interpolated.
    #[must_use]
    pub(crate) fn kind(&self) -> impl PartialEq + use<> {
        let aim = match self.aim {
            CameraAim::Orbit { distance: None, .. } => 0,
            CameraAim::Orbit { distance: Some(_), .. } => 1,
            CameraAim::Towards { .. } => 2,
            CameraAim::Along { .. } => 3,
        };
        (aim, matches!(self.lens, CameraLens::Ortho(_)))
    }
}

impl OwnCamera {
    /// Returns the indices of the keys around a (fractional) frame, and the weight of the second, 0 to 1; an ease may
    /// overshoot.
    #[must_use]
    pub(crate) fn keys_at(&self, frame: f64) -> Option<(usize, usize, f64)> {
        let span = Span::of(&self.keys, frame, |key| (key.frame, key.ease))?;
        let index = |key: &CameraKey| self.keys.iter().position(|other| std::ptr::eq(other, key));
        Some((index(span.from)?, index(span.to)?, span.weight))
    }
}

/// The drawn nodes, as patterns of node names, each including its subtree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Visibility {
    /// Nodes that are hidden.
    pub hide: Vec<String>,
    /// Exceptions from `hide`; if `hide` is empty, only these are drawn.
    pub show: Vec<String>,
}
