//! The part of its nodes' meshes that a layer takes.

use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// Default minimum width of the transition between layers of one mesh, in diagonals of the mesh.
pub(super) const FEATHER: f64 = 0.1;

/// The part that a layer takes of its nodes' meshes: the intersection of its rules; without rules the whole meshes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Selection {
    /// Whether it takes only what no other layer takes.
    pub is_rest: bool,
    /// Patterns of joint names (`*`, `?`, and a leading `!` to exclude): vertices are taken by their weight to these
    /// joints and their descendants. Empty: no restriction.
    pub joints: Vec<String>,
    /// Patterns of material names. Empty: no restriction.
    pub materials: Vec<String>,
    /// Channel of the vertex colours with the fraction of each vertex that is taken, 0 to 1.
    pub vertex_color: Option<ColorChannel>,
    /// Picture over the UVs with the fraction of each vertex that is taken.
    pub mask: Option<PaintedMask>,
    /// Minimum width of the transition between layers of a mesh, in diagonals of the mesh at rest.
    pub feather: f64,
}

/// A picture painted over the UVs of meshes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PaintedMask {
    /// The picture.
    pub file: PathBuf,
    /// Its channel.
    pub channel: ColorChannel,
    /// Which of [`Primitive::uvs`](crate::scene::Primitive::uvs): 0 or 1.
    pub uv_set: usize,
}

impl Default for Selection {
    /// Takes whole meshes.
    fn default() -> Self {
        Self {
            is_rest: false,
            joints: Vec::new(),
            materials: Vec::new(),
            vertex_color: None,
            mask: None,
            feather: FEATHER,
        }
    }
}

impl Selection {
    /// Returns whether whole meshes are taken.
    #[must_use]
    pub(crate) const fn is_whole(&self) -> bool {
        self.joints.is_empty() && self.materials.is_empty() && self.vertex_color.is_none() && self.mask.is_none()
    }
}

/// A channel of vertex colours or of a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ColorChannel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

impl ColorChannel {
    /// Returns its index in RGBA.
    #[must_use]
    pub(crate) const fn index(self) -> usize {
        match self {
            Self::R => 0,
            Self::G => 1,
            Self::B => 2,
            Self::A => 3,
        }
    }
}
