//! Coverage: the fraction of every pixel that something covers.
//!
//! In: samples over a window, from a render or an alpha. Out: the coverage at any pixel of a picture of the same frame.

use crate::space::{FrameSize, PixelRect};

/// Coverage above this counts as complete, because filter weights sum to 1 only up to rounding.
pub(crate) const OPAQUE_COVERAGE: f32 = 1.0 - 1e-5;

/// The fraction of every pixel of a picture that something covers.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// Size of the display window.
    pub frame: FrameSize,
    /// Window of pixels with coverage, relative to the upper left corner of the display window.
    pub window: PixelRect,
    /// #pixels of the window, 0 to 1.
    pub samples: Vec<f32>,
}

impl Coverage {
    /// Returns the coverage of a pixel in a picture of `size` that shows the same frame; 0 outside the window.
    #[must_use]
    pub(crate) fn at(&self, pixel: [i32; 2], size: FrameSize) -> f32 {
        let scale = [
            f64::from(self.frame.width) / f64::from(size.width),
            f64::from(self.frame.height) / f64::from(size.height),
        ];
        let own = [0, 1].map(|axis| ((f64::from(pixel[axis]) + 0.5) * scale[axis]).floor() as i32);
        self.window.sample_index(own).map_or(0.0, |place| self.samples[place])
    }

    /// Resamples the coverage over a window of a picture of the given size, #pixels. Pixels outside the frame take the
    /// value of the nearest pixel inside.
    #[must_use]
    pub(crate) fn over(&self, window: PixelRect, size: FrameSize) -> Vec<f32> {
        let last = [size.width, size.height].map(|side| i32::try_from(side).unwrap_or(i32::MAX) - 1);
        let inside = |pixel: [i32; 2]| [0, 1].map(|axis| pixel[axis].clamp(0, last[axis].max(0)));
        (0..window.area()).map(|index| self.at(inside(window.pixel_at(index)), size)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_of_another_size_and_beyond_the_frame() {
        let frame = FrameSize::new(2, 1);
        let half = Coverage { frame, window: frame.window(), samples: vec![0.25, 0.75] };
        let twice = FrameSize::new(4, 2);
        let seen = half.over(twice.window().grown(1), twice);
        assert_eq!(seen, [0.25, 0.25, 0.25, 0.75, 0.75, 0.75].repeat(4));
        assert_eq!((half.at([3, 1], twice), half.at([4, 1], twice)), (0.75, 0.0));
    }
}
