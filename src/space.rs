//! The coordinate spaces of the program, with one type each, so that a point of one space cannot be passed for another.
//!
//! [`FrameSize`] converts between screen and image, `uv_from_screen` and `screen_from_uv` between the screen and the UVs of a
//! picture over the whole frame. Only STMaps and the coordinates of hosts flip y elsewhere (docs/CONVENTIONS.md).

mod window;

pub use window::PixelRect;
pub(crate) use window::{around, with_neighbours};

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec3};
use serde::{Deserialize, Serialize};
use std::ops::{Add, Sub};

/// A point in scene space (that of glTF: right-handed, y up, metres).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct ScenePoint(pub Vec3);

/// A direction or displacement in scene space, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct SceneVector(pub Vec3);

/// A point in screen space: x right, y up, unit = frame height, origin at the lower left of the display window.
///
/// Points and vectors are separate types, and so are screen points and image points:
/// ```compile_fail
/// use pinwarp::space::{ImagePoint, ScreenPoint};
/// let wrong: ScreenPoint = ImagePoint::new(3.0, 4.0);
/// ```
/// ```compile_fail
/// use pinwarp::space::ScreenPoint;
/// let wrong = ScreenPoint::new(0.0, 0.0) + ScreenPoint::new(1.0, 1.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(transparent)]
pub struct ScreenPoint(pub DVec2);

/// A displacement in screen space, in frame heights, y up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, Serialize, Deserialize)]
#[repr(transparent)]
pub struct ScreenVector(pub DVec2);

/// A point in image space: pixels, y down, origin at the upper left corner of the display window, as in files. Pixel (i, j) has its
/// centre at (i + ½, j + ½).
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(transparent)]
pub struct ImagePoint(pub DVec2);

impl ScreenPoint {
    /// Creates the point (x, y), in frame heights.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self(DVec2::new(x, y))
    }
}

impl ScreenVector {
    /// Creates the displacement (x, y), in frame heights.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self(DVec2::new(x, y))
    }
}

impl ImagePoint {
    /// Creates the point (x, y), in pixels, y down.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self(DVec2::new(x, y))
    }
}

impl Sub for ScreenPoint {
    type Output = ScreenVector;

    fn sub(self, from: Self) -> ScreenVector {
        ScreenVector(self.0 - from.0)
    }
}

impl Add<ScreenVector> for ScreenPoint {
    type Output = Self;

    fn add(self, by: ScreenVector) -> Self {
        Self(self.0 + by.0)
    }
}

/// An axis-aligned box in screen space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScreenBox {
    /// Lower left corner.
    pub min: ScreenPoint,
    /// Upper right corner.
    pub max: ScreenPoint,
}

impl ScreenBox {
    /// Creates the box with the given corners, in frame heights.
    #[must_use]
    pub(crate) const fn new(min: ScreenPoint, max: ScreenPoint) -> Self {
        Self { min, max }
    }

    /// Returns the bounding box of `points`; `None` if there are none.
    pub(crate) fn around(points: impl IntoIterator<Item = ScreenPoint>) -> Option<Self> {
        points.into_iter().map(|point| Self::new(point, point)).reduce(Self::union)
    }

    /// Returns the smallest box that contains both boxes.
    #[must_use]
    pub(crate) fn union(self, other: Self) -> Self {
        Self::new(ScreenPoint(self.min.0.min(other.min.0)), ScreenPoint(self.max.0.max(other.max.0)))
    }

    /// Returns the bounding box of the box with its corners moved.
    #[must_use]
    pub(crate) fn around_moved(self, moved: impl Fn(ScreenPoint) -> ScreenPoint) -> Self {
        let Self { min, max } = self;
        let others = [ScreenPoint::new(min.0.x, max.0.y), ScreenPoint::new(max.0.x, min.0.y), max];
        let at = |corner: ScreenPoint| Self::new(moved(corner), moved(corner));
        others.into_iter().map(at).fold(at(min), Self::union)
    }

    /// Returns width and height, in frame heights.
    #[must_use]
    pub(crate) fn size(self) -> DVec2 {
        self.max.0 - self.min.0
    }

    /// Returns the centre of the box.
    #[must_use]
    pub(crate) fn center(self) -> ScreenPoint {
        ScreenPoint((self.min.0 + self.max.0) * 0.5)
    }
}

/// A box of the screen that is rotated about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RotatedBox {
    /// The box before its rotation.
    pub upright: ScreenBox,
    /// Angle in radians, counter-clockwise.
    pub angle: f64,
}

impl From<ScreenBox> for RotatedBox {
    fn from(upright: ScreenBox) -> Self {
        Self { upright, angle: 0.0 }
    }
}

/// The display window: its size in pixels, which defines screen space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameSize {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Width of a pixel divided by its height.
    pub pixel_aspect: f64,
}

impl FrameSize {
    /// Creates a frame with square pixels.
    #[must_use]
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixel_aspect: 1.0 }
    }

    /// Scales the frame, rounding each side to whole pixels, at least one.
    #[cfg(any(test, feature = "cli"))]
    #[must_use]
    pub(crate) fn scaled(self, factor: f64) -> Self {
        let scaled = |length: u32| ((f64::from(length) * factor).round() as u32).max(1);
        Self { width: scaled(self.width), height: scaled(self.height), ..self }
    }

    /// Returns the width of the frame in frame heights (1.778 for a 16:9 frame).
    #[must_use]
    pub fn aspect(self) -> f64 {
        f64::from(self.width) * self.pixel_aspect / f64::from(self.height)
    }

    /// Whether this frame has the aspect ratio `aspect` (width / height), allowing for half a pixel of rounding on each
    /// side, as in a scaled picture.
    #[must_use]
    pub(crate) fn is_as_wide_as(self, aspect: f64) -> bool {
        let slack = 0.5 * (self.pixel_aspect + aspect) / f64::from(self.height);
        (self.aspect() - aspect).abs() <= slack + 1e-6
    }

    /// Converts a screen point to image space, which flips y.
    ///
    /// ```
    /// use pinwarp::space::{FrameSize, ImagePoint, ScreenPoint};
    /// let frame = FrameSize::new(1920, 1080);
    /// assert_eq!(frame.image_from_screen(ScreenPoint::new(0.0, 1.0)), ImagePoint::new(0.0, 0.0));
    /// ```
    #[must_use]
    pub fn image_from_screen(self, point: ScreenPoint) -> ImagePoint {
        let height = f64::from(self.height);
        ImagePoint::new(point.0.x * height / self.pixel_aspect, (1.0 - point.0.y) * height)
    }

    /// Converts an image point to screen space; the inverse of [`Self::image_from_screen`].
    #[must_use]
    pub fn screen_from_image(self, point: ImagePoint) -> ScreenPoint {
        let height = f64::from(self.height);
        ScreenPoint::new(point.0.x * self.pixel_aspect / height, 1.0 - point.0.y / height)
    }

    /// Converts a screen displacement to pixels, x right and **y up** (the convention of motion channels).
    #[must_use]
    pub(crate) fn pixels_from_screen(self, vector: ScreenVector) -> DVec2 {
        let height = f64::from(self.height);
        DVec2::new(vector.0.x * height / self.pixel_aspect, vector.0.y * height)
    }

    /// Returns the window that covers all pixels of the frame.
    #[must_use]
    pub const fn window(self) -> PixelRect {
        PixelRect { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Returns the frame with the window of all its pixels.
    #[must_use]
    pub const fn whole(self) -> FrameWindow {
        FrameWindow { frame: self, window: self.window() }
    }
}

/// A window of pixels, and the frame to which its coordinates relate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameWindow {
    /// The display window.
    pub frame: FrameSize,
    /// The pixels, relative to the upper left corner of the display window.
    pub window: PixelRect,
}

/// Converts a screen point to the UVs of a picture over a frame `aspect` wide: the unit square, u right, v **down**.
#[must_use]
pub(crate) fn uv_from_screen([x, y]: [f64; 2], aspect: f64) -> [f64; 2] {
    [x / aspect, 1.0 - y]
}

/// Converts UVs of a picture over a frame `aspect` wide to screen space; the inverse of [`uv_from_screen`].
#[must_use]
pub(crate) fn screen_from_uv([u, v]: [f64; 2], aspect: f64) -> [f64; 2] {
    [aspect * u, 1.0 - v]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uvs_begin_at_the_upper_left_corner_as_images_do() {
        let frame = FrameSize { width: 720, height: 576, pixel_aspect: 1.4222 };
        let image = ImagePoint::new(180.0, 144.0);
        let screen = frame.screen_from_image(image).0.to_array();
        let [u, v] = uv_from_screen(screen, frame.aspect());
        assert!((u - 0.25).abs() < 1e-12 && (v - 0.25).abs() < 1e-12, "{u} {v}");
        assert!((DVec2::from(screen_from_uv([u, v], frame.aspect())) - DVec2::from(screen)).length() < 1e-12);
    }

    #[test]
    fn screen_and_image_are_inverse_with_anamorphic_pixels() {
        let frame = FrameSize { width: 720, height: 576, pixel_aspect: 1.4222 };
        let point = ImagePoint::new(0.5, 575.5);
        let screen = frame.screen_from_image(point);
        assert!((screen.0 - DVec2::new(0.5 * 1.4222 / 576.0, 0.5 / 576.0)).length() < 1e-12);
        assert!((frame.image_from_screen(screen).0 - point.0).length() < 1e-9);
    }

    #[test]
    fn aspect_ratios_are_compared_with_half_a_pixel_of_rounding() {
        let shot = FrameSize::new(1920, 1081);
        assert!(FrameSize::new(960, 540).is_as_wide_as(shot.aspect()));
        assert!(!FrameSize::new(960, 544).is_as_wide_as(shot.aspect()));
    }
}
