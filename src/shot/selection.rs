//! Which part of the meshes of its nodes a layer takes.

use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

/// Least width of the border between layers of one mesh where the shot does not say it, diagonals of the mesh.
pub(super) const FEATHER: f64 = 0.1;

/// What a layer takes of the meshes of its nodes: what all of its rules name; without rules the whole meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Only what no other layer takes.
    pub is_rest: bool,
    /// Patterns of joint names (`*`, `?`, and `!` in front to take out): vertices by their weight to these joints and
    /// those below them. Empty: whatever moves them.
    pub joints: Vec<String>,
    /// Patterns of material names. Empty: whatever they are made of.
    pub materials: Vec<String>,
    /// Channel of the vertex colours: how much of a vertex is taken, 0 to 1.
    pub vertex_color: Option<ColorChannel>,
    /// How much of a vertex is taken, as painted over its UVs.
    pub mask: Option<PaintedMask>,
    /// Least width of the border over which a mesh goes from layer to layer, diagonals of the mesh at rest.
    pub feather: f64,
}

/// A picture painted over the UVs of meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedMask {
    /// The picture.
    pub file: PathBuf,
    /// Its channel.
    pub channel: ColorChannel,
    /// Which of [`Primitive::uvs`](crate::scene::Primitive::uvs): 0 or 1.
    pub uv_set: usize,
}

impl Default for Selection {
    /// Whole meshes.
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
    /// Whole meshes are taken.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.joints.is_empty() && self.materials.is_empty() && self.vertex_color.is_none() && self.mask.is_none()
    }
}

/// A channel of vertex colours or of a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ColorChannel {
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
    /// Its place in RGBA.
    #[must_use]
    pub const fn index(self) -> usize {
        match self {
            Self::R => 0,
            Self::G => 1,
            Self::B => 2,
            Self::A => 3,
        }
    }
}
