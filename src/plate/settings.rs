//! Settings of a warp: filter, channel semantics, mattes, holes.
//!
//! Plain data, filled from the shot file.

use super::Coverage;
use crate::space::FrameSize;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Settings for warping finished frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpSettings {
    /// Filter for colour.
    pub filter: Filter,
    /// Treatment of normals.
    pub normals: NormalMode,
    /// Encoding of motion vectors; `None`: unspecified, so vectors of other programs pass through unchanged.
    pub motion: Option<MotionEncoding>,
    /// Unit of the pixels in `motion`.
    pub motion_scale: MotionUnit,
    /// Patterns of full channel names (`*` and `?`) with their semantics. They take precedence over guesses; the first match wins.
    pub semantics: Vec<(String, Semantic)>,
    /// How uncovered regions are filled.
    pub holes: Holes,
}

impl WarpSettings {
    /// Returns the settings for plates of the given size, with motion in pixels.
    #[must_use]
    pub(crate) fn in_pixels(&self, size: FrameSize) -> Self {
        let sides = match self.motion_scale {
            MotionUnit::Pixels => [1.0; 2],
            MotionUnit::Frame => [size.width, size.height].map(f64::from),
        };
        let motion = self.motion.map(|MotionEncoding { pixels_per_unit: [x, y] }| MotionEncoding {
            pixels_per_unit: [x * sides[0], y * sides[1]],
        });
        Self { motion, motion_scale: MotionUnit::Pixels, ..self.clone() }
    }
}

/// How colour is resampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// Catmull-Rom over the ellipse that a pixel covers: no aliasing where the warp shrinks, no ringing.
    #[default]
    Ewa,
    /// Catmull-Rom, 4x4 samples: sharp, aliases where the warp shrinks.
    Cubic,
    /// Lanczos, three lobes, 6x6 samples: sharper, rings.
    Lanczos,
    /// The nearest sample.
    Nearest,
}

/// Treatment of normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NormalMode {
    /// They stay those of the unwarped surface, so relighting matches the picture.
    #[default]
    Keep,
    /// Rotated in the view plane with the lattice.
    Rotate,
}

/// Encoding of motion vectors in a renderer's channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionEncoding {
    /// Pixels per unit of u and of v: 1 for pixels, the width and height of the frame for normalised vectors; negative
    /// where an axis points left or down. Pinwarp's own channels have (1, 1): pixels, x right, y up.
    pub pixels_per_unit: [f64; 2],
}

/// Unit of a [`MotionEncoding`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionUnit {
    /// Pixels of the plate.
    #[default]
    Pixels,
    /// Widths and heights of the plate's frame; see `WarpSettings::in_pixels`.
    Frame,
}

/// What a channel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Semantic {
    /// Light, filtered; associated with the alpha of its layer where there is one.
    Color,
    /// Coverage, filtered.
    Alpha,
    /// Distance: nearest surface, never blended; nothing is 1e10.
    Depth,
    /// Ids: nearest, never blended.
    Id,
    /// Ranks of a Cryptomatte: coverage is accumulated per id.
    Cryptomatte,
    /// A component of the vector to this point's place in the next frame.
    Forward,
    /// A component of the vector to its place in the previous frame.
    Backward,
    /// A component of a normal: nearest.
    Normal,
    /// Other data, for example positions or texture coordinates: nearest, never blended.
    Data,
}

/// The part of a plate that a layer moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Matte {
    /// Everything in the picture, by its alpha; nothing stays behind. For pictures of one object over nothing.
    Alpha,
    /// The values of a channel, 0 to 1: `mask.R`.
    Channel(String),
    /// Pixels with one of the given ids.
    Id {
        /// Name of the channel: `id.object`.
        channel: String,
        /// Selected ids.
        values: Vec<u32>,
    },
    /// Coverage of names in a Cryptomatte; patterns with `*` and `?`.
    Cryptomatte {
        /// Name of the Cryptomatte layer, `CryptoObject`; `None`: the only one that contains the names.
        layer: Option<String>,
        /// Names in the manifest, or ids as hexadecimal numbers.
        names: Vec<String>,
    },
    /// Coverage rendered for this frame.
    Drawn(Arc<Coverage>),
    /// One of several parts that split a layer and move independently. The shares of all parts of a layer sum to 1.
    Part {
        /// Matte of the layer; [`Self::Alpha`]: everything in the picture.
        of: Box<Matte>,
        /// The part's share of every pixel.
        share: Arc<Coverage>,
    },
}

impl Matte {
    /// Whether the matte takes the whole picture, so that nothing stays behind.
    #[must_use]
    pub(crate) fn is_all(&self) -> bool {
        match self {
            Self::Alpha => true,
            Self::Part { of, .. } => of.is_all(),
            _ => false,
        }
    }

    /// Whether both mattes select the same pixels of any plate, regardless of the order of ids or names.
    #[must_use]
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Id { channel, values }, Self::Id { channel: other, values: others }) => {
                channel == other && sorted(values) == sorted(others)
            }
            (Self::Cryptomatte { layer, names }, Self::Cryptomatte { layer: other, names: others }) => {
                layer == other && sorted(names) == sorted(others)
            }
            _ => self == other,
        }
    }
}

fn sorted<T: Ord>(list: &[T]) -> BTreeSet<&T> {
    list.iter().collect()
}

/// How regions of the background that a matted layer uncovers are filled.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Holes {
    /// Not filled: they stay transparent, and the report counts them.
    #[default]
    Leave,
    /// From a clean plate: a path, with a frame counter for sequences.
    Plate(PathBuf),
    /// From the shot's scene, rendered without the layers that moved.
    Geometry,
}
