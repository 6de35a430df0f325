//! The warp of a picture given by its surfaces, drawn before and after: for layers that share meshes, whose warps
//! blend along the surface and so are no function of the screen position alone.
//!
//! In: a [`SurfacePicture`] of each. Out: maps in both directions.

use super::{SurfacePicture, WarpMap};
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenPoint};
use glam::{DMat2, DVec2};

/// A warp, sampled at the pixels of a frame.
#[derive(Debug, PartialEq)]
pub(super) struct SurfaceField {
    /// The source of every pixel of the warped picture; NaN where no surface is visible.
    backward: WarpMap,
    /// The target of every pixel of the unwarped picture; NaN where there is no surface.
    forward: WarpMap,
}

impl SurfaceField {
    /// Creates the field from the pictures before and after the warp.
    pub(super) fn of([unwarped, warped]: [&SurfacePicture; 2], frame: FrameSize) -> Self {
        Self { backward: WarpMap::between(warped, unwarped, frame), forward: unwarped.displacements(frame) }
    }

    /// Returns the source of every pixel of a window.
    pub(super) fn backward_over(&self, window: PixelRect) -> WarpMap {
        self.backward.cropped(window)
    }

    /// Returns the target of every pixel of a window.
    pub(super) fn forward_over(&self, window: PixelRect) -> WarpMap {
        self.forward.cropped(window)
    }

    /// Returns the displacement at the pixel that contains a point, and the gradient of the map there; the identity
    /// where there is no surface. Frame heights, y up.
    pub(super) fn displace(&self, point: DVec2) -> (DVec2, DMat2) {
        let WarpMap { frame, window, offsets, .. } = &self.forward;
        let pixel = frame.image_from_screen(ScreenPoint(point)).0.floor().as_ivec2();
        let index = window.sample_index(pixel.to_array()).filter(|&index| !offsets[index][0].is_nan());
        let Some(index) = index else { return (DVec2::ZERO, DMat2::IDENTITY) };
        let center = pixel.as_dvec2() + 0.5;
        let moved = center + DVec2::from(offsets[index].map(f64::from));
        let [from, to] = [center, moved].map(|place| frame.screen_from_image(ImagePoint(place)).0);
        let [[a, b], [c, d]] = self.forward.jacobian(index).map(|row| row.map(f64::from));
        let aspect = frame.pixel_aspect;
        // Columns are the derivatives along x and y; image rows run down.
        (to - from, DMat2::from_cols(DVec2::new(a, -c / aspect), DVec2::new(-b * aspect, d)))
    }

    /// Returns the largest displacement, in frame heights.
    pub(super) fn max_displacement(&self) -> f64 {
        let WarpMap { frame, offsets, .. } = &self.forward;
        let longest = offsets.iter().map(|[x, y]| f64::from(x.hypot(*y))).filter(|length| length.is_finite());
        longest.fold(0.0, f64::max) * frame.pixel_aspect.max(1.0) / f64::from(frame.height)
    }

    /// Returns the bounds of the pixels that show some of a window.
    pub(super) fn warped_window(&self, source: PixelRect) -> PixelRect {
        let WarpMap { window, .. } = &self.backward;
        let shows = |&index: &usize| {
            let [x, y] = window.pixel_at(index);
            self.backward
                .source(x, y)
                .is_some_and(|[x, y]| source.sample_index([x, y].map(|at| at.floor() as i32)).is_some())
        };
        let shown = (0..window.area()).filter(shows).map(|index| {
            let [x, y] = window.pixel_at(index);
            PixelRect { x, y, width: 1, height: 1 }
        });
        shown.reduce(PixelRect::union).unwrap_or(PixelRect { width: 0, height: 0, ..source })
    }
}
