//! A frame as displayed by the viewer.
//!
//! In: a [`Frame`]. Out: 8-bit pixels, as in the previews of a render, premultiplied.

use crate::image::{Frame, Preview, preview};

/// How close a picture is to the rendered frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// One sample per pixel, possibly at reduced resolution. If layers are solved over time, this frame may have been
    /// solved in isolation.
    Provisional,
    /// One sample per pixel, possibly at reduced resolution, of the final solve.
    Draft,
    /// The rendered frame.
    Final,
}

/// A drawn frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Frame number.
    pub frame: i32,
    /// Revision of the document that it shows.
    pub revision: u64,
    /// How close it is to the rendered frame.
    pub quality: Quality,
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Premultiplied red, green, blue and alpha of each pixel; rows from the top.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// Converts a frame for display.
    #[must_use]
    pub fn of(frame: &Frame, (number, revision): (i32, u64), quality: Quality) -> Self {
        let Preview { width, height, mut rgba } = preview(frame);
        for pixel in rgba.chunks_exact_mut(4).filter(|pixel| pixel[3] < u8::MAX) {
            let alpha = u16::from(pixel[3]);
            pixel[..3].iter_mut().for_each(|code| *code = ((u16::from(*code) * alpha + 127) / 255) as u8);
        }
        Self { frame: number, revision, quality, size: [width as usize, height as usize], rgba }
    }
}
