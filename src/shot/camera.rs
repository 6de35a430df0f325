//! The camera of a shot and what it sees of the scene: plain data, and which keys count at a time.
//!
//! In: what `check/camera.rs` accepted. Out: types for the pipeline, which knows the scene.

use super::Ease;
use super::keys::Span;

/// Which camera sees the shot.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraRule {
    /// The scene's first; without any, one that shows the whole scene.
    #[default]
    Automatic,
    /// A camera of the scene by the name of its node or by its own; else a standard view, such as `front` or `side:body`.
    Named(String),
    /// The shot's own.
    Own(OwnCamera),
}

/// A camera that the shot describes.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnCamera {
    /// At least one; frames strictly increasing, all of one [`CameraKey::kind`].
    pub keys: Vec<CameraKey>,
}

/// A camera at one frame. Angles are in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraKey {
    /// When.
    pub frame: f64,
    /// Where it stands and looks.
    pub aim: CameraAim,
    /// Turn about the view axis, counter-clockwise.
    pub roll: f64,
    /// How wide it sees.
    pub lens: CameraLens,
    /// Shapes the segment that leaves this key.
    pub ease: Ease,
}

/// Where a camera stands and looks. Yaw turns it around the scene's y (0: it stands at +z, 90: at +x), pitch raises it.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraAim {
    /// Around what it looks at.
    Orbit {
        /// The middle of the orbit.
        look_at: LookAt,
        /// Metres; `None`: as far as shows all of it.
        distance: Option<f64>,
        /// Degrees.
        yaw: f64,
        /// Degrees.
        pitch: f64,
    },
    /// From a point towards what it looks at.
    Towards {
        /// Metres.
        position: [f64; 3],
        /// What is in the middle of the frame.
        look_at: LookAt,
    },
    /// From a point; it looks as a camera that orbits with this yaw and pitch.
    Along {
        /// Metres.
        position: [f64; 3],
        /// Degrees.
        yaw: f64,
        /// Degrees.
        pitch: f64,
    },
}

/// What a camera looks at.
#[derive(Clone, Debug, PartialEq)]
pub enum LookAt {
    /// The middle of everything that can be seen.
    Scene,
    /// The middle of the nodes that match a pattern, with their subtrees.
    Nodes(String),
    /// The middle of a layer.
    Layer(String),
    /// A point of the scene, metres.
    Point([f64; 3]),
}

/// How wide a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraLens {
    /// Vertical field of view, degrees.
    Fov(f64),
    /// Parallel: the height it sees, metres.
    Ortho(f64),
}

impl CameraKey {
    /// Keys of one kind can be interpolated.
    #[must_use]
    pub fn kind(&self) -> impl PartialEq + use<> {
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
    /// The keys around a (fractional) frame and the weight of the second, from 0 to 1; an ease may overshoot.
    #[must_use]
    pub fn keys_at(&self, frame: f64) -> Option<(usize, usize, f64)> {
        let span = Span::of(&self.keys, frame, |key| (key.frame, key.ease))?;
        let index = |key: &CameraKey| self.keys.iter().position(|other| std::ptr::eq(other, key));
        Some((index(span.from)?, index(span.to)?, span.weight))
    }
}

/// Which nodes are drawn: patterns of node names, each with its subtree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Visibility {
    /// Not drawn.
    pub hide: Vec<String>,
    /// Drawn all the same; without `hide`: nothing else is drawn.
    pub show: Vec<String>,
}
