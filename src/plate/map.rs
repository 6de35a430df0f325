//! Where every pixel of a warped picture comes from.
//!
//! In: a [`super::Field`], a window of pixels. Out: offsets, in pixels; NaN where nothing comes from.

use crate::space::{FrameSize, PixelRect};

/// Where every pixel of a window comes from (or goes to).
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMap {
    /// The display window that the screen is measured against.
    pub frame: FrameSize,
    /// The pixels that the map tells of, in image space; may lie partly outside the frame.
    pub window: PixelRect,
    /// #pixels of the window, rows from the top: what has to be added to a pixel's centre, in pixels, x right, y DOWN;
    /// NaN where nothing is seen. Exactly 0 where nothing moves.
    pub offsets: Vec<[f32; 2]>,
}

impl WarpMap {
    /// The map that moves nothing.
    #[must_use]
    pub fn identity(frame: FrameSize, window: PixelRect) -> Self {
        Self { frame, window, offsets: vec![[0.0; 2]; window.area()] }
    }
}
