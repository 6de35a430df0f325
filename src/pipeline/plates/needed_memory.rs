//! Estimates of the memory that the pictures of a warp need, before they are decoded.
//!
//! In: the extent of a picture. Out: bytes.

use crate::image::PictureExtent;

/// Returns the memory for a picture that is only sampled: its samples as floats, and as stored while being decoded.
pub(super) fn held_bytes(extent: PictureExtent) -> u128 {
    8 * extent.samples
}

/// Returns the memory for a plate that is warped and written: the decoded, the warped and the encoded samples, its map,
/// the background of folds, and shares and coverage of layers.
pub(super) fn warped_bytes(extent: PictureExtent) -> u128 {
    12 * extent.samples + 40 * extent.pixels
}
