//! Converts between PNG and JPEG pictures and plates.
//!
//! In: a path. Out: [`Plate`] of R, G, B and, if the picture has it, A: scene-linear, associated alpha; and the inverse.

use super::atomic::{Destination, replace_file};
use super::srgb::{linear_from_srgb, srgb_from_linear};
use super::{
    Channel, Frame, FrameMetadata, ImageError, PictureKind, Plate, PlatePart, Storage, exr_guard, metadata, png_note,
};
use crate::space::PixelRect;
use ::image::codecs::jpeg::JpegEncoder;
use ::image::codecs::png::{CompressionType, FilterType, PngEncoder};
use ::image::metadata::Orientation;
use ::image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader};
use rayon::prelude::*;
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Scale of colours under alpha 0, relative to their light: too small to be visible (a fifteenth of the smallest step
/// of 16 bits), but enough for [`write_picture`] to recover the colour.
const HIDDEN: f32 = 1e-6;
/// Little loss at a third of the size of the best quality.
const JPEG_QUALITY: u8 = 95;
/// Greatest possible number of pixel bytes per byte of a file: eight one-bit pixels, deflated 1032 times. JPEG stays below.
const BEST_RATIO: u128 = 8300;

/// Reads a PNG or JPEG picture of 8 or 16 bits per channel, grey or colour, as sRGB, with its EXIF orientation applied. Eight bits become
/// half channels, sixteen float channels. Colours under alpha 0 are kept as a millionth of their light.
///
/// # Errors
/// [`ImageError`] if the file cannot be opened, is damaged or truncated, or is not a picture.
pub fn read_picture(path: &Path) -> Result<Plate, ImageError> {
    Ok(plate_from_picture(decode(path)?, Codes::Color))
}

/// Meaning of the codes of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Codes {
    /// sRGB colours with straight alpha.
    Color,
    /// Numbers from 0 to 1, as in STMaps.
    Numbers,
}

/// Decodes a picture, with its EXIF orientation applied.
fn decode(path: &Path) -> Result<DynamicImage, ImageError> {
    let io = |source| ImageError::reading(path, source);
    let failed = |failed| picture_error(path, failed);
    crate::files::check_regular(path).map_err(io)?;
    let mut reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(io)?;
    reader.no_limits();
    let mut decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    exr_guard::check_promise(path, decoder.total_bytes().into(), BEST_RATIO)?;
    exr_guard::check_memory(path, 24 * u128::from(width) * u128::from(height))?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let mut picture = DynamicImage::from_decoder(decoder).map_err(failed)?;
    picture.apply_orientation(orientation);
    Ok(picture)
}

fn picture_error(path: &Path, failed: ::image::ImageError) -> ImageError {
    match failed {
        ::image::ImageError::IoError(source) if source.kind() != ErrorKind::UnexpectedEof => {
            ImageError::reading(path, source)
        }
        ::image::ImageError::Unsupported(what) => {
            ImageError::unsupported(path, format!("{what}; save it as PNG, JPEG or EXR"))
        }
        other => ImageError::damaged(path, other.to_string()),
    }
}

fn plate_from_picture(picture: DynamicImage, meaning: Codes) -> Plate {
    let color = picture.color();
    let is_eight_bit = color.bytes_per_pixel() == color.channel_count();
    let storage = if is_eight_bit { Storage::Half } else { Storage::Float };
    let window = PixelRect { x: 0, y: 0, width: picture.width(), height: picture.height() };
    // Eight bits are scaled by 257, so v / 255 stays v / 255.
    let codes = picture.into_rgba16().into_raw();
    let value = |code: u16| match meaning {
        Codes::Color => linear_from_srgb(f64::from(code) / f64::from(u16::MAX)) as f32,
        Codes::Numbers => unit(code),
    };
    let values: Vec<f32> = (0..=u16::MAX).map(value).collect();
    let shown = |alpha: u16| match meaning {
        Codes::Color => unit(alpha).max(HIDDEN),
        Codes::Numbers => 1.0,
    };
    let mut channels: Vec<_> = ["R", "G", "B"]
        .into_par_iter()
        .enumerate()
        .map(|(at, name)| {
            let pixels = codes.chunks_exact(4);
            let samples = pixels.map(|pixel| values[usize::from(pixel[at])] * shown(pixel[3])).collect();
            Channel { name: name.to_owned(), storage, samples }
        })
        .collect();
    if color.has_alpha() {
        let samples = codes.chunks_exact(4).map(|pixel| unit(pixel[3])).collect();
        channels.push(Channel { name: "A".to_owned(), storage, samples });
    }
    let mut plate = Plate::from_frame(Frame { display: window, data_window: window, pixel_aspect: 1.0, channels });
    if meaning == Codes::Color {
        metadata::add_color_space(&mut plate.attributes);
    }
    plate
}

fn unit(code: u16) -> f32 {
    f32::from(code) / f32::from(u16::MAX)
}

/// Writes the display window of the first part with colour as PNG or JPEG, by the extension of `path`: sRGB, straight
/// alpha, written atomically. A PNG has 16 bits per channel if the colour is [`Storage::Float`], else 8, and alpha if
/// the part has it. A JPEG shows the picture over black.
///
/// Values are clipped at 1. Where light exceeds its alpha, alpha is raised so that it shows, as in [`super::preview`].
/// A picture read by [`read_picture`] and written as PNG is preserved code by code, including colours under alpha 0;
/// grey becomes colour. A PNG contains the metadata of its frame.
///
/// # Errors
/// [`ImageError`] if the file cannot be written, the plate has no colour, or the extension is neither.
pub fn write_picture<'a>(to: impl Into<Destination<'a>>, plate: &Plate) -> Result<(), ImageError> {
    let to = to.into();
    let path = to.path;
    let colour = Colour::of(plate).ok_or_else(|| ImageError::frame(path, "it has no channels R, G, B or Y to show"))?;
    let mut bytes = Vec::new();
    match PictureKind::of(path) {
        Some(PictureKind::Png) => colour.encode_png(plate.display, &mut bytes),
        Some(PictureKind::Jpeg) => colour.encode_jpeg(plate.display, &mut bytes),
        _ => return Err(ImageError::frame(path, "pictures end in .png, .jpg or .jpeg")),
    }
    .map_err(|failed| ImageError::frame(path, failed.to_string()))?;
    let metadata = plate.parts.first().and_then(|part| FrameMetadata::from_layer(&part.attributes));
    if let (Some(PictureKind::Png), Some(metadata)) = (PictureKind::of(path), metadata) {
        bytes = png_note::noted(bytes, &metadata);
    }
    replace_file(to, |file| file.write_all(&bytes).map_err(|source| ImageError::writing(path, source)))
}

/// Converts an 8-bit picture in memory as [`read_picture`] does for a PNG, with 1 channel for grey, 2 for grey and
/// alpha, 3 for RGB, 4 for RGBA. `None` for other numbers of channels, or if the size is not width x height x channels.
#[cfg(feature = "python")]
pub(crate) fn plate_of_bytes([width, height]: [u32; 2], channels: usize, bytes: Vec<u8>) -> Option<Plate> {
    use ::image::ImageBuffer;
    let picture = match channels {
        1 => DynamicImage::ImageLuma8(ImageBuffer::from_raw(width, height, bytes)?),
        2 => DynamicImage::ImageLumaA8(ImageBuffer::from_raw(width, height, bytes)?),
        3 => DynamicImage::ImageRgb8(ImageBuffer::from_raw(width, height, bytes)?),
        4 => DynamicImage::ImageRgba8(ImageBuffer::from_raw(width, height, bytes)?),
        _ => return None,
    };
    Some(plate_from_picture(picture, Codes::Color))
}

/// Converts the display window of a plate to the bytes that [`write_picture`] would write to an 8-bit PNG, with 1 to 4
/// channels as in [`plate_of_bytes`]. `None` if it has no colour.
#[cfg(feature = "python")]
pub(crate) fn bytes_of_plate(plate: &Plate, channels: usize) -> Option<Vec<u8>> {
    let colour = Colour::of(plate)?;
    let code = |light, alpha| {
        let [red, green, blue, alpha] = straight(light, alpha, u16::from(u8::MAX));
        if channels == 2 { [red, alpha, 0, 0] } else { [red, green, blue, alpha] }
    };
    Some(bytes_of(&colour.codes(plate.display, channels, code)))
}

/// The visible channels of a part.
struct Colour<'a> {
    window: PixelRect,
    storage: Storage,
    red_green_blue: [Option<&'a [f32]>; 3],
    alpha: Option<&'a [f32]>,
}

impl<'a> Colour<'a> {
    fn of(plate: &'a Plate) -> Option<Self> {
        let part =
            plate.parts.iter().find(|part| ["R", "G", "B", "Y"].iter().any(|name| part.channel(name).is_some()))?;
        let samples = |name| part.channel(name).map(|channel: &Channel| channel.samples.as_slice());
        let grey = samples("Y");
        let red_green_blue = ["R", "G", "B"].map(|name| samples(name).or(grey));
        Some(Self { window: part.data_window, storage: storage_of(part), red_green_blue, alpha: samples("A") })
    }

    fn encode_png(&self, display: PixelRect, bytes: &mut Vec<u8>) -> ::image::ImageResult<()> {
        let is_eight_bit = self.storage == Storage::Half;
        let (count, kind) = match (self.alpha, is_eight_bit) {
            (None, true) => (3, ExtendedColorType::Rgb8),
            (None, false) => (3, ExtendedColorType::Rgb16),
            (Some(_), true) => (4, ExtendedColorType::Rgba8),
            (Some(_), false) => (4, ExtendedColorType::Rgba16),
        };
        let largest = if is_eight_bit { u16::from(u8::MAX) } else { u16::MAX };
        let codes = self.codes(display, count, |colour, alpha| straight(colour, alpha, largest));
        let raw = if is_eight_bit { bytes_of(&codes) } else { bytemuck::cast_slice(&codes).to_vec() };
        let encoder = PngEncoder::new_with_quality(bytes, CompressionType::Fast, FilterType::Adaptive);
        encoder.write_image(&raw, display.width, display.height, kind)
    }

    fn encode_jpeg(&self, display: PixelRect, bytes: &mut Vec<u8>) -> ::image::ImageResult<()> {
        let codes = self.codes(display, 3, |colour, _| straight(colour, 1.0, u16::from(u8::MAX)));
        let encoder = JpegEncoder::new_with_quality(bytes, JPEG_QUALITY);
        encoder.write_image(&bytes_of(&codes), display.width, display.height, ExtendedColorType::Rgb8)
    }

    /// Returns `count` codes for each pixel of the display window; 0 outside the data window.
    fn codes(&self, display: PixelRect, count: usize, code: impl Fn([f32; 3], f32) -> [u16; 4] + Sync) -> Vec<u16> {
        let width = display.width as usize;
        let mut codes = vec![0; count * display.area()];
        codes.par_chunks_exact_mut((count * width).max(1)).enumerate().for_each(|(row, line)| {
            for (column, pixel) in line.chunks_exact_mut(count).enumerate() {
                let Some(index) = self.window.sample_index(display.pixel_at(row * width + column)) else { continue };
                let colour = self.red_green_blue.map(|samples| samples.map_or(0.0, |samples| samples[index]));
                let alpha = self.alpha.map_or(1.0, |samples| samples[index]);
                pixel.copy_from_slice(&code(colour, alpha)[..count]);
            }
        });
        codes
    }
}

/// Returns the pixel type with the highest precision among the colour channels.
fn storage_of(part: &PlatePart) -> Storage {
    let colour = part.channels.iter().filter(|channel| ["R", "G", "B", "Y"].contains(&channel.name.as_str()));
    if colour.into_iter().all(|channel| channel.storage == Storage::Half) { Storage::Half } else { Storage::Float }
}

/// Converts associated light to straight codes 0 to `largest`.
fn straight(colour: [f32; 3], alpha: f32, largest: u16) -> [u16; 4] {
    let colour = colour.map(|light| if light.is_nan() { 0.0 } else { light.max(0.0) });
    let strongest = colour.into_iter().fold(0.0, f32::max);
    // f32::max returns the other operand if alpha is NaN.
    let alpha = alpha.max(strongest).clamp(0.0, 1.0);
    let code = |unit: f32| (unit * f32::from(largest)).round() as u16;
    let [red, green, blue] = colour.map(|light| code(srgb_from_linear((light / alpha.max(HIDDEN)).min(1.0))));
    [red, green, blue, code(alpha)]
}

fn bytes_of(codes: &[u16]) -> Vec<u8> {
    codes.iter().map(|&code| code as u8).collect()
}

/// Reads an EXR, PNG or JPEG file, by its extension.
///
/// # Errors
/// [`ImageError`] as [`super::read_plate`] and [`read_picture`], and for a name without a known ending.
pub fn read_any(path: &Path) -> Result<Plate, ImageError> {
    match PictureKind::known(path)? {
        PictureKind::Exr => super::read_plate(path),
        PictureKind::Png | PictureKind::Jpeg => read_picture(path),
    }
}

/// Reads an EXR, PNG or JPEG file that contains numbers, such as an STMap: the codes of a PNG or JPEG count from 0 to 1, without the
/// transfer function of sRGB.
///
/// # Errors
/// As [`read_any`].
pub(crate) fn read_numbers(path: &Path) -> Result<Plate, ImageError> {
    match PictureKind::known(path)? {
        PictureKind::Exr => super::read_plate(path),
        PictureKind::Png | PictureKind::Jpeg => Ok(plate_from_picture(decode(path)?, Codes::Numbers)),
    }
}

/// Reads the header of an EXR file, without samples; PNG and JPEG files are read completely.
///
/// # Errors
/// As [`read_any`], for files that cannot be opened or whose header is damaged.
pub fn read_any_head(path: &Path) -> Result<Plate, ImageError> {
    if PictureKind::of(path) == Some(PictureKind::Exr) {
        super::plate_read::read_plate_head(path)
    } else {
        read_any(path)
    }
}

/// Writes an EXR, PNG or JPEG file, by its extension.
///
/// # Errors
/// [`ImageError`] as [`super::write_plate`] and [`write_picture`], and for a name without a known ending.
pub fn write_any<'a>(to: impl Into<Destination<'a>>, plate: &Plate) -> Result<(), ImageError> {
    let to = to.into();
    match PictureKind::known(to.path)? {
        PictureKind::Exr => super::write_plate(to, plate),
        PictureKind::Png | PictureKind::Jpeg => write_picture(to, plate),
    }
}
