//! Zoom and pan of the picture in the viewport.
//!
//! In: sizes of picture and viewport. Out: conversions between their coordinates. Viewport positions are in its own
//! units, from its upper left corner.

use crate::space::{FrameSize, ImagePoint, ScreenPoint};
use glam::DVec2;

/// Minimum and maximum size of a picture's pixel in viewport units.
const LIMITS: [f64; 2] = [0.02, 64.0];

/// Margin around a fitted picture.
const MARGIN: f64 = 16.0;

/// The view transform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Zoom {
    /// Fits the whole picture, following the viewport's size.
    #[default]
    Fit,
    /// A fixed scale, with this point of the picture in the middle of the viewport.
    At {
        /// Viewport units per pixel.
        scale: f64,
        /// The centre in pixels of the picture.
        center: DVec2,
    },
}

/// A picture placed in a viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lens {
    /// Size of the picture.
    pub(crate) frame: FrameSize,
    /// Size of the viewport.
    pub(crate) viewport: DVec2,
    scale: f64,
    /// Viewport position of the picture's upper left corner.
    origin: DVec2,
}

impl Zoom {
    /// Places the picture in a viewport of this size.
    #[must_use]
    pub(crate) fn lens(self, frame: FrameSize, viewport: DVec2) -> Lens {
        let picture = DVec2::new(f64::from(frame.width) * frame.pixel_aspect, f64::from(frame.height));
        let (scale, center) = match self {
            Self::Fit => {
                let room = (viewport - 2.0 * MARGIN).max(DVec2::ONE);
                ((room / picture).min_element().clamp(LIMITS[0], LIMITS[1]), 0.5 * picture)
            }
            Self::At { scale, center } => (scale, center),
        };
        Lens { frame, viewport, scale, origin: 0.5 * viewport - center * scale }
    }

    /// Zooms by a factor around a fixed viewport position.
    #[must_use]
    pub(crate) fn zoomed(self, lens: &Lens, at: DVec2, factor: f64) -> Self {
        let scale = (lens.scale * factor).clamp(LIMITS[0], LIMITS[1]);
        let fixed = (at - lens.origin) / lens.scale;
        Self::At { scale, center: fixed - (at - 0.5 * lens.viewport) / scale }
    }

    /// Pans by an offset in viewport units.
    #[must_use]
    pub(crate) fn panned(self, lens: &Lens, by: DVec2) -> Self {
        let center = (0.5 * lens.viewport - lens.origin - by) / lens.scale;
        Self::At { scale: lens.scale, center }
    }

    /// Zooms to viewport units per pixel; the centre stays fixed.
    #[must_use]
    pub(crate) fn at_scale(self, lens: &Lens, scale: f64) -> Self {
        self.zoomed(lens, 0.5 * lens.viewport, scale / lens.scale)
    }
}

impl Lens {
    /// Returns the viewport units per pixel of the picture.
    #[must_use]
    pub(crate) const fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the viewport units per frame height.
    #[must_use]
    pub(crate) fn frame_height(&self) -> f64 {
        self.scale * f64::from(self.frame.height)
    }

    /// Converts a screen point to a viewport position.
    #[must_use]
    pub(crate) fn viewport_from_screen(&self, point: ScreenPoint) -> DVec2 {
        let ImagePoint(pixel) = self.frame.image_from_screen(point);
        self.origin + pixel * DVec2::new(self.frame.pixel_aspect, 1.0) * self.scale
    }

    /// Converts a viewport position to a screen point.
    #[must_use]
    pub(crate) fn screen_from_viewport(&self, at: DVec2) -> ScreenPoint {
        let pixel = (at - self.origin) / self.scale / DVec2::new(self.frame.pixel_aspect, 1.0);
        self.frame.screen_from_image(ImagePoint(pixel))
    }

    /// Returns the upper left and lower right corners of the picture in the viewport.
    #[must_use]
    pub(crate) fn corners(&self) -> [DVec2; 2] {
        let size = DVec2::new(f64::from(self.frame.width) * self.frame.pixel_aspect, f64::from(self.frame.height));
        [self.origin, self.origin + size * self.scale]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: FrameSize = FrameSize::new(1920, 1080);

    #[test]
    fn a_fitted_picture_is_whole_in_any_viewport() {
        for viewport in [[2000.0, 300.0], [300.0, 2000.0], [960.0, 540.0]].map(DVec2::from) {
            let [low, high] = Zoom::Fit.lens(FRAME, viewport).corners();
            assert!(low.min_element() >= MARGIN - 1e-9 && (viewport - high).min_element() >= MARGIN - 1e-9);
            assert!((low + high - viewport).length() < 1e-9, "it lies in the middle");
        }
    }

    #[test]
    fn zooming_keeps_what_lies_under_the_pointer() {
        let (viewport, at) = (DVec2::new(800.0, 600.0), DVec2::new(100.0, 500.0));
        let mut zoom = Zoom::Fit;
        for factor in [1.5, 3.0, 0.2, 7.0] {
            let lens = zoom.lens(FRAME, viewport);
            let under = lens.screen_from_viewport(at);
            zoom = zoom.zoomed(&lens, at, factor);
            let lens = zoom.lens(FRAME, viewport);
            assert!((lens.viewport_from_screen(under) - at).length() < 1e-6);
            assert!((lens.screen_from_viewport(lens.viewport_from_screen(under)) - under).0.length() < 1e-12);
        }
        let lens = zoom.lens(FRAME, viewport);
        let moved = zoom.panned(&lens, DVec2::new(30.0, -20.0)).lens(FRAME, viewport);
        let place = |lens: &Lens| lens.viewport_from_screen(ScreenPoint::new(0.5, 0.5));
        assert!((place(&moved) - place(&lens) - DVec2::new(30.0, -20.0)).length() < 1e-9);
        assert!((zoom.at_scale(&lens, 1.0).lens(FRAME, viewport).scale() - 1.0).abs() < 1e-12);
    }
}
