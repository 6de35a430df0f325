//! A render request: a window of a picture, with its mask and background.
//!
//! In: plain values. Out: a [`Render`] with consistent planes.

use super::{LiveError, Mix, Picture};
use crate::plate::Filter;
use crate::space::{FrameSize, PixelRect};

/// A render request.
#[derive(Clone, Copy)]
pub struct Render<'a> {
    /// The display window, in pixels of this render (smaller for proxies).
    pub frame: FrameSize,
    /// The pixels to render; may lie outside the frame.
    pub window: PixelRect,
    /// The picture to warp.
    pub source: &'a Picture<'a>,
    /// One plane, 0 to 1: the part of the picture that moves; the rest stays. Nothing moves where it has no samples.
    pub mask: Option<&'a Picture<'a>>,
    /// Shown where something moved away or the picture has no pixels; as many planes as the source.
    pub background: Option<&'a Picture<'a>>,
    /// Resampling filter.
    pub filter: Filter,
    /// Blend of the result with the source.
    pub mix: Mix<'a>,
    /// Called regularly on the rendering thread; `true` cancels the render.
    pub abort: &'a (dyn Fn() -> bool + Sync),
}

impl Render<'_> {
    /// Checks that all planes match.
    pub(super) fn check(&self) -> Result<(), LiveError> {
        self.source.check("the source")?;
        if let Some(mask) = self.mask {
            mask.check("the mask")?;
        }
        let Some(background) = self.background else { return Ok(()) };
        background.check("the background")?;
        let (found, wanted) = (background.planes.len(), self.source.planes.len());
        if found == wanted { Ok(()) } else { Err(LiveError::PlaneCount { found, wanted }) }
    }
}
