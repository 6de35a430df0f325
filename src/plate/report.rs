//! The report of a plate's warp, and its errors.
//!
//! In: counts from the warp. Out: [`PlateReport`], plain data for logs and reports; [`PlateError`].

use super::Semantic;
use serde::Serialize;

/// The result of warping one plate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlateReport {
    /// Every channel of every part, in the plate's order.
    pub channels: Vec<ChannelReport>,
    /// Pixels of the first view's beauty that a matted layer left uncovered, including those that were filled.
    pub uncovered_pixels: usize,
    /// Pixels of the first view's beauty where a layer folds over itself; on a branch, where something is turned over. The front is
    /// shown; the warp cannot be undone there.
    pub folded_pixels: usize,
    /// Colour samples that were NaN (replaced by 0) or infinite (replaced by 65504) and would have spread to their neighbours.
    pub contained_samples: usize,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// The semantic assigned to one channel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChannelReport {
    /// Name of its part, if it has one.
    pub part: Option<String>,
    /// Full name of the channel.
    pub channel: String,
    /// The assigned semantic.
    #[serde(rename = "meaning")]
    pub semantic: Semantic,
    /// How the semantic was determined.
    pub(crate) reason: SemanticReason,
}

/// How the semantic of a channel was determined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum SemanticReason {
    /// Set in the shot.
    Shot,
    /// Set in the metadata of the file.
    Metadata,
    /// By a name or storage type that renderers use for it.
    Name,
    /// Guessed; see the table in docs/PLATES.md.
    Guess,
}

/// Errors of warping a plate. Each message says what is wrong, where, and how to fix it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlateError {
    /// A layer's matte names a channel that is not in the plate.
    #[error("layer \"{layer}\": the plate has no channel \"{channel}\" for its matte; {hint}")]
    NoMatteChannel {
        /// Name of the layer.
        layer: String,
        /// Name of the requested channel.
        channel: String,
        /// The closest match, or the available names.
        hint: String,
    },
    /// A layer's matte selects names that are in no Cryptomatte of the plate.
    #[error("layer \"{layer}\": no Cryptomatte of the plate contains {wanted}; {hint}")]
    NoCryptomatte {
        /// Name of the layer.
        layer: String,
        /// The requested Cryptomatte layer or object name.
        wanted: String,
        /// The closest match, or the available names.
        hint: String,
    },
    /// The map belongs to a frame of another size.
    #[error(
        "the map is for a frame of {map:?} pixels, the plate shows {plate:?}; make the map from a plate of this size"
    )]
    WrongMap {
        /// Width and height of the map's frame.
        map: [u32; 2],
        /// Width and height of the plate's display window.
        plate: [u32; 2],
    },
    /// The clean plate belongs to a frame of another size.
    #[error(
        "the clean plate shows {} x {} pixels, the plate {} x {}; render or scale the clean plate to the size of the plate \
         (their display windows count)",
        fill[0], fill[1], plate[0], plate[1]
    )]
    WrongFill {
        /// Width and height of the clean plate's display window.
        fill: [u32; 2],
        /// Width and height of the plate's display window.
        plate: [u32; 2],
    },
    /// A picture used as an STMap has no pair of channels for it.
    #[error("the picture is not an STMap: its channels are {found}; write u and v as R and G, 32-bit float")]
    NoStMap {
        /// The available channels.
        found: String,
    },
    /// The channels of an STMap are integers.
    #[error("channel \"{channel}\" of the STMap is stored as integers; write fractions of the frame as 32-bit float")]
    StMapOfIntegers {
        /// Name of the channel.
        channel: String,
    },
    /// A picture used as an STMap is a render.
    #[error(
        "the picture is a render of pinwarp and not an STMap, since neighbouring pixels lead to places that are not neighbours; \
         export maps with `pinwarp export --to stmap`"
    )]
    RenderAsStMap,
    /// The values of an STMap are not fractions of the frame.
    #[error(
        "channel \"{channel}\" of the STMap holds {found}, which is not a fraction of the frame; divide pixels by the display \
         window, {frame:?}: u = (x + 0.5)/width, v = 1 - (y + 0.5)/height"
    )]
    StMapInPixels {
        /// Name of the u channel.
        channel: String,
        /// The first such u and v.
        found: String,
        /// Width and height of the display window.
        frame: [u32; 2],
    },
}
