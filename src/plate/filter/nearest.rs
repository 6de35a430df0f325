//! The nearest sample.
//!
//! In: offsets of a row of pixels. Out: the bits of the samples nearest to where they lead.

use super::border::Extent;

/// Index into the source of the sample nearest to a place; `None` outside the picture and where the offset is NaN.
/// `start` is the pixel's own sample, in samples of the source.
#[inline(always)]
pub(super) fn nearest_sample(offset: [f32; 2], start: [i32; 2], extents: &[Extent; 2]) -> Option<usize> {
    let place = |axis: usize| {
        let sample = start[axis] as f32 + (offset[axis] + 0.5).floor();
        (sample >= 0.0 && sample < extents[axis].count as f32).then_some(sample as usize)
    };
    Some(place(1)? * extents[0].count as usize + place(0)?)
}
