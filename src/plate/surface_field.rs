//! The warp of a picture given by its surfaces, drawn before and after: for layers that share meshes, whose warps
//! blend along the surface and so are no function of the screen position alone.
//!
//! In: a [`SurfacePicture`] of each. Out: maps in both directions.

use super::{SurfacePicture, WarpMap};
use crate::space::{FrameSize, ImagePoint, PixelRect, ScreenPoint};
use glam::{DMat2, DVec2};
use rayon::prelude::*;
use std::sync::OnceLock;

/// A warp, sampled at the pixels of a frame.
#[derive(Debug, PartialEq)]
pub(super) struct SurfaceField {
    /// The picture before the warp, and after it.
    pictures: [SurfacePicture; 2],
    /// The target of every pixel of the unwarped picture; NaN where there is no surface.
    forward: WarpMap,
    /// The source of every pixel of the warped picture, NaN where no surface is visible; computed on first use, since
    /// the fields of neighbouring frames are only followed forward.
    backward: OnceLock<WarpMap>,
    /// The largest displacement, in frame heights.
    max_displacement: f64,
}

impl SurfaceField {
    /// Creates the field from the pictures before and after the warp.
    pub(super) fn of(pictures: [SurfacePicture; 2], frame: FrameSize) -> Self {
        let forward = pictures[0].displacements(frame);
        let lengths =
            forward.offsets.par_iter().map(|[x, y]| f64::from(x.hypot(*y))).filter(|length| length.is_finite());
        let longest = lengths.reduce(|| 0.0, f64::max);
        let max_displacement = longest * frame.pixel_aspect.max(1.0) / f64::from(frame.height);
        Self { pictures, forward, backward: OnceLock::new(), max_displacement }
    }

    fn backward(&self) -> &WarpMap {
        let [unwarped, warped] = &self.pictures;
        self.backward.get_or_init(|| WarpMap::between(warped, unwarped, self.forward.frame))
    }

    /// Returns the source of every pixel of a window.
    pub(super) fn backward_over(&self, window: PixelRect) -> WarpMap {
        self.backward().cropped(window)
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
    pub(super) const fn max_displacement(&self) -> f64 {
        self.max_displacement
    }

    /// Returns the bounds of the pixels that show some of a window.
    pub(super) fn warped_window(&self, source: PixelRect) -> PixelRect {
        let backward = self.backward();
        let window = backward.window;
        let shows = |&index: &usize| {
            let [x, y] = window.pixel_at(index);
            backward
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_is_only_followed_forward_computes_no_sources() {
        let frame = FrameSize::new(8, 4);
        let moved = |by: f32| SurfacePicture {
            window: frame.window(),
            objects: vec![1.0; 32],
            depths: vec![2.0; 32],
            offsets: vec![[by, 0.0]; 32],
        };
        let field = SurfaceField::of([moved(2.0), moved(-2.0)], frame);
        assert_eq!(field.max_displacement(), 0.5);
        assert_eq!(field.forward_over(frame.window()).offsets[9], [2.0, 0.0]);
        assert!((field.displace(DVec2::new(1.0, 0.5)).0 - DVec2::new(0.5, 0.0)).length() < 1e-9);
        assert!(field.backward.get().is_none());
        assert_eq!(field.backward_over(frame.window()).source(5, 2), Some([3.5, 2.5]));
        assert!(field.backward.get().is_some());
    }
}
