//! Exports a warp as an STMap.
//!
//! In: a [`Warp`], the frame, a window. Out: planes in the convention of `src/plate/stmap.rs`, or a file.

use super::map_tiles::MapTile;
use super::{OutputGuard, Warp};
use crate::image::{Compression, FrameMetadata, ImageError, Plate, Storage, read_any_head, write_exr};
use crate::plate::{WarpMap, stmap_of};
use crate::space::{FrameSize, FrameWindow, PixelRect};
use std::path::Path;

/// Source positions of the pixels of a window, as fractions of the frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StMap {
    /// The pixels, in image space.
    pub window: PixelRect,
    /// #pixels, rows from the top: u = (x + .5) / W, from left to right; -1 where nothing is visible.
    pub u: Vec<f32>,
    /// #pixels: v = 1 - (y + .5) / H, from the bottom up; -1 where nothing is visible.
    pub v: Vec<f32>,
    /// #pixels: 1, or 0 where nothing is visible.
    pub coverage: Vec<f32>,
}

/// Computes the STMap of a window of a frame. Anything warped by it (other layers, other programs) moves like the picture.
#[must_use]
pub(crate) fn stmap(warp: &Warp, frame: FrameSize, window: PixelRect) -> StMap {
    let channels = stmap_of(&map(warp, frame, window)).channels.into_iter().map(|channel| channel.samples);
    let mut planes = channels.collect::<Vec<_>>().into_iter();
    let mut next = || planes.next().unwrap_or_default();
    let (u, v, _, coverage) = (next(), next(), next(), next());
    StMap { window, u, v, coverage }
}

impl StMap {
    /// Converts the map to fractions of another picture of the same scale, in whose image space this one's upper left
    /// pixel is at `corner`.
    #[must_use]
    pub(crate) fn measured_over(mut self, own: FrameSize, other: FrameSize, corner: [i32; 2]) -> Self {
        if corner == [0, 0] && own == other {
            return self;
        }
        let [left, top] = corner.map(f64::from);
        let [width, height] = [own.width, own.height].map(f64::from);
        for index in (0..self.u.len()).filter(|index| self.coverage[*index] > 0.0) {
            let (u, v) = (f64::from(self.u[index]), f64::from(self.v[index]));
            self.u[index] = ((u * width + left) / f64::from(other.width)) as f32;
            self.v[index] = (1.0 - ((1.0 - v) * height + top) / f64::from(other.height)) as f32;
        }
        self
    }
}

/// The destination and the metadata of an STMap file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StMapFile<'a> {
    /// Path of the EXR file.
    pub path: &'a Path,
    /// Frame number.
    pub frame: i32,
    /// Frame rate, in frames per second.
    pub rate: f64,
}

/// Checks that an STMap may be written to a path: that nothing exists there, or an STMap written by this program that
/// the shape does not read.
///
/// # Errors
/// [`ImageError::Frame`] if another file exists there; [`ImageError::Refused`] as [`OutputGuard::check`].
pub(crate) fn check_stmap_path(path: &Path, guard: &OutputGuard) -> Result<(), ImageError> {
    // Checked first, since opening a pipe would block forever.
    guard.check(path)?;
    if !path.exists() || read_any_head(path).is_ok_and(|head| is_own_stmap(&head)) {
        return Ok(());
    }
    let what = "it exists and is not an STMap written by this program; move it, or choose another path".to_owned();
    Err(ImageError::Frame { path: path.to_owned(), what })
}

/// Unlike STMaps, our renders store colour as half floats.
fn is_own_stmap(head: &Plate) -> bool {
    let [part] = &head.parts[..] else { return false };
    let is_map =
        ["R", "G", "B", "A"].iter().all(|name| part.channel(name).is_some_and(|one| one.storage == Storage::Float));
    head.is_own_render() && part.channels.len() == 4 && is_map
}

/// Writes the STMap of a whole frame as a 32-bit EXR; overwrites only another such map.
///
/// # Errors
/// [`ImageError`] as `check_stmap_path`, and if the file cannot be written.
pub(crate) fn save_stmap(warp: &Warp, size: FrameSize, file: StMapFile, guard: &OutputGuard) -> Result<(), ImageError> {
    check_stmap_path(file.path, guard)?;
    let map = warp.map_of_parts(size.whole());
    let map = map.unwrap_or_else(|| WarpMap::backward(&warp.field, size, size.window()));
    let metadata = FrameMetadata {
        frame: file.frame,
        frames_per_second: file.rate,
        shot_hash: String::new(),
        device: "CPU".into(),
        ..FrameMetadata::default()
    };
    write_exr(file.path, &stmap_of(&map), &metadata, Compression::Zip)
}

/// Computes the map of a window.
fn map(warp: &Warp, frame: FrameSize, window: PixelRect) -> WarpMap {
    let mut whole = WarpMap::identity(frame, window);
    if warp.is_identity() {
        return whole;
    }
    if let Some(map) = warp.map_of_parts(FrameWindow { frame, window }) {
        return map;
    }
    for tile in MapTile::all_of(frame, window) {
        let maps = tile.maps(warp, frame);
        let map = &maps[0];
        let part = tile.window().intersection(window);
        for ([from, _], [to, _]) in map.window.shared_rows(part).zip(window.shared_rows(part)) {
            whole.offsets[to].copy_from_slice(&map.offsets[from]);
        }
    }
    whole
}
