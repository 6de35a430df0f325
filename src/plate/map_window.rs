//! The data window of a warped picture.
//!
//! In: a [`Field`], the frame and a data window. Out: all pixels that can receive anything of it.

use super::Field;
use super::map_mesh::WarpedMesh;
use super::pixel_field::{Direction, PixelField, corner, extent};
use crate::space::{FrameSize, PixelRect};
use glam::DVec2;

/// Less than this of the picture does not touch a pixel, in pixels: shifts by whole pixels stay whole.
const SLIVER: f64 = 1e-3;
/// Points of a folded cell, an axis.
const FINE: usize = 33;

impl Field {
    /// The data window after the warp: all pixels that `window` (relative to the display window) reaches. Cut to the
    /// frame and as much again on every side, unless `window` itself reaches further.
    #[must_use]
    pub fn warped_window(&self, frame: FrameSize, window: PixelRect) -> PixelRect {
        if window.area() == 0 || self.is_identity() {
            return window;
        }
        let pixel_field = PixelField { field: self, frame, direction: Direction::Forward };
        let (lo, hi) = (corner(window), corner(window) + extent(window));
        let image = |point: DVec2| point + pixel_field.displace(point).0;
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let folded = (!self.is_one_to_one()).then(|| folded_points(pixel_field, lo, hi)).into_iter().flatten();
        // The image of a picture that does not fold ends at the image of its border.
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

/// Corners of all pixels along the border of a window.
fn border(window: PixelRect) -> impl Iterator<Item = DVec2> {
    let (lo, size) = (corner(window), extent(window));
    let across = (0..=window.width).flat_map(move |x| [0.0, size.y].map(|y| DVec2::new(f64::from(x), y)));
    let down = (0..=window.height).flat_map(move |y| [0.0, size.x].map(|x| DVec2::new(x, f64::from(y))));
    across.chain(down).map(move |place| lo + place)
}

/// Points of all cells between two corners that may turn over.
fn folded_points(pixel_field: PixelField, lo: DVec2, hi: DVec2) -> impl Iterator<Item = DVec2> {
    let mesh = WarpedMesh::over(pixel_field, lo, hi);
    let step = mesh.step / (FINE - 1) as f64;
    mesh.folded().into_iter().flat_map(move |cell| {
        let start = mesh.point(cell);
        (0..FINE * FINE).map(move |k| start + step * DVec2::new((k % FINE) as f64, (k / FINE) as f64))
    })
}

/// The pixels between two corners; none where they do not lie so.
fn rect(lo: DVec2, hi: DVec2) -> PixelRect {
    let size = (hi - lo).max(DVec2::ZERO);
    PixelRect { x: lo.x as i32, y: lo.y as i32, width: size.x as u32, height: size.y as u32 }
}
