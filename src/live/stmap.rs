//! A warp as an STMap.
//!
//! In: a [`Warp`], the frame, a window. Out: planes in the convention of `src/plate/stmap.rs`, or a file.

use super::Warp;
use super::pages::Page;
use crate::image::{Compression, FrameMetadata, ImageError, write_exr};
use crate::plate::{WarpMap, stmap_of};
use crate::space::{FrameSize, PixelRect};
use std::path::Path;

/// Where the pixels of a window come from, as shares of the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct StMap {
    /// The pixels, in image space.
    pub window: PixelRect,
    /// #pixels, rows from the top: u = (x + .5) / W, from left to right; -1 where nothing is seen.
    pub u: Vec<f32>,
    /// #pixels: v = 1 - (y + .5) / H, from below; -1 where nothing is seen.
    pub v: Vec<f32>,
    /// #pixels: 1, or 0 where nothing is seen.
    pub coverage: Vec<f32>,
}

/// The STMap of a window of a frame. Whatever else is warped with it (other layers, other programs) moves as the picture.
#[must_use]
pub fn stmap(warp: &Warp, frame: FrameSize, window: PixelRect) -> StMap {
    let channels = stmap_of(&map(warp, frame, window)).channels.into_iter().map(|channel| channel.samples);
    let mut planes = channels.collect::<Vec<_>>().into_iter();
    let mut next = || planes.next().unwrap_or_default();
    let (u, v, _, coverage) = (next(), next(), next(), next());
    StMap { window, u, v, coverage }
}

/// Writes the STMap of a whole frame as a 32-bit EXR; beside the path the number of the frame.
///
/// # Errors
/// [`ImageError`] where the file cannot be written.
pub fn save_stmap(warp: &Warp, size: FrameSize, (path, frame): (&Path, i32)) -> Result<(), ImageError> {
    let map = WarpMap::backward(&warp.field, size, size.window());
    let metadata = FrameMetadata {
        frame,
        frames_per_second: 24.0,
        shot_hash: String::new(),
        device: "CPU".into(),
        camera: None,
        mattes: Default::default(),
    };
    write_exr(path, &stmap_of(&map), &metadata, Compression::Zip)
}

/// Where the pixels of a window come from.
fn map(warp: &Warp, frame: FrameSize, window: PixelRect) -> WarpMap {
    let mut whole = WarpMap::identity(frame, window);
    if warp.is_identity() {
        return whole;
    }
    for page in Page::all_of(window) {
        let map = page.map(warp, frame);
        let part = page.window().intersection(window);
        for ([from, _], [to, _]) in map.window.shared_rows(part).zip(window.shared_rows(part)) {
            whole.offsets[to].copy_from_slice(&map.offsets[from]);
        }
    }
    whole
}
