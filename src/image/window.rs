//! Creates, crops and stitches frames.
//!
//! In: frames and windows. Out: frames.

use super::{Channel, EMPTY_DEPTH, Frame, Storage};
use crate::space::PixelRect;

impl Frame {
    /// Creates an empty frame: depth channels at 1e10, all others 0. Square pixels.
    #[must_use]
    pub fn blank(display: PixelRect, data_window: PixelRect, channels: &[(&str, Storage)]) -> Self {
        let channels = channels.iter().map(|&(name, storage)| {
            let mut channel = Channel { name: name.to_owned(), storage, samples: Vec::new() };
            channel.samples = vec![channel.empty_value(); data_window.area()];
            channel
        });
        Self { display, data_window, pixel_aspect: 1.0, channels: channels.collect() }
    }

    /// Crops the data window to the smallest one that contains every non-empty sample; area 0 if there are none.
    #[must_use]
    pub(crate) fn crop_to_covered(self) -> Self {
        let covered = self.covered_window();
        if covered == self.data_window {
            return self;
        }
        let from = self.data_window;
        let channels = self.channels.into_iter().map(|channel| {
            let samples = from.resized_samples(&channel.samples, covered, channel.empty_value());
            Channel { samples, ..channel }
        });
        Self { data_window: covered, channels: channels.collect(), ..self }
    }

    /// Copies a tile's samples into the channels of the same names. Pixels outside the data window and unknown channels are ignored.
    pub(crate) fn paste(&mut self, tile: &Self) {
        let rows = self.data_window.shared_rows(tile.data_window);
        for channel in &mut self.channels {
            let Some(source) = tile.channel(&channel.name) else { continue };
            for [to, from] in rows.clone() {
                channel.samples[to].copy_from_slice(&source.samples[from]);
            }
        }
    }

    fn covered_window(&self) -> PixelRect {
        let mut bounds = Bounds::NONE;
        for channel in self.channels.iter().filter(|_| self.data_window.width > 0) {
            let rows = channel.samples.chunks_exact(self.data_window.width as usize);
            // NaN counts as non-empty, so that it stays visible.
            match channel.storage {
                Storage::Uint => bounds.include(rows, |sample| sample.to_bits() != 0),
                _ if channel.is_depth() => bounds.include(rows, |sample| sample.is_nan() || sample < EMPTY_DEPTH),
                _ => bounds.include(rows, |sample| sample != 0.0),
            }
        }
        bounds.window(self.data_window)
    }
}

/// Bounds of covered columns and rows, relative to the upper left corner of the data window.
struct Bounds {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Bounds {
    const NONE: Self = Self { left: usize::MAX, right: 0, top: usize::MAX, bottom: 0 };

    fn include<'a>(&mut self, rows: impl Iterator<Item = &'a [f32]>, is_covered: impl Fn(f32) -> bool) {
        rows.enumerate().for_each(|(y, row)| self.include_row(y, row, &is_covered));
    }

    /// Searches inwards from both ends of the row, only as far as it can still extend the bounds.
    fn include_row(&mut self, y: usize, row: &[f32], is_covered: impl Fn(f32) -> bool) {
        let left = first_covered(&row[..row.len().min(self.left)], &is_covered);
        let right = last_covered(&row[self.right..], &is_covered).map(|at| at + self.right);
        let is_row_known = self.top <= y && y < self.bottom;
        let is_row_covered =
            left.is_some() || right.is_some() || !is_row_known && first_covered(row, is_covered).is_some();
        if !is_row_covered {
            return;
        }
        self.left = left.unwrap_or(self.left);
        self.right = right.map_or(self.right, |at| at + 1);
        self.top = self.top.min(y);
        self.bottom = self.bottom.max(y + 1);
    }

    fn window(&self, around: PixelRect) -> PixelRect {
        if self.bottom == 0 {
            return PixelRect { x: around.x, y: around.y, width: 0, height: 0 };
        }
        PixelRect {
            x: around.x + self.left as i32,
            y: around.y + self.top as i32,
            width: (self.right - self.left) as u32,
            height: (self.bottom - self.top) as u32,
        }
    }
}

/// Samples compared together without branches, so that the compiler can vectorise.
const BATCH: usize = 32;

fn first_covered(row: &[f32], is_covered: impl Fn(f32) -> bool) -> Option<usize> {
    let batch = row.chunks(BATCH).position(|batch| any_covered(batch, &is_covered))? * BATCH;
    row[batch..].iter().position(|&sample| is_covered(sample)).map(|at| batch + at)
}

fn last_covered(row: &[f32], is_covered: impl Fn(f32) -> bool) -> Option<usize> {
    let end = row.len() - row.rchunks(BATCH).position(|batch| any_covered(batch, &is_covered))? * BATCH;
    row[..end].iter().rposition(|&sample| is_covered(sample))
}

fn any_covered(batch: &[f32], is_covered: impl Fn(f32) -> bool) -> bool {
    batch.iter().fold(false, |any, &sample| any | is_covered(sample))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CHANNELS: [(&str, Storage); 5] = [
        ("R", Storage::Half),
        ("A", Storage::Half),
        ("depth.Z", Storage::Float),
        ("N.Z", Storage::Float),
        ("id", Storage::Uint),
    ];
    const DISPLAY: PixelRect = PixelRect { x: 0, y: 0, width: 16, height: 16 };
    const WINDOW: PixelRect = PixelRect { x: -10, y: -20, width: 30, height: 40 };

    fn touched(name: &str, x: usize, y: usize, value: f32) -> Frame {
        let mut frame = Frame::blank(DISPLAY, WINDOW, &CHANNELS);
        for channel in frame.channels.iter_mut().filter(|channel| channel.name == name) {
            channel.samples[y * 30 + x] = value;
        }
        frame
    }

    /// Smooth values that differ between channels.
    fn filled() -> Frame {
        let mut frame = Frame::blank(DISPLAY, WINDOW, &CHANNELS);
        for (number, channel) in frame.channels.iter_mut().enumerate() {
            let samples = channel.samples.iter_mut().enumerate();
            samples.for_each(|(index, sample)| *sample = (index * 5 + number) as f32 + 1.0);
        }
        frame
    }

    #[test]
    fn nothing_covered_leaves_no_pixels() {
        for frame in [touched("R", 3, 4, 0.0), touched("R", 3, 4, -0.0), touched("depth.Z", 3, 4, f32::INFINITY)] {
            let cropped = frame.crop_to_covered();
            assert_eq!(cropped.data_window.area(), 0);
            assert!(cropped.channels.iter().all(|channel| channel.samples.is_empty()));
            assert_eq!(cropped.clone().crop_to_covered(), cropped);
        }
    }

    #[test]
    fn any_channel_covers() {
        let id = f32::from_bits(1 << 31);
        for (name, value) in [("R", 1e-6), ("A", 1.0), ("depth.Z", 5.0), ("N.Z", -1.0), ("id", id), ("R", f32::NAN)] {
            for (x, y) in [(3, 4), (0, 0), (29, 39)] {
                let cropped = touched(name, x, y, value).crop_to_covered();
                let expected = PixelRect { x: x as i32 - 10, y: y as i32 - 20, width: 1, height: 1 };
                assert_eq!(cropped.data_window, expected, "{name}");
                let kept = cropped.channel(name).expect("all channels are kept").samples[0];
                assert_eq!(kept.to_bits(), value.to_bits());
            }
        }
    }

    #[test]
    fn cropping_loses_nothing_where_channels_cover_different_corners() {
        let mut frame = touched("R", 20, 5, 1.0);
        frame.channels[2].samples[30 * 11 + 2] = 7.0;
        frame.channels[3].samples[30 * 30 + 10] = 1.0;
        let cropped = frame.clone().crop_to_covered();
        assert_eq!(cropped.data_window, PixelRect { x: -8, y: -15, width: 19, height: 26 });
        let mut pasted = Frame::blank(DISPLAY, WINDOW, &CHANNELS);
        pasted.paste(&cropped);
        assert_eq!(pasted, frame);
    }

    #[test]
    fn tiles_make_the_frame() {
        let frame = filled();
        let mut stitched = Frame::blank(DISPLAY, WINDOW, &CHANNELS);
        for (x, y) in [(0, 0), (16, 0), (0, 24), (16, 24)] {
            let window = PixelRect { x: WINDOW.x + x, y: WINDOW.y + y, width: 16, height: 24 };
            let mut tile = Frame::blank(DISPLAY, window, &CHANNELS);
            tile.paste(&frame);
            // Pixels outside the frame are ignored.
            stitched.paste(&tile);
        }
        assert_eq!(stitched, frame);
        stitched.paste(&Frame::blank(DISPLAY, PixelRect { x: 1000, ..WINDOW }, &CHANNELS));
        assert_eq!(stitched, frame);
    }

    proptest! {
        #[test]
        fn the_covered_window_is_the_box_around_all_points(
            points in prop::collection::vec((0..150_usize, 0..40_usize, 0..5_usize), 1..12),
        ) {
            let window = PixelRect { width: 150, ..WINDOW };
            let mut frame = Frame::blank(DISPLAY, window, &CHANNELS);
            points.iter().for_each(|&(x, y, channel)| frame.channels[channel].samples[y * 150 + x] = 2.0);
            let bounds = |values: Vec<usize>| (values.iter().copied().min(), values.iter().copied().max());
            let (left, right) = bounds(points.iter().map(|point| point.0).collect());
            let (top, bottom) = bounds(points.iter().map(|point| point.1).collect());
            let covered = frame.covered_window();
            let first = ((covered.x + 10) as usize, (covered.y + 20) as usize);
            let last = (first.0 + covered.width as usize - 1, first.1 + covered.height as usize - 1);
            prop_assert_eq!((Some(first.0), Some(last.0)), (left, right));
            prop_assert_eq!((Some(first.1), Some(last.1)), (top, bottom));
        }
    }
}
