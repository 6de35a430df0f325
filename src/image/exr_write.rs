//! Writes a frame as an EXR file.
//!
//! In: [`Frame`], [`FrameMetadata`], [`Compression`]. Out: a scan-line file with increasing line order, compressed on
//! all cores. Samples are converted line by line, so the frame is not copied.

use super::atomic::Destination;
use super::exr_file::{self, Lines, NonFinitePolicy, check_aspect, check_channels, check_window, size_of, text};
use super::{Channel, Compression, Frame, FrameMetadata, ImageError, Storage, metadata};
use crate::space::{FrameSize, PixelRect};
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, Image, Layer, Layers};
use exr::math::Vec2;
use exr::meta::attribute::{IntegerBounds, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use std::borrow::Cow;

/// Writes `frame` atomically and deterministically; creates missing directories.
///
/// An empty frame (area 0) is written as one empty pixel. Values that a file should not contain are replaced: NaN by 0
/// (see [`Frame::nan_count`]); half samples beyond ±65504, including infinities, by ±65504, so that highlights stay
/// bright but finite and no filter downstream turns them into NaN. Infinite floats are kept.
///
/// Data channels are never compressed lossily. Since DWA treats `N.Y` and Cryptomatte's `.R .G .B` as colour, a frame
/// with such channels is written as two parts, `colour` in DWA and `data` in zip.
///
/// # Errors
/// [`ImageError::Io`] if the disk is full or the directory is not writable; [`ImageError::Frame`] if the frame is malformed.
pub fn write_exr<'a>(
    to: impl Into<Destination<'a>>,
    frame: &Frame,
    metadata: &FrameMetadata,
    compression: Compression,
) -> Result<(), ImageError> {
    let to = to.into();
    check(frame).map_err(|what| ImageError::frame(to.path, what))?;
    let frame = with_a_pixel(frame);
    let image = exr_image(&frame, metadata, compression);
    exr_file::write(to, &image)
}

/// Checks the requirements of EXR; the error describes what is wrong.
fn check(frame: &Frame) -> Result<(), String> {
    if frame.display.area() == 0 {
        return Err("the frame has no pixels; give it a width and height of at least 1".into());
    }
    check_aspect(frame.pixel_aspect)?;
    check_window("display window", frame.display)?;
    check_window("data window", frame.data_window)?;
    check_channels(&frame.channels, frame.data_window)
}

/// Replaces an empty data window, which EXR does not allow, by one empty pixel.
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

/// Channels with the same compression.
struct Part<'a> {
    /// `None` for single-part files.
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

/// Whether DWA treats the channel as colour: it classifies float channels by name suffix only (OpenEXR, internal_dwa_classifier.h).
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
        // AnyChannels::sort establishes the alphabetical order that EXR requires.
        let channels = self
            .channels
            .iter()
            .map(|channel| AnyChannel::new(text(&channel.name), Lines::of(channel, NonFinitePolicy::Contained)));
        Layer::new(size_of(window), attributes, encoding, AnyChannels::sort(channels.collect()))
    }
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
