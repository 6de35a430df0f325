//! Scales pictures to frames of another size.
//!
//! In: planes, the sizes of both frames. Out: planes of the new size, filtered over the larger of source and destination pixels.

use super::{Filter, Planes, WarpMap, resampled};
use crate::space::{FrameSize, PixelRect};

/// Returns the window and the planes of a picture in a frame of another size. `source`: its window is relative to the upper left corner of
/// the frame `from`.
#[must_use]
pub(crate) fn scaled(source: &Planes, from: FrameSize, to: FrameSize) -> (PixelRect, Vec<Vec<f32>>) {
    let factor = [f64::from(from.width) / f64::from(to.width), f64::from(from.height) / f64::from(to.height)];
    let along = |start: i32, length: u32, factor: f64| {
        let end = (f64::from(start) + f64::from(length)) / factor;
        let start = (f64::from(start) / factor).floor();
        (start as i32, (end.ceil() - start).max(0.0) as u32)
    };
    let (x, width) = along(source.window.x, source.window.width, factor[0]);
    let (y, height) = along(source.window.y, source.window.height, factor[1]);
    let window = PixelRect { x, y, width, height };
    // Coordinates are relative to the frame: the source of pixel (i, j) is ((i + .5) fx, (j + .5) fy).
    let mut map = WarpMap::identity(from, window);
    for (index, offset) in map.offsets.iter_mut().enumerate() {
        let place = [x + (index % width as usize) as i32, y + (index / width as usize) as i32];
        *offset = [0, 1].map(|axis| ((f64::from(place[axis]) + 0.5) * (factor[axis] - 1.0)) as f32);
    }
    (window, resampled(&map, source, Filter::Ewa))
}
