//! Cryptomatte: id mattes of all named objects, to the specification of Psyop.
//!
//! In: names, shares of pixels; channels and attributes of other programs. Out: ids, ranks, manifests, and the inverse.
//! Friedman and Jones, "Fully automatic ID mattes with support for motion blur and transparency", SIGGRAPH 2015
//! posters; Cryptomatte Specification 1.2.0, github.com/Psyop/Cryptomatte.

mod hash;
mod header;
mod layer;
mod manifest;
mod ranks;
mod side;

pub use hash::MatteId;
pub use header::MatteHeader;
pub(crate) use layer::rank_channel_names;
pub use layer::{MatteLayer, RankChannels, matte_layers};
pub(crate) use manifest::clean_name;
pub use manifest::{Manifest, Selection};
pub(crate) use ranks::IdCoverage;
pub(super) use side::take_in_manifests;

/// Number of ranks that the specification suggests: three RGBA layers.
///
/// ```text
/// CryptoObject00.R = id of rank 0, .G = its coverage;  .B = id of rank 1, .A = its coverage;  CryptoObject01.R …
/// ```
pub(crate) const USUAL_RANKS: usize = 6;
