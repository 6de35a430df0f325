//! Quick drafts of pictures: painted smaller, with colour alone.
//!
//! In: the pictures of a shot, a solved sample, a size. Out: a [`Frame`] of that size.

use super::paint::Painter;
use crate::image::Frame;
use crate::pipeline::{PipelineError, PreparedShot, TimeSample};
use crate::space::FrameSize;

/// Draws a sample in a size of the frame's shape, with colour alone.
///
/// # Errors
/// [`PipelineError`] if the shot has no pictures.
pub(in crate::pipeline) fn paint_draft(
    prepared: &PreparedShot,
    sample: &TimeSample,
    size: FrameSize,
) -> Result<Frame, PipelineError> {
    let missing = || PipelineError::Interrupted { frame: sample.frame as i32 };
    let gallery = prepared.gallery.as_ref().ok_or_else(missing)?;
    if gallery.frame == size {
        return Ok(Painter::new(gallery, prepared).draft(sample));
    }
    let small = gallery.small.of(size, || gallery.scaled(size));
    Ok(Painter::new(&small, prepared).draft(sample))
}
