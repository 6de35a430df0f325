//! A frame as displayed by the viewer.
//!
//! In: a [`Frame`]. Out: 8-bit pixels, as in the previews of a render, premultiplied.

use crate::image::{Frame, Preview, preview};
use std::borrow::Cow;

/// How close a picture is to the rendered frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Quality {
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
pub(crate) struct Picture {
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
    pub(crate) fn of(frame: &Frame, (number, revision): (i32, u64), quality: Quality) -> Self {
        let Preview { width, height, mut rgba } = preview(frame);
        for pixel in rgba.chunks_exact_mut(4).filter(|pixel| pixel[3] < u8::MAX) {
            let alpha = u16::from(pixel[3]);
            pixel[..3].iter_mut().for_each(|code| *code = ((u16::from(*code) * alpha + 127) / 255) as u8);
        }
        Self { frame: number, revision, quality, size: [width as usize, height as usize], rgba }
    }
    /// Returns whether the first and the last row are opaque, as in pictures that fill the frame.
    pub(super) fn is_opaque(&self) -> bool {
        let bytes = (4 * self.size[0]).min(self.rgba.len());
        let rows = [&self.rgba[..bytes], &self.rgba[self.rgba.len() - bytes..]];
        rows.into_iter().all(|row| row.chunks_exact(4).all(|pixel| pixel[3] == u8::MAX))
    }

    /// Returns size and pixels of the picture such that no side is longer than `longest` pixels: larger pictures are averaged
    /// over blocks.
    pub(super) fn within(&self, longest: usize) -> ([usize; 2], Cow<'_, [u8]>) {
        let [width, height] = self.size;
        let block = width.max(height).div_ceil(longest.max(1)).max(1);
        if block == 1 {
            return (self.size, Cow::Borrowed(&self.rgba));
        }
        let size = self.size.map(|side| side.div_ceil(block));
        let mut rgba = Vec::with_capacity(4 * size[0] * size[1]);
        for (y, x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y * block, x * block))) {
            let (mut sum, mut count) = ([0_u64; 4], 0);
            for row in y..(y + block).min(height) {
                let pixels = &self.rgba[4 * (row * width + x)..4 * (row * width + (x + block).min(width))];
                for pixel in pixels.chunks_exact(4) {
                    sum.iter_mut().zip(pixel).for_each(|(sum, code)| *sum += u64::from(*code));
                    count += 1;
                }
            }
            rgba.extend(sum.map(|sum| ((sum + count / 2) / count.max(1)) as u8));
        }
        (size, Cow::Owned(rgba))
    }
}

#[cfg(test)]
mod tests {
    use super::{Picture, Quality};

    #[test]
    fn pictures_larger_than_a_texture_are_averaged_over_blocks() {
        let codes = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90];
        let rgba = codes.into_iter().flat_map(|code| [code, 0, 0, 255]).collect();
        let picture = Picture { frame: 1, revision: 0, quality: Quality::Final, size: [5, 2], rgba };
        assert!(picture.is_opaque());
        let (size, rgba) = picture.within(5);
        assert_eq!((size, &*rgba), (picture.size, picture.rgba.as_slice()));
        let (size, rgba) = picture.within(3);
        assert_eq!((size, rgba.to_vec()), ([3, 1], vec![30, 0, 0, 255, 50, 0, 0, 255, 65, 0, 0, 255]));
    }
}
