//! Conversion between the image coordinates of hosts with y up and our own; the only module that knows both.
//!
//! In: the host's points and rectangles. Out: ours, and the inverse.

use crate::space::{FrameSize, PixelRect, ScreenPoint};

/// Largest side of a picture, in pixels: a host's infinite regions are clamped to it.
const FURTHEST: f64 = 1e6;

/// The project's picture at a render scale. Rectangles are given as left, lower, right and upper edge.
///
/// ```text
/// canonical  x right, y up, square units of the full size, origin anywhere     parameters, regions
/// pixels     x right, y up; x = canonical x · scale / pixel aspect             images, windows
/// ours       screen points, and image space (y down), of the project's picture [`crate::space`]
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HostFrame {
    /// The picture in pixels at this scale; its pixel aspect accounts for different scales in x and y.
    pub frame: FrameSize,
    /// The lower left pixel of the picture.
    origin: [i32; 2],
    /// Pixels per canonical unit.
    pixels: [f64; 2],
}

impl HostFrame {
    /// Creates the frame of a picture that fills a canonical region, with pixels `aspect` times as wide as high, at
    /// `scale` of its full size.
    #[must_use]
    pub(crate) fn new(region: [f64; 4], aspect: f64, scale: [f64; 2]) -> Self {
        let [x1, y1, x2, y2] = region;
        let pixels = [scale[0] / aspect, scale[1]];
        let side = |length: f64| length.round().clamp(1.0, FURTHEST) as u32;
        let frame = FrameSize {
            width: side((x2 - x1) * pixels[0]),
            height: side((y2 - y1) * pixels[1]),
            pixel_aspect: pixels[1] / pixels[0],
        };
        let origin = [(x1 * pixels[0]).round() as i32, (y1 * pixels[1]).round() as i32];
        Self { frame, origin, pixels }
    }

    /// Converts a canonical point to screen coordinates.
    #[must_use]
    pub(crate) fn screen(&self, [x, y]: [f64; 2]) -> ScreenPoint {
        let unit = f64::from(self.frame.height);
        let x = (x * self.pixels[0] - f64::from(self.origin[0])) * self.frame.pixel_aspect;
        ScreenPoint::new(x / unit, (y * self.pixels[1] - f64::from(self.origin[1])) / unit)
    }

    /// Converts a screen point to canonical coordinates.
    #[must_use]
    pub(crate) fn canonical(&self, ScreenPoint(point): ScreenPoint) -> [f64; 2] {
        let unit = f64::from(self.frame.height);
        let x = point.x * unit / self.frame.pixel_aspect + f64::from(self.origin[0]);
        [x / self.pixels[0], (point.y * unit + f64::from(self.origin[1])) / self.pixels[1]]
    }

    /// Returns the height of the picture in canonical units, which are pixels of its full size.
    #[must_use]
    pub(crate) fn canonical_height(&self) -> f64 {
        f64::from(self.frame.height) / self.pixels[1]
    }

    /// Returns the whole picture as a canonical region.
    #[must_use]
    pub(crate) fn canonical_region(&self) -> [f64; 4] {
        self.region(self.frame.window())
    }

    /// Returns the position of this picture's upper left pixel in the image space of another.
    #[must_use]
    pub(crate) const fn corner_in(&self, other: &Self) -> [i32; 2] {
        let top = other.frame.height as i32 + other.origin[1] - self.frame.height as i32 - self.origin[1];
        [self.origin[0] - other.origin[0], top]
    }

    /// Converts a rectangle of host pixels to image space.
    #[must_use]
    pub(crate) fn window(&self, [x1, y1, x2, y2]: [i32; 4]) -> PixelRect {
        let top = i64::from(self.frame.height) - (i64::from(y2) - i64::from(self.origin[1]));
        PixelRect {
            x: x1.saturating_sub(self.origin[0]),
            y: i32::try_from(top).unwrap_or_default(),
            width: u32::try_from(i64::from(x2) - i64::from(x1)).unwrap_or(0),
            height: u32::try_from(i64::from(y2) - i64::from(y1)).unwrap_or(0),
        }
    }

    /// Converts a window of image space to host pixels; the inverse of [`Self::window`].
    #[must_use]
    pub(crate) const fn pixels(&self, window: PixelRect) -> [i32; 4] {
        let left = window.x + self.origin[0];
        let upper = self.frame.height as i32 - window.y + self.origin[1];
        [left, upper - window.height as i32, left + window.width as i32, upper]
    }

    /// Returns the pixels of image space that contain a canonical region.
    #[must_use]
    pub(crate) fn window_of(&self, region: [f64; 4]) -> PixelRect {
        let [x1, y1, x2, y2] = region.map(|edge| edge.clamp(-FURTHEST, FURTHEST));
        let [across, up] = self.pixels;
        self.window([
            (x1 * across).floor() as i32,
            (y1 * up).floor() as i32,
            (x2 * across).ceil() as i32,
            (y2 * up).ceil() as i32,
        ])
    }

    /// Converts a window of image space to a canonical region.
    #[must_use]
    pub(crate) fn region(&self, window: PixelRect) -> [f64; 4] {
        let left = f64::from(window.x) + f64::from(self.origin[0]);
        let top = f64::from(self.frame.height) - f64::from(window.y) + f64::from(self.origin[1]);
        let [x, y] = self.pixels;
        [left / x, (top - f64::from(window.height)) / y, (left + f64::from(window.width)) / x, top / y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PAL project in a corner of its host frame, at a scale that does not give integer pixels.
    fn host_frame() -> HostFrame {
        HostFrame::new([10.0, 20.0, 778.0, 596.0], 768.0 / 720.0, [0.3, 0.3])
    }

    #[test]
    fn points_go_to_the_screen_and_back() {
        let host_frame = host_frame();
        for point in [[10.0, 20.0], [400.5, 300.25], [-50.0, 900.0]] {
            let back = host_frame.canonical(host_frame.screen(point));
            assert!((0..2).all(|axis| (back[axis] - point[axis]).abs() < 1e-9), "{point:?} came back as {back:?}");
        }
        // The centre of the host's pixel (100, 50) is that of our pixel in image space.
        let pixel = host_frame.screen([100.5 * (768.0 / 720.0) / 0.3, 50.5 / 0.3]);
        let ours = host_frame.window([100, 50, 101, 51]);
        let image = host_frame.frame.image_from_screen(pixel);
        let error = image.0 - glam::DVec2::new(f64::from(ours.x) + 0.5, f64::from(ours.y) + 0.5);
        assert!(error.length() < 1e-9, "{error}");
    }

    #[test]
    fn regions_hold_their_windows_and_everywhere_is_cut() {
        let host_frame = host_frame();
        let window = PixelRect { x: -3, y: 7, width: 40, height: 25 };
        let [x1, y1, x2, y2] = host_frame.region(window);
        let slack = 1e-9;
        assert_eq!(host_frame.window(host_frame.pixels(window)), window);
        let inner = [x1 + slack, y1 + slack, x2 - slack, y2 - slack];
        assert_eq!(host_frame.window_of(inner), window);
        let everywhere = [f64::from(i32::MIN), f64::from(i32::MIN), 2e9, 2e9];
        assert!(host_frame.window_of(everywhere).width <= 700_000);
    }

    #[test]
    fn a_half_scale_frame_has_half_the_pixels_and_the_same_screen() {
        use crate::live::HostFrame;
        use crate::space::{PixelRect, ScreenPoint};
        let half = HostFrame::new([0.0, 0.0, 1920.0, 1080.0], 1.0, [0.5, 0.5]);
        assert_eq!((half.frame.width, half.frame.height), (960, 540));
        assert_eq!(half.screen([0.0, 1080.0]), ScreenPoint::new(0.0, 1.0));
        assert_eq!(half.window([0, 530, 960, 540]), PixelRect { x: 0, y: 0, width: 960, height: 10 });
    }
}
