//! Where every pixel of a warped picture comes from, or where every pixel of a picture goes.
//!
//! In: a [`Field`], a window of pixels. Out: offsets, in pixels; NaN where nothing comes from.

use super::Field;
use crate::space::{FrameSize, ImagePoint, PixelRect};
use glam::{DMat2, DVec2};
use rayon::prelude::*;

/// Where every pixel of a window comes from (or goes to).
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMap {
    /// The display window that the screen is measured against.
    pub frame: FrameSize,
    /// The pixels that the map tells of, relative to the upper left corner of the DISPLAY window; may lie partly or
    /// wholly outside the frame.
    pub window: PixelRect,
    /// #pixels of the window, rows from the top: what has to be added to a pixel's centre, in pixels, x right, y DOWN;
    /// NaN where nothing is seen. Exactly 0 where nothing moves.
    pub offsets: Vec<[f32; 2]>,
    /// Pixels of the window (places in `offsets`, in order) at which the field is not one-to-one: several points of the
    /// source land there (backward), or the pixel lands where others do (forward).
    pub folded_pixels: Vec<u32>,
}

/// Steps between neighbours that differ by more than this, in pixels a pixel, belong to different sheets.
const TEAR: f32 = 0.5;

/// What arithmetic may be off, in pixels.
const ROUNDING: f64 = 1e-6;

impl WarpMap {
    /// The map that moves nothing.
    #[must_use]
    pub fn identity(frame: FrameSize, window: PixelRect) -> Self {
        Self { frame, window, offsets: vec![[0.0; 2]; window.area()], folded_pixels: Vec::new() }
    }

    /// For every pixel of the warped picture: where it came from.
    #[must_use]
    pub fn backward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let view = View { field, frame };
        let mut map = Self::identity(frame, window);
        map.rows_mut().for_each(|(y, row)| {
            let mut start = DVec2::ZERO;
            for (offset, x) in row.iter_mut().zip(window.x..) {
                let pixel = center(x, y);
                let found = view.back(pixel, start).or_else(|| view.back(pixel, DVec2::ZERO));
                let found = found.map(|(offset, _)| offset);
                start = found.unwrap_or(DVec2::ZERO);
                *offset = found.unwrap_or(DVec2::NAN).as_vec2().to_array();
            }
        });
        map
    }

    /// For every pixel of a picture: where its centre goes.
    #[must_use]
    pub fn forward(field: &Field, frame: FrameSize, window: PixelRect) -> Self {
        let view = View { field, frame };
        let mut map = Self::identity(frame, window);
        map.rows_mut().for_each(|(y, row)| {
            for (offset, x) in row.iter_mut().zip(window.x..) {
                *offset = view.displace(center(x, y)).0.as_vec2().to_array();
            }
        });
        map
    }

    /// Rows and their y, on all threads.
    fn rows_mut(&mut self) -> impl ParallelIterator<Item = (i32, &mut [[f32; 2]])> {
        let top = self.window.y;
        let rows = self.offsets.par_chunks_exact_mut(self.window.width.max(1) as usize);
        rows.enumerate().map(move |(row, offsets)| (top + row as i32, offsets))
    }

    /// Where pixel (x, y) of the display window comes from (or goes to), in pixels: the centre of pixel (i, j) is
    /// (i + .5, j + .5). `None` outside the window and where nothing is seen.
    #[must_use]
    pub fn source(&self, x: i32, y: i32) -> Option<[f64; 2]> {
        let column = usize::try_from(i64::from(x) - i64::from(self.window.x)).ok()?;
        let row = usize::try_from(i64::from(y) - i64::from(self.window.y)).ok()?;
        if column >= self.window.width as usize || row >= self.window.height as usize {
            return None;
        }
        let [dx, dy] = self.offsets[row * self.window.width as usize + column].map(f64::from);
        let source = center(x, y) + DVec2::new(dx, dy);
        source.is_finite().then_some(source.to_array())
    }

    /// How the source moves per pixel at a place in `offsets`: `[row][column]`, column 0 a step to the right, column 1 a
    /// step DOWN, in pixels. Steps across the edge of a sheet do not count; a pixel alone gets the identity.
    #[must_use]
    pub fn jacobian(&self, index: usize) -> [[f32; 2]; 2] {
        let width = self.window.width as usize;
        let (column, row) = (index % width, index / width);
        let right = (column + 1 < width).then(|| index + 1);
        let below = (row + 1 < self.window.height as usize).then(|| index + width);
        let x = self.step(index, index.checked_sub(1).filter(|_| column > 0), right);
        let y = self.step(index, index.checked_sub(width), below);
        [[1.0 + x[0], y[0]], [x[1], 1.0 + y[1]]]
    }

    /// Change of the offsets a pixel, between two neighbours.
    fn step(&self, at: usize, before: Option<usize>, after: Option<usize>) -> [f32; 2] {
        let here = self.offsets[at];
        let change = |other: Option<usize>, sign: f32| {
            let there = self.offsets[other?];
            let change = [0, 1].map(|d| (there[d] - here[d]) * sign);
            (change[0] + change[1]).is_finite().then_some(change)
        };
        let square = |v: [f32; 2]| v[0] * v[0] + v[1] * v[1];
        match (change(before, -1.0), change(after, 1.0)) {
            (Some(a), Some(b)) if square([a[0] - b[0], a[1] - b[1]]) <= TEAR * TEAR => {
                [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
            }
            (Some(a), Some(b)) => {
                if square(a) <= square(b) {
                    a
                } else {
                    b
                }
            }
            (Some(only), None) | (None, Some(only)) => only,
            (None, None) => [0.0; 2],
        }
    }
}

impl Field {
    /// The data window after the warp: all pixels that can receive anything of `window` (relative to the display
    /// window), cut to the frame and as much again on every side where that is not more than `window` itself reaches.
    #[must_use]
    pub fn warped_window(&self, frame: FrameSize, window: PixelRect) -> PixelRect {
        if window.area() == 0 {
            return window;
        }
        let view = View { field: self, frame };
        let (lo, size) = (corner(window), DVec2::new(f64::from(window.width), f64::from(window.height)));
        let counts = [window.width, window.height].map(|pixels| pixels.div_ceil(4).min(2048));
        let places = (0..=counts[1]).flat_map(|j| (0..=counts[0]).map(move |i| (i, j)));
        let (mut least, mut most) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut moved = DVec2::ZERO;
        for (i, j) in places {
            let at = lo + size * DVec2::new(f64::from(i) / f64::from(counts[0]), f64::from(j) / f64::from(counts[1]));
            let by = view.displace(at).0;
            moved = moved.max(by.abs());
            (least, most) = (least.min(at + by), most.max(at + by));
        }
        rounded_out(least, most, window, frame)
    }
}

/// All pixels that a box touches, within reason.
fn rounded_out(least: DVec2, most: DVec2, window: PixelRect, frame: FrameSize) -> PixelRect {
    let frame = DVec2::new(f64::from(frame.width), f64::from(frame.height));
    let (lo, hi) = (corner(window), corner(window) + DVec2::new(f64::from(window.width), f64::from(window.height)));
    // A shift by whole pixels is whole but for rounding.
    let least = (least + ROUNDING).floor().max(lo.min(-frame));
    let most = (most - ROUNDING).ceil().min(hi.max(2.0 * frame));
    if !(least.cmplt(most).all()) {
        return PixelRect { width: 0, height: 0, ..window };
    }
    let size = most - least;
    PixelRect { x: least.x as i32, y: least.y as i32, width: size.x as u32, height: size.y as u32 }
}

fn corner(window: PixelRect) -> DVec2 {
    DVec2::new(f64::from(window.x), f64::from(window.y))
}

/// Centre of a pixel.
fn center(x: i32, y: i32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// A field as the pixels of a frame see it: points and offsets in pixels, y down.
#[derive(Clone, Copy)]
struct View<'a> {
    field: &'a Field,
    frame: FrameSize,
}

impl View<'_> {
    /// Pixels a frame height, y turned over.
    fn scale(self) -> DVec2 {
        let height = f64::from(self.frame.height);
        DVec2::new(height / self.frame.pixel_aspect, -height)
    }

    fn screen(self, pixel: DVec2) -> DVec2 {
        self.frame.screen_from_image(ImagePoint(pixel)).0
    }

    /// How far a point of the picture moves, and the gradient.
    fn displace(self, pixel: DVec2) -> (DVec2, DMat2) {
        let (moved, gradient) = self.field.displace(self.screen(pixel));
        (moved * self.scale(), self.pixels(gradient))
    }

    /// Where a pixel came from, less its place, and the gradient of the field there.
    fn back(self, pixel: DVec2, start: DVec2) -> Option<(DVec2, DMat2)> {
        let (offset, gradient) = self.field.back(self.screen(pixel), start / self.scale())?;
        Some((offset * self.scale(), self.pixels(gradient)))
    }

    /// A gradient of the screen in pixels.
    fn pixels(self, gradient: DMat2) -> DMat2 {
        let scale = self.scale();
        DMat2::from_cols(gradient.x_axis * scale / scale.x, gradient.y_axis * scale / scale.y)
    }
}
