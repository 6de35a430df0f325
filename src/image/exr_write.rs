//! A frame becomes an EXR file.
//!
//! In: [`Frame`], [`FrameMetadata`], [`Compression`]. Out: a scan-line file with the lines in increasing order,
//! compressed on all cores. Samples are converted line by line, so no copy of the frame is made.

use super::{Channel, Compression, Frame, FrameMetadata, ImageError, Storage, atomic, metadata};
use crate::space::{FrameSize, PixelRect};
use exr::block::lines::LineRefMut;
use exr::image::write::WritableImage;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, Image, Layer, Layers};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{IntegerBounds, LevelMode, LineOrder, SampleType, Text};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::borrow::Cow;
use std::collections::HashSet;
use std::path::Path;

/// Writes `frame` to `path`: under a temporary name, then renamed, so a file of that name is always whole. Missing
/// folders are made. The same frame and metadata give the same bytes every time.
///
/// An empty frame (area 0) is written as one pixel that holds nothing. What a file cannot hold is contained: NaN
/// becomes 0 (see [`Frame::nan_count`]); half samples beyond ±65504, infinities too, become ±65504, so that a
/// highlight stays a highlight and finite, and no filter downstream turns it into NaN. Infinite floats are kept.
///
/// Data is never compressed lossily. DWA takes `N.Y` and Cryptomatte's `.R .G .B` for colour; a frame with such channels
/// becomes a file of two parts, `colour` in DWA and `data` in zip.
///
/// # Errors
/// [`ImageError::Io`] where the disk is full or the folder cannot be written; [`ImageError::Frame`] where the frame is
/// malformed.
pub fn write_exr(
    path: &Path,
    frame: &Frame,
    metadata: &FrameMetadata,
    compression: Compression,
) -> Result<(), ImageError> {
    check(frame).map_err(|what| ImageError::frame(path, what))?;
    let frame = with_a_pixel(frame);
    let image = exr_image(&frame, metadata, compression);
    atomic::replace_file(path, |file| {
        image.write().to_unbuffered(file).map_err(|failed| match failed {
            exr::error::Error::Io(source) => ImageError::writing(path, source),
            other => ImageError::frame(path, other.to_string()),
        })
    })
}

/// What EXR demands; the message says what is wrong.
fn check(frame: &Frame) -> Result<(), String> {
    if frame.channels.is_empty() {
        return Err("the frame has no channels; ask for at least one".into());
    }
    if frame.display.area() == 0 {
        return Err("the frame has no pixels; give it a width and height of at least 1".into());
    }
    if !(1e-6..=1e6).contains(&frame.pixel_aspect) {
        return Err(format!("the pixel aspect {} is not between 1e-6 and 1e6", frame.pixel_aspect));
    }
    for (name, window) in [("display window", frame.display), ("data window", frame.data_window)] {
        check_window(window).map_err(|edge| format!("the {name} reaches pixel {edge}, too far out for EXR"))?;
    }
    let mut names = HashSet::new();
    for channel in &frame.channels {
        check_channel(channel, frame.data_window)?;
        if !names.insert(&channel.name) {
            return Err(format!("two channels are called '{}'", channel.name));
        }
    }
    Ok(())
}

/// `Err`: the coordinate that lies outside of what EXR files can tell (±2^30).
fn check_window(window: PixelRect) -> Result<(), i64> {
    const LIMIT: i64 = (i32::MAX / 2) as i64;
    let (left, top) = (i64::from(window.x), i64::from(window.y));
    let edges = [left, top, left + i64::from(window.width), top + i64::from(window.height)];
    edges.into_iter().find(|edge| edge.abs() >= LIMIT).map_or(Ok(()), Err)
}

fn check_channel(channel: &Channel, window: PixelRect) -> Result<(), String> {
    let Channel { name, samples, .. } = channel;
    if samples.len() != window.area() {
        return Err(format!("channel '{name}' has {} samples for {} pixels", samples.len(), window.area()));
    }
    if name.is_empty() || name.len() > 255 || name.bytes().any(|byte| byte == 0) {
        return Err(format!("'{name}' is no channel name; use 1 to 255 characters"));
    }
    Ok(())
}

/// EXR has no empty data window: one pixel that holds nothing stands for it.
fn with_a_pixel(frame: &Frame) -> Cow<'_, Frame> {
    if frame.data_window.area() > 0 {
        return Cow::Borrowed(frame);
    }
    let mut frame = frame.clone();
    frame.data_window = PixelRect { x: frame.display.x, y: frame.display.y, width: 1, height: 1 };
    for channel in &mut frame.channels {
        channel.samples = vec![channel.empty_value()];
    }
    Cow::Owned(frame)
}

fn exr_image<'a>(
    frame: &'a Frame,
    metadata: &FrameMetadata,
    compression: Compression,
) -> Image<Layers<AnyChannels<Lines<'a>>>> {
    let position = Vec2(frame.display.x, frame.display.y);
    let mut shared = ImageAttributes::new(IntegerBounds::new(position, size_of(frame.display)));
    shared.pixel_aspect = frame.pixel_aspect as f32;
    metadata::add_color_space(&mut shared);
    let layers = parts(frame, compression).into_iter().map(|part| part.layer(frame, metadata));
    Image { attributes: shared, layer_data: layers.collect() }
}

/// Channels that are compressed in one way.
struct Part<'a> {
    /// Files of one part need no name.
    name: Option<&'static str>,
    channels: Vec<&'a Channel>,
    compression: Compression,
}

fn parts(frame: &Frame, compression: Compression) -> Vec<Part<'_>> {
    let (colour, data): (Vec<_>, Vec<_>) = frame.channels.iter().partition(|channel| channel.storage == Storage::Half);
    if !compression.is_lossy() || !data.iter().any(|channel| is_colour_to_dwa(channel)) {
        return vec![Part { name: None, channels: frame.channels.iter().collect(), compression }];
    }
    let data = Part { name: Some("data"), channels: data, compression: Compression::Zip };
    let colour = Part { name: Some("colour"), channels: colour, compression };
    [colour, data].into_iter().filter(|part| !part.channels.is_empty()).collect()
}

/// DWA sorts float channels by the ends of their names, whatever they hold (OpenEXR, internal_dwa_classifier.h).
fn is_colour_to_dwa(channel: &Channel) -> bool {
    let suffix = channel.name.rsplit('.').next().unwrap_or_default();
    channel.storage == Storage::Float && ["R", "G", "B", "Y", "RY", "BY"].contains(&suffix)
}

impl<'a> Part<'a> {
    fn layer(self, frame: &Frame, metadata: &FrameMetadata) -> Layer<AnyChannels<Lines<'a>>> {
        let (display, window) = (frame.display, frame.data_window);
        let size = FrameSize { width: display.width, height: display.height, pixel_aspect: frame.pixel_aspect };
        let mut attributes = LayerAttributes { layer_position: Vec2(window.x, window.y), ..Default::default() };
        attributes.layer_name = self.name.map(Text::from);
        metadata.add_to_layer(&mut attributes, size);
        let encoding = Encoding {
            compression: exr_compression(self.compression),
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        // AnyChannels::sort puts the names into the alphabetical order that EXR demands.
        let channels = self.channels.iter().map(|channel| AnyChannel::new(channel.name.as_str(), Lines::of(channel)));
        Layer::new(size_of(window), attributes, encoding, AnyChannels::sort(channels.collect()))
    }
}

fn size_of(window: PixelRect) -> Vec2<usize> {
    Vec2(window.width as usize, window.height as usize)
}

fn exr_compression(compression: Compression) -> exr::prelude::Compression {
    use exr::prelude::Compression as Exr;
    match compression {
        Compression::None => Exr::Uncompressed,
        Compression::Rle => Exr::RLE,
        Compression::Zips => Exr::ZIP1,
        Compression::Zip => Exr::ZIP16,
        Compression::Piz => Exr::PIZ,
        Compression::Dwaa => Exr::DWAA(None),
        Compression::Dwab => Exr::DWAB(None),
    }
}

/// A channel that hands out its lines in the file's type.
#[derive(Clone, Copy)]
struct Lines<'a> {
    storage: Storage,
    samples: &'a [f32],
    /// Pixels across; 0 until the header is known.
    width: usize,
}

impl<'a> Lines<'a> {
    fn of(channel: &'a Channel) -> Self {
        Self { storage: channel.storage, samples: &channel.samples, width: 0 }
    }
}

impl<'a> WritableSamples<'_> for Lines<'a> {
    type Writer = Lines<'a>;

    fn sample_type(&self) -> SampleType {
        match self.storage {
            Storage::Half => SampleType::F16,
            Storage::Float => SampleType::F32,
            Storage::Uint => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, header: &Header) -> Self::Writer {
        Lines { width: header.layer_size.width(), ..*self }
    }
}

impl SamplesWriter for Lines<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let start = line.location.position.y() * self.width + line.location.position.x();
        let samples = &self.samples[start..start + line.location.sample_count];
        match self.storage {
            Storage::Half => write_halves(samples, line.value),
            Storage::Float => {
                write_words(samples, line.value, |sample| if sample.is_nan() { 0 } else { sample.to_bits() })
            }
            Storage::Uint => write_words(samples, line.value, f32::to_bits),
        }
    }
}

/// The crate wants native byte order and turns it to the file's itself.
fn write_words(samples: &[f32], bytes: &mut [u8], bits: impl Fn(f32) -> u32) {
    for (word, &sample) in bytes.chunks_exact_mut(4).zip(samples) {
        word.copy_from_slice(&bits(sample).to_ne_bytes());
    }
}

fn write_halves(samples: &[f32], bytes: &mut [u8]) {
    const CHUNK: usize = 256;
    let (mut contained, mut halves) = ([0.0_f32; CHUNK], [f16::ZERO; CHUNK]);
    for (samples, bytes) in samples.chunks(CHUNK).zip(bytes.chunks_mut(2 * CHUNK)) {
        let (contained, halves) = (&mut contained[..samples.len()], &mut halves[..samples.len()]);
        for (to, from) in contained.iter_mut().zip(samples) {
            *to = contained_in_half(*from);
        }
        halves.convert_from_f32_slice(contained);
        for (word, half) in bytes.chunks_exact_mut(2).zip(halves) {
            word.copy_from_slice(&half.to_ne_bytes());
        }
    }
}

/// NaN becomes 0; what half cannot hold becomes its largest number.
fn contained_in_half(sample: f32) -> f32 {
    const LIMIT: f32 = f16::MAX.to_f32_const();
    if sample.is_nan() { 0.0 } else { sample.clamp(-LIMIT, LIMIT) }
}
