//! A warp as a pixel map: the source of every pixel of a warped picture, or the target of every pixel of a picture.
//!
//! In: offsets, from a [`Field`](super::Field) or an STMap. Out: sources and Jacobians of pixels, and crops of the map.

use crate::space::{FrameSize, PixelRect};
use glam::DVec2;

/// Per-pixel sources (or targets) over a window.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMap {
    /// The display window that defines screen coordinates.
    pub frame: FrameSize,
    /// The pixels of the map, relative to the upper left corner of the DISPLAY window; may lie partly or wholly outside the frame.
    pub window: PixelRect,
    /// #pixels of the window, rows from the top: offset from the pixel centre, in pixels, x right, y DOWN. NaN where
    /// nothing is visible; exactly 0 where nothing moves.
    pub offsets: Vec<[f32; 2]>,
    /// Pixels of the window (ascending indices into `offsets`) at which the field is not one-to-one: several source
    /// points land there (backward), or the pixel lands on others (forward). In maps of branches, whose parts may pass in front of
    /// each other: where a part is turned over.
    pub folded_pixels: Vec<u32>,
}

/// Largest difference between neighbouring steps on one surface, in pixels per pixel; larger ones mark an edge between surfaces.
const MAX_DIFFERENCE: f32 = 0.5;

/// Smallest coverage at which a surface counts as visible at a pixel.
pub(super) const HALF: f32 = 0.5;

impl WarpMap {
    /// Returns the identity map.
    #[must_use]
    pub fn identity(frame: FrameSize, window: PixelRect) -> Self {
        Self { frame, window, offsets: vec![[0.0; 2]; window.area()], folded_pixels: Vec::new() }
    }

    /// Returns the source (or target) of pixel (x, y) of the display window, in pixels: the centre of pixel (i, j) is
    /// (i + .5, j + .5). `None` outside the window and where nothing is visible.
    #[must_use]
    pub fn source(&self, x: i32, y: i32) -> Option<[f64; 2]> {
        let column = usize::try_from(i64::from(x) - i64::from(self.window.x)).ok()?;
        let row = usize::try_from(i64::from(y) - i64::from(self.window.y)).ok()?;
        if column >= self.window.width as usize || row >= self.window.height as usize {
            return None;
        }
        let [dx, dy] = self.offsets[row * self.window.width as usize + column].map(f64::from);
        let source = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) + DVec2::new(dx, dy);
        source.is_finite().then_some(source.to_array())
    }

    /// Returns the derivative of the source position per output pixel at an index into `offsets`: `[row][column]`,
    /// column 0 for a step to the right, column 1 for a step DOWN, in pixels. Ignores steps across the edge of a
    /// surface; an isolated pixel gets the identity.
    #[must_use]
    pub(crate) fn jacobian(&self, index: usize) -> [[f32; 2]; 2] {
        let width = self.window.width as usize;
        let (column, row) = (index % width, index / width);
        let x = self.step(index, 1, (column, width));
        let y = self.step(index, width, (row, self.window.height as usize));
        [[1.0 + x[0], y[0]], [x[1], 1.0 + y[1]]]
    }

    /// Returns the change of the offset per pixel along an axis, from the neighbours. At the border of the map, the next change tells
    /// whether the only neighbour is on the same surface. `stride`: to the next of `count` pixels, `place`: of this pixel among them.
    ///
    /// The steepness of a filter's footprint (`src/plate/filter/footprint.rs`) differs and says why.
    fn step(&self, at: usize, stride: usize, (place, count): (usize, usize)) -> [f32; 2] {
        let change = |from: usize| {
            let [from, to] = [self.offsets[from], self.offsets[from + stride]];
            let change = [0, 1].map(|d| to[d] - from[d]);
            (change[0] + change[1]).is_finite().then_some(change)
        };
        let square = |v: [f32; 2]| v[0] * v[0] + v[1] * v[1];
        let [has_before, has_after] = [place > 0, place + 1 < count];
        let (near, other) = match (has_before, has_after) {
            (true, true) => (change(at - stride), change(at)),
            (false, true) => (change(at), if count > 2 { change(at + stride) } else { None }),
            (true, false) => (change(at - stride), if place > 1 { change(at - 2 * stride) } else { None }),
            (false, false) => (None, None),
        };
        match (near, other) {
            (Some(a), Some(b)) if square([a[0] - b[0], a[1] - b[1]]) > MAX_DIFFERENCE * MAX_DIFFERENCE => {
                if square(a) <= square(b) { a } else { b }
            }
            (Some(a), Some(b)) if has_before && has_after => [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])],
            (Some(only), _) => only,
            (None, Some(only)) if has_before && has_after => only,
            (None, _) => [0.0; 2],
        }
    }

    /// Returns the map over another window, undefined outside its own.
    pub(super) fn cropped(&self, window: PixelRect) -> Self {
        let place = |&index: &u32| window.sample_index(self.window.pixel_at(index as usize)).map(|index| index as u32);
        Self {
            frame: self.frame,
            window,
            offsets: self.window.resized_samples(&self.offsets, window, [f32::NAN; 2]),
            folded_pixels: self.folded_pixels.iter().filter_map(place).collect(),
        }
    }
}

/// Returns the pixel whose centre is nearest to the source of a pixel; `None` where nothing is visible.
pub(super) fn nearest_source(pixel: [i32; 2], offset: [f32; 2]) -> Option<[i32; 2]> {
    let [x, y] = [0, 1].map(|axis| (f64::from(offset[axis]) + 0.5).floor() + f64::from(pixel[axis]));
    (x.abs() < 1e9 && y.abs() < 1e9).then_some([x as i32, y as i32])
}
