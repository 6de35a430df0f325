//! Pictures of the tests, and the memory in which the plugin finds them.
//!
//! In: plain samples. Out: buffers of any depth, components and row order, with guard bytes around every row.

use super::api::RectI;
use half::f16;

/// What untouched bytes hold.
const GUARD: u8 = 0xA5;
/// Guard bytes before the first row and after the last.
const BORDER: usize = 256;

/// How a value is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    Byte,
    Short,
    Half,
    Float,
}

impl Depth {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Byte, Self::Short, Self::Half, Self::Float];

    const fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Short | Self::Half => 2,
            Self::Float => 4,
        }
    }

    /// The step between values near 1.
    pub(crate) const fn step(self) -> f32 {
        match self {
            Self::Byte => 1.0 / 255.0,
            Self::Short => 1.0 / 65535.0,
            Self::Half => 1.0 / 1024.0,
            Self::Float => 1e-6,
        }
    }
}

/// How rows follow each other in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rows {
    /// The lowest first.
    Up,
    /// The highest first: row bytes are negative.
    Down,
    /// The lowest first, with bytes between rows that belong to nobody.
    Padded,
}

/// A picture: rows from below, channels interleaved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pixels {
    pub(crate) bounds: RectI,
    pub(crate) channels: usize,
    pub(crate) samples: Vec<f32>,
}

impl Pixels {
    /// A picture whose value at column x, row y and channel c is `value`.
    pub(crate) fn new(bounds: RectI, channels: usize, value: impl Fn(i32, i32, usize) -> f32) -> Self {
        let places = (bounds.y1..bounds.y2).flat_map(|y| (bounds.x1..bounds.x2).map(move |x| (x, y)));
        let samples = places.flat_map(|(x, y)| (0..channels).map(move |c| (x, y, c))).map(|(x, y, c)| value(x, y, c));
        let samples = samples.collect();
        Self { bounds, channels, samples }
    }

    /// Smooth colours that differ everywhere, with a soft disc of alpha (premultiplied) where there are four channels.
    pub(crate) fn scenery([width, height]: [i32; 2], channels: usize) -> Self {
        let bounds = RectI { x1: 0, y1: 0, x2: width, y2: height };
        Self::new(bounds, channels, |x, y, channel| {
            let [u, v] = [(x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32];
            let from_centre = (u - 0.5).hypot((v - 0.5) * height as f32 / width as f32);
            let alpha = ((0.4 - from_centre) * 10.0).clamp(0.0, 1.0);
            let wave = |turns: f32| 0.5 + 0.4 * (turns * u * 6.0).sin() * (turns * v * 5.0).cos();
            match (channels, channel) {
                (4, 3) | (1, 0) => alpha,
                (4, c) => alpha * wave(c as f32 + 1.0),
                (_, c) => wave(c as f32 + 1.0),
            }
        })
    }

    pub(crate) fn width(&self) -> usize {
        (self.bounds.x2 - self.bounds.x1) as usize
    }

    /// A sample.
    pub(crate) fn at(&self, x: i32, y: i32, channel: usize) -> f32 {
        let [column, row] = [(x - self.bounds.x1) as usize, (y - self.bounds.y1) as usize];
        self.samples[(row * self.width() + column) * self.channels + channel]
    }

    /// The largest difference to another picture, anywhere.
    pub(crate) fn distance(&self, other: &Self) -> f32 {
        assert_eq!((self.bounds, self.channels), (other.bounds, other.channels), "pictures of one form");
        self.samples.iter().zip(&other.samples).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }
}

/// Memory of an image. It outlives the image, so that late writes are seen and not felt.
#[derive(Debug)]
pub(crate) struct Buffer {
    bytes: *mut [u8],
    pub(crate) bounds: RectI,
    pub(crate) channels: usize,
    pub(crate) depth: Depth,
    rows: Rows,
    stride: usize,
}

// SAFETY: the buffer is its own memory; the tests read it only while no action runs.
unsafe impl Send for Buffer {}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: made by `Box::into_raw` and freed once.
        drop(unsafe { Box::from_raw(self.bytes) });
    }
}

impl Buffer {
    /// An image full of guard bytes.
    pub(crate) fn new(bounds: RectI, channels: usize, depth: Depth, rows: Rows) -> Self {
        let row = (bounds.x2 - bounds.x1) as usize * channels * depth.bytes();
        let stride = if rows == Rows::Padded { row.next_multiple_of(64) + 64 } else { row };
        let length = 2 * BORDER + stride * (bounds.y2 - bounds.y1) as usize;
        let bytes = Box::into_raw(vec![GUARD; length].into_boxed_slice());
        Self { bytes, bounds, channels, depth, rows, stride }
    }

    /// An image of a picture.
    pub(crate) fn of(pixels: &Pixels, depth: Depth, rows: Rows) -> Self {
        let buffer = Self::new(pixels.bounds, pixels.channels, depth, rows);
        // SAFETY: no action has seen it yet.
        let bytes = unsafe { &mut *buffer.bytes };
        let row = pixels.width() * pixels.channels;
        for (index, samples) in pixels.samples.chunks(row).enumerate() {
            let start = buffer.offset(index);
            let encoded: Vec<u8> = samples.iter().flat_map(|sample| encoded(*sample, depth)).collect();
            bytes[start..start + encoded.len()].copy_from_slice(&encoded);
        }
        buffer
    }

    fn height(&self) -> usize {
        (self.bounds.y2 - self.bounds.y1) as usize
    }

    fn row_length(&self) -> usize {
        (self.bounds.x2 - self.bounds.x1) as usize * self.channels * self.depth.bytes()
    }

    /// Where a row, counted from below, starts in the memory.
    fn offset(&self, row: usize) -> usize {
        let row = if self.rows == Rows::Down { self.height() - 1 - row } else { row };
        BORDER + row * self.stride
    }

    /// What the plugin is told: where the lowest row starts, and the way to the next.
    pub(crate) fn told(&self) -> (*mut u8, i32) {
        let stride = self.stride as i32;
        let start = self.bytes.cast::<u8>().wrapping_add(self.offset(0));
        (start, if self.rows == Rows::Down { -stride } else { stride })
    }

    /// Everything in it; [`None`] where a byte outside its pixels was changed.
    pub(crate) fn read(&self) -> Option<Pixels> {
        // SAFETY: no action runs while a test reads.
        let bytes = unsafe { &*self.bytes };
        let (row, height) = (self.row_length(), self.height());
        let mut outside = vec![true; bytes.len()];
        for index in 0..height {
            let start = self.offset(index);
            outside[start..start + row].fill(false);
        }
        if bytes.iter().zip(&outside).any(|(byte, is_outside)| *is_outside && *byte != GUARD) {
            return None;
        }
        let values = |index: usize| {
            let start = self.offset(index);
            bytes[start..start + row].chunks(self.depth.bytes()).map(|value| decoded(value, self.depth))
        };
        let samples = (0..height).flat_map(values).collect();
        Some(Pixels { bounds: self.bounds, channels: self.channels, samples })
    }
}

fn encoded(sample: f32, depth: Depth) -> Vec<u8> {
    match depth {
        Depth::Byte => vec![(sample.clamp(0.0, 1.0) * 255.0 + 0.5) as u8],
        Depth::Short => ((sample.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16).to_ne_bytes().into(),
        Depth::Half => f16::from_f32(sample).to_ne_bytes().into(),
        Depth::Float => sample.to_ne_bytes().into(),
    }
}

fn decoded(value: &[u8], depth: Depth) -> f32 {
    let pair = || [value[0], value[1]];
    match depth {
        Depth::Byte => f32::from(value[0]) / 255.0,
        Depth::Short => f32::from(u16::from_ne_bytes(pair())) / 65535.0,
        Depth::Half => f16::from_ne_bytes(pair()).to_f32(),
        Depth::Float => f32::from_ne_bytes([value[0], value[1], value[2], value[3]]),
    }
}
