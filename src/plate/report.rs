//! What a warp did to a plate, and what it cannot do.
//!
//! In: counts from the warp. Out: [`PlateReport`], plain data for logs and reports; [`PlateError`].

use super::Semantic;
use serde::Serialize;

/// What was done to one plate.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlateReport {
    /// Every channel of every part, in the plate's order.
    pub channels: Vec<ChannelReport>,
    /// Pixels of the first view's picture that a matted layer left and nothing covers; filled ones are counted too.
    pub hole_pixels: usize,
    /// Pixels of the first view's picture where a layer lies over itself. Its front is seen; the warp cannot be undone there.
    pub folded_pixels: usize,
    /// Samples of colour that were no number (made 0) or infinite (made 65504) and would have spread to their neighbours.
    pub contained_samples: usize,
    /// What the user should know, in plain words.
    pub warnings: Vec<String>,
}

/// What one channel was taken for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChannelReport {
    /// Name of its part, where it has one.
    pub part: Option<String>,
    /// Full name of the channel.
    pub channel: String,
    /// How it was treated.
    #[serde(rename = "meaning")]
    pub semantic: Semantic,
    /// How that is known.
    pub reason: SemanticReason,
}

/// How the semantic of a channel is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SemanticReason {
    /// The shot says so.
    Shot,
    /// The file's metadata say so.
    Metadata,
    /// Its name or its storage is one that renderers use for it.
    Name,
    /// Nothing says so; see the table in docs/PLATES.md.
    Guess,
}

/// A plate that cannot be warped as asked. Each message says what, where and how to fix it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlateError {
    /// A layer's matte names a channel that the plate does not have.
    #[error("layer \"{layer}\": the plate has no channel \"{channel}\" for its matte; {hint}")]
    NoMatteChannel {
        /// The layer.
        layer: String,
        /// The channel asked for.
        channel: String,
        /// The nearest right name, or what there is.
        hint: String,
    },
    /// A layer's matte selects names that no Cryptomatte of the plate knows.
    #[error("layer \"{layer}\": no Cryptomatte of the plate knows {wanted}; {hint}")]
    NoCryptomatte {
        /// The layer.
        layer: String,
        /// What was asked for: a Cryptomatte layer or a name.
        wanted: String,
        /// The nearest right name, or what there is.
        hint: String,
    },
    /// The map was made for another frame.
    #[error(
        "the map is for a frame of {map:?} pixels, the plate shows {plate:?}; make the map from a plate of this size"
    )]
    WrongMap {
        /// Width and height of the map's frame.
        map: [u32; 2],
        /// Width and height of the plate's display window.
        plate: [u32; 2],
    },
    /// A picture that was to be an STMap has no pair of channels for it.
    #[error("the picture holds no STMap: it has the channels {found}; write u and v as R and G, 32-bit float")]
    NoStMap {
        /// What there is.
        found: String,
    },
    /// The channels of an STMap hold no fractions.
    #[error("channel \"{channel}\" of the STMap holds whole numbers; write shares of the frame as 32-bit float")]
    StMapOfIntegers {
        /// The channel.
        channel: String,
    },
    /// The values of an STMap are not shares of the frame.
    #[error(
        "channel \"{channel}\" of the STMap holds {found}, which is no share of a frame; divide pixels by the display \
         window, {frame:?}: u = (x + 0.5)/width, v = 1 - (y + 0.5)/height"
    )]
    StMapInPixels {
        /// Name of the channel of u.
        channel: String,
        /// The first such u and v.
        found: String,
        /// Width and height of the display window.
        frame: [u32; 2],
    },
}
