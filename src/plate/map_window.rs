//! Computes the data window of a warped picture.
//!
//! In: a [`Field`], the frame and a data window. Out: the window of all pixels that can receive part of the picture.

use super::Field;
use super::map_mesh::WarpedMesh;
use super::pixel_field::{Direction, PixelField, corner, extent};
use crate::space::{FrameSize, PixelRect};
use glam::DVec2;

/// Tolerance in pixels, so that shifts by whole pixels stay exact.
const SLIVER: f64 = 1e-3;
/// Sample points of a folded cell per axis.
const FINE: usize = 33;

impl Field {
    /// Returns the data window after the warp: all pixels that `window` (relative to the display window) reaches. It is
    /// limited to the frame extended by its own size on every side, unless `window` itself reaches further.
    #[must_use]
    pub(crate) fn warped_window(&self, frame: FrameSize, window: PixelRect) -> PixelRect {
        if window.area() == 0 || self.is_identity() {
            return window;
        }
        if let Some(surfaces) = self.surfaces() {
            return surfaces.warped_window(window);
        }
        let pixel_field = PixelField { field: self, frame, direction: Direction::Forward };
        let (lo, hi) = (corner(window), corner(window) + extent(window));
        let image = |point: DVec2| point + pixel_field.displace(point).0;
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let folded = (!self.is_one_to_one()).then(|| folded_points(pixel_field, lo, hi)).into_iter().flatten();
        // Without folds, the border of the image is the image of the border.
        for point in border(window).map(image).chain(folded.map(image)) {
            if !point.is_finite() {
                return window;
            }
            (least, most) = (least.min(point), most.max(point));
        }
        let frame = DVec2::new(f64::from(frame.width), f64::from(frame.height));
        let (left, right) = ((least + SLIVER).floor(), (most - SLIVER).ceil());
        rect(left.max(lo.min(-frame)), right.min(hi.max(2.0 * frame)))
    }
}

/// Returns the corners of all pixels along the border of a window.
fn border(window: PixelRect) -> impl Iterator<Item = DVec2> {
    let (lo, size) = (corner(window), extent(window));
    let across = (0..=window.width).flat_map(move |x| [0.0, size.y].map(|y| DVec2::new(f64::from(x), y)));
    let down = (0..=window.height).flat_map(move |y| [0.0, size.x].map(|x| DVec2::new(x, f64::from(y))));
    across.chain(down).map(move |place| lo + place)
}

/// Returns the sample points of all cells between two corners that may flip.
fn folded_points(pixel_field: PixelField, lo: DVec2, hi: DVec2) -> impl Iterator<Item = DVec2> {
    let mesh = WarpedMesh::over(pixel_field, lo, hi);
    let step = mesh.step / (FINE - 1) as f64;
    mesh.folded().into_iter().flat_map(move |cell| {
        let start = mesh.point(cell);
        (0..FINE * FINE).map(move |k| start + step * DVec2::new((k % FINE) as f64, (k / FINE) as f64))
    })
}

/// Returns the pixels between two corners; empty if the corners are out of order.
fn rect(lo: DVec2, hi: DVec2) -> PixelRect {
    let size = (hi - lo).max(DVec2::ZERO);
    PixelRect { x: lo.x as i32, y: lo.y as i32, width: size.x as u32, height: size.y as u32 }
}
