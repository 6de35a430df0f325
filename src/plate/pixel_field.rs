//! A field in pixels of a frame: points and offsets, y down.
//!
//! In: a [`Field`] and the size of the frame. Out: the offset of any point, either way, with its slopes.

use super::Field;
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenVector};
use glam::{DMat2, DVec2};

/// Which way a map tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// Where a point came from.
    Backward,
    /// Where a point goes.
    Forward,
}

/// What a map holds at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Pixels to add to the point.
    pub(super) offset: DVec2,
    /// Change of the offset a pixel to the right (first column) and down (second).
    pub(super) slope: DMat2,
}

impl Node {
    pub(super) fn is_still(self) -> bool {
        self.offset == DVec2::ZERO && self.slope == DMat2::ZERO
    }
}

/// A field, a frame and a direction.
#[derive(Clone, Copy)]
pub(super) struct PixelField<'a> {
    pub(super) field: &'a Field,
    pub(super) frame: FrameSize,
    pub(super) direction: Direction,
}

impl PixelField<'_> {
    /// Pixels a frame height, y turned over.
    fn scale(self) -> DVec2 {
        let up = self.frame.pixels_from_screen(ScreenVector::new(1.0, 1.0));
        DVec2::new(up.x, -up.y)
    }

    fn screen(self, pixel: DVec2) -> DVec2 {
        self.frame.screen_from_image(ImagePoint(pixel)).0
    }

    /// How far a point of the unwarped picture moves, in pixels, and the gradient of the field there.
    pub(super) fn displace(self, pixel: DVec2) -> (DVec2, DMat2) {
        let (moved, gradient) = self.field.displace(self.screen(pixel));
        (moved * self.scale(), self.pixels(gradient))
    }

    /// The map at a point, looked for from the offset `start` on; `None` where it is not found.
    pub(super) fn solve(self, pixel: DVec2, start: DVec2) -> Option<Node> {
        if self.direction == Direction::Forward {
            let (offset, gradient) = self.displace(pixel);
            return offset.is_finite().then_some(Node { offset, slope: gradient - DMat2::IDENTITY });
        }
        let (offset, gradient) = self.field.back(self.screen(pixel), start / self.scale())?;
        let slope =
            if gradient == DMat2::IDENTITY { DMat2::ZERO } else { self.pixels(gradient).inverse() - DMat2::IDENTITY };
        slope.is_finite().then_some(Node { offset: offset * self.scale(), slope })
    }

    /// How far an offset is from the right one, to first order, in pixels.
    pub(super) fn residual(self, pixel: DVec2, offset: DVec2) -> f64 {
        if self.direction == Direction::Forward {
            return (self.displace(pixel).0 - offset).length();
        }
        let (moved, gradient) = self.displace(pixel + offset);
        (gradient.inverse() * (offset + moved)).length()
    }

    /// Whether the map is one smooth piece between four points, given with their nodes.
    pub(super) fn is_smooth(self, corners: &[(DVec2, Node); 4]) -> bool {
        let source = corners.map(|(pixel, node)| match self.direction {
            Direction::Backward => self.screen(pixel + node.offset),
            Direction::Forward => self.screen(pixel),
        });
        self.field.is_smooth_between(source)
    }

    /// Pixels between places at which the field has to be looked at in order to see all that it does: a quarter of the
    /// finest spacing.
    pub(super) fn finest_step(self) -> f64 {
        let scale = self.scale().abs();
        self.field.spacings().map(|spacing| (spacing * scale).min_element()).fold(f64::INFINITY, f64::min) / 4.0
    }

    /// No point moves further, in pixels an axis.
    pub(super) fn max_displacement(self) -> DVec2 {
        self.scale().abs() * self.field.max_displacement()
    }

    /// A gradient of the screen in pixels.
    fn pixels(self, gradient: DMat2) -> DMat2 {
        let scale = self.scale();
        DMat2::from_cols(gradient.x_axis * scale / scale.x, gradient.y_axis * scale / scale.y)
    }
}

/// Upper left corner of a window.
pub(super) fn corner(window: PixelRect) -> DVec2 {
    DVec2::new(f64::from(window.x), f64::from(window.y))
}

/// Width and height of a window.
pub(super) fn extent(window: PixelRect) -> DVec2 {
    DVec2::new(f64::from(window.width), f64::from(window.height))
}

/// Centre of a pixel.
pub(super) fn center(x: i32, y: i32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}
