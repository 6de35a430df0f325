//! A field in pixel coordinates of a frame, y down.
//!
//! In: a [`Field`] and the size of the frame. Out: the offset at any point and its slopes, in either direction.

use super::Field;
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenVector};
use glam::{DMat2, DVec2, IVec2};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Direction of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// From a point to its source.
    Backward,
    /// From a point to its target.
    Forward,
}

/// The value of a map at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Offset to add to the point, in pixels.
    pub(super) offset: DVec2,
    /// Change of the offset per pixel to the right (first column) and down (second).
    pub(super) slope: DMat2,
}

impl Node {
    pub(super) fn is_still(self) -> bool {
        self.offset == DVec2::ZERO && self.slope == DMat2::ZERO
    }
}

/// A field with a frame and a direction.
#[derive(Clone, Copy)]
pub(super) struct PixelField<'a> {
    pub(super) field: &'a Field,
    pub(super) frame: FrameSize,
    pub(super) direction: Direction,
}

impl PixelField<'_> {
    /// Pixels per frame height, with y flipped.
    fn scale(self) -> DVec2 {
        let up = self.frame.pixels_from_screen(ScreenVector::new(1.0, 1.0));
        DVec2::new(up.x, -up.y)
    }

    fn screen(self, pixel: DVec2) -> DVec2 {
        self.frame.screen_from_image(ImagePoint(pixel)).0
    }

    /// Returns the displacement of a point of the unwarped picture, in pixels, and the gradient of the field there.
    pub(super) fn displace(self, pixel: DVec2) -> (DVec2, DMat2) {
        let (moved, gradient) = self.field.displace(self.screen(pixel));
        (moved * self.scale(), self.pixels(gradient))
    }

    /// Solves for the map at a point, starting from the offset `start`; `None` if the search fails.
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

    /// Estimates the error of an offset to first order, in pixels.
    pub(super) fn residual(self, pixel: DVec2, offset: DVec2) -> f64 {
        if self.direction == Direction::Forward {
            return (self.displace(pixel).0 - offset).length();
        }
        let (moved, gradient) = self.displace(pixel + offset);
        (gradient.inverse() * (offset + moved)).length()
    }

    /// Whether the map is smooth on the quadrilateral of four points, given with their nodes.
    pub(super) fn is_smooth(self, corners: &[(DVec2, Node); 4]) -> bool {
        let source = corners.map(|(pixel, node)| match self.direction {
            Direction::Backward => self.screen(pixel + node.offset),
            Direction::Forward => self.screen(pixel),
        });
        self.field.is_smooth_between(source)
    }

    /// Returns the sampling distance, in pixels, that resolves all features of the field: a quarter of the finest spacing.
    pub(super) fn finest_step(self) -> f64 {
        let scale = self.scale().abs();
        self.field.spacings().map(|spacing| (spacing * scale).min_element()).fold(f64::INFINITY, f64::min) / 4.0
    }

    /// Returns the pixels on and around which the pixels of a window land flipped, of those that are shown. `is_shown`: for an index
    /// into the window.
    pub(super) fn flipped_targets(
        self,
        window: PixelRect,
        is_shown: impl Fn(usize) -> bool + Sync,
    ) -> BTreeSet<[i32; 2]> {
        let target = |source: usize| {
            if !is_shown(source) {
                return None;
            }
            let [x, y] = window.pixel_at(source);
            let (moved, gradient) = self.displace(center(x, y));
            (gradient.determinant() < 0.0).then(|| (center(x, y) + moved).floor().as_ivec2())
        };
        let targets: Vec<IVec2> = (0..window.area()).into_par_iter().filter_map(target).collect();
        targets.into_iter().flat_map(|at| (0..9).map(move |k| [at.x + k % 3 - 1, at.y + k / 3 - 1])).collect()
    }

    /// Upper bound of the displacement, in pixels per axis.
    pub(super) fn max_displacement(self) -> DVec2 {
        self.scale().abs() * self.field.max_displacement()
    }

    /// Converts a gradient from screen to pixel coordinates.
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
