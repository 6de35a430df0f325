//! Settings of a warp: filter, semantics of channels, mattes, holes.
//!
//! Plain data that the shot file fills.

use super::Coverage;
use crate::space::FrameSize;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// How finished frames are warped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WarpSettings {
    /// How colour is resampled.
    pub filter: Filter,
    /// What becomes of normals.
    pub normals: NormalMode,
    /// How motion vectors are stored; `None`: not said, so vectors of other programs pass through unrotated.
    pub motion: Option<MotionEncoding>,
    /// What that rule's pixels are counted against.
    pub motion_scale: MotionUnit,
    /// Patterns of full channel names (`*` and `?`) and what they mean, before any guess; the first that fits counts.
    pub semantics: Vec<(String, Semantic)>,
    /// What fills places that the warp uncovers.
    pub holes: Holes,
}

impl WarpSettings {
    /// The settings for plates of that size: motion in pixels.
    #[must_use]
    pub fn in_pixels(&self, size: FrameSize) -> Self {
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

/// What becomes of normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NormalMode {
    /// They stay those of the unwarped surface, so relighting matches the picture.
    #[default]
    Keep,
    /// They turn in the view plane as the lattice turns.
    Rotate,
}

/// How a renderer stores motion vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionEncoding {
    /// Pixels a unit of u and of v is: 1 for pixels, the width and height of the frame for normalised vectors; negative
    /// where an axis points left or down. Pinwarp's own channels have (1, 1): pixels, x right, y up.
    pub pixels_per_unit: [f64; 2],
}

/// What the numbers of a [`MotionEncoding`] count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionUnit {
    /// Pixels of the plate, of whatever size it is.
    #[default]
    Pixels,
    /// Widths and heights of the plate's frame; see [`WarpSettings::in_pixels`].
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
    /// Ranks of a Cryptomatte: coverage is gathered an id at a time.
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
    /// All that is there: for pictures of one thing over nothing. Nothing of the picture stays behind.
    Alpha,
    /// The values of a channel, 0 to 1: `mask.R`.
    Channel(String),
    /// Pixels whose id is one of these.
    Id {
        /// Name of the channel: `id.object`.
        channel: String,
        /// Ids.
        values: Vec<u32>,
    },
    /// Coverage of names in a Cryptomatte, patterns with `*` and `?`.
    Cryptomatte {
        /// Name of its layer, `CryptoObject`; `None`: the only one that knows the names.
        layer: Option<String>,
        /// Names in its manifest, or ids as hexadecimal numbers.
        names: Vec<String>,
    },
    /// Coverage that was drawn for this frame.
    Drawn(Arc<Coverage>),
    /// The share that one of several parts, which move by themselves, has of what a layer moves. Those of all parts of a layer sum to 1.
    Part {
        /// What the layer moves: [`Self::Alpha`]: all that is there.
        of: Box<Matte>,
        /// The part's share of every pixel.
        share: Arc<Coverage>,
    },
}

impl Matte {
    /// Nothing of the picture stays behind.
    #[must_use]
    pub fn is_all(&self) -> bool {
        match self {
            Self::Alpha => true,
            Self::Part { of, .. } => of.is_all(),
            _ => false,
        }
    }

    /// Whether both take the same pixels of any plate, in whatever order they list ids or names.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
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

/// What fills places of the background that a matted layer no longer covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Holes {
    /// Nothing: they stay transparent, and the report counts them.
    #[default]
    Leave,
    /// A clean plate: a path, with a frame counter where it is a sequence.
    Plate(PathBuf),
    /// The shot's own scene, drawn without the layers that were moved away.
    Geometry,
}
