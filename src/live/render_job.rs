//! What a host asks for: a window of a picture, with its mask and its background.
//!
//! In: plain values. Out: a [`Render`] whose planes fit.

use super::{LiveError, Mix, Picture};
use crate::plate::Filter;
use crate::space::{FrameSize, PixelRect};

/// What is rendered.
#[derive(Clone, Copy)]
pub struct Render<'a> {
    /// The display window, in pixels of this render (proxies have fewer).
    pub frame: FrameSize,
    /// The pixels that are wanted; may lie outside the frame.
    pub window: PixelRect,
    /// The picture that is warped; [`Warp::source_of`](super::Warp::source_of) tells how much of it is needed.
    pub source: &'a Picture<'a>,
    /// One plane, 0 to 1: what is moved. The rest of the picture stays. Where it has no samples nothing is moved.
    pub mask: Option<&'a Picture<'a>>,
    /// What is seen where something moved away, or the picture does not reach: as many planes as the source.
    pub background: Option<&'a Picture<'a>>,
    /// How it is resampled.
    pub filter: Filter,
    /// How much of the result is seen.
    pub mix: Mix<'a>,
    /// Asked now and then, by the thread that renders; true: the picture is not wanted any more.
    pub abort: &'a (dyn Fn() -> bool + Sync),
}

impl Render<'_> {
    /// Refuses planes that do not fit.
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
