//! A frame as a viewer shows it.
//!
//! In: a [`Frame`]. Out: 8-bit pixels, as the previews of a render have them, alpha multiplied in.

use crate::image::{Frame, Preview, preview};

/// How near to the rendered frame a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quality {
    /// One sample a pixel, and perhaps fewer pixels. Where layers are solved over time, this frame may have been solved alone.
    Provisional,
    /// One sample a pixel, and perhaps fewer pixels, of the solve that is rendered.
    Draft,
    /// The rendered frame.
    Final,
}

/// A drawn frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Number of the frame.
    pub frame: i32,
    /// Change of the document that it shows.
    pub revision: u64,
    /// How near to the rendered frame it is.
    pub quality: Quality,
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Red, green, blue, alpha of each pixel, multiplied by alpha; rows from the top.
    pub rgba: Vec<u8>,
}

impl Picture {
    /// A frame, to be shown.
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
