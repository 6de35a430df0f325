//! The nearest sample.
//!
//! In: offsets of a row of pixels. Out: the bits of the samples nearest to where they lead.

use super::border::Extent;

/// Index into the source of the sample nearest to a place; `None` outside the picture and where the offset is NaN.
/// `start` is the pixel's own sample, in samples of the source.
#[inline(always)]
pub(super) fn nearest_sample(offset: [f32; 2], start: [i32; 2], extents: &[Extent; 2]) -> Option<usize> {
    let x = start[0] as f32 + (offset[0] + 0.5).floor();
    let y = start[1] as f32 + (offset[1] + 0.5).floor();
    let is_inside = (x >= 0.0) & (y >= 0.0) & (x < extents[0].count as f32) & (y < extents[1].count as f32);
    if is_inside { Some(y as usize * extents[0].count as usize + x as usize) } else { None }
}
