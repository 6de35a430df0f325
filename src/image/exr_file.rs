//! The common part of writing EXR files.
//!
//! In: an image of the EXR crate whose channels are [`Lines`]. Out: the file, written atomically and deterministically.
//! Samples are converted line by line, so the frame is not copied.

use super::atomic::{Destination, replace_file};
use super::{Channel, ImageError, Storage, exr_head};
use crate::space::PixelRect;
use crate::spelling::pluralised;
use exr::block::lines::LineRefMut;
use exr::image::write::WritableImage;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::image::{AnyChannels, Image, Layers};
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::{LevelMode, SampleType, Text};
use exr::meta::header::Header;
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::collections::HashSet;

/// Skips the crate's validation, which rejects files in common use (standard attribute names with unusual types). Its
/// other checks hold by construction, or are made before.
pub(super) fn write(to: Destination, image: &Image<Layers<AnyChannels<Lines<'_>>>>) -> Result<(), ImageError> {
    let path = to.path;
    replace_file(to, |mut file| {
        let writer = image.write().skip_compatibility_checks();
        writer.to_unbuffered(&mut file).map_err(|failed| match failed {
            exr::error::Error::Io(source) => ImageError::writing(path, source),
            other => ImageError::frame(path, other.to_string()),
        })?;
        let stamped = exr_head::sort_attributes(file).and_then(|checksums| exr_head::stamp(file, &checksums));
        stamped.map_err(|source| ImageError::writing(path, source))
    })
}

/// Encodes a text as UTF-8, as OpenEXR specifies; the crate would treat each byte as a character.
pub(super) fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Decodes a text; bytes of old files that are not UTF-8 are read as Latin-1.
pub(super) fn string(text: &Text) -> String {
    std::str::from_utf8(text.as_slice()).map_or_else(|_| text.to_string(), str::to_owned)
}

pub(super) fn size_of(window: PixelRect) -> Vec2<usize> {
    Vec2(window.width as usize, window.height as usize)
}

/// `Err` describes what is wrong.
pub(super) fn check_aspect(aspect: f64) -> Result<(), String> {
    if (1e-6..=1e6).contains(&aspect) {
        return Ok(());
    }
    Err(format!("the pixel aspect {aspect} is not between 1e-6 and 1e6"))
}

/// Fails if a coordinate is out of the range of EXR files (±2^30).
pub(super) fn check_window(name: &str, window: PixelRect) -> Result<(), String> {
    const LIMIT: i64 = (i32::MAX / 2) as i64;
    let (left, top) = (i64::from(window.x), i64::from(window.y));
    let edges = [left, top, left + i64::from(window.width), top + i64::from(window.height)];
    let far = edges.into_iter().find(|edge| edge.abs() >= LIMIT);
    far.map_or(Ok(()), |edge| Err(format!("the {name} reaches pixel {edge}, too far out for EXR")))
}

/// Fails if there are no channels, or on name clashes or wrong numbers of samples.
pub(super) fn check_channels(channels: &[Channel], window: PixelRect) -> Result<(), String> {
    if channels.is_empty() {
        return Err("the frame has no channels; ask for at least one".into());
    }
    let mut names = HashSet::new();
    for Channel { name, samples, .. } in channels {
        if samples.len() != window.area() {
            let found = pluralised(samples.len(), "sample", "samples");
            return Err(format!("channel '{name}' has {found} for {}", pluralised(window.area(), "pixel", "pixels")));
        }
        if name.is_empty() || name.len() > 255 || name.bytes().any(|byte| byte == 0) {
            return Err(format!("'{name}' is not a valid channel name; use 1 to 255 characters"));
        }
        if !names.insert(name) {
            return Err(format!("two channels are called '{name}'"));
        }
    }
    Ok(())
}

/// Treatment of NaN, and of infinities in half channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NonFinitePolicy {
    /// NaN becomes 0, infinity the largest half float.
    Contained,
    /// Preserved; finite numbers still never become infinite.
    Kept,
}

/// A channel that provides its lines in the file's pixel type.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    storage: Storage,
    non_finite: NonFinitePolicy,
    samples: &'a [f32],
    /// Width in pixels; 0 until the header is known.
    width: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn of(channel: &'a Channel, non_finite: NonFinitePolicy) -> Self {
        Self { storage: channel.storage, non_finite, samples: &channel.samples, width: 0 }
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
        match (self.storage, self.non_finite) {
            (Storage::Half, NonFinitePolicy::Contained) => write_halves(samples, line.value, contained_in_half),
            (Storage::Half, NonFinitePolicy::Kept) => write_halves(samples, line.value, finite_in_half),
            (Storage::Float, NonFinitePolicy::Contained) => {
                write_words(samples, line.value, |sample| if sample.is_nan() { 0 } else { sample.to_bits() })
            }
            (Storage::Float, NonFinitePolicy::Kept) | (Storage::Uint, _) => {
                write_words(samples, line.value, f32::to_bits)
            }
        }
    }
}

/// The crate expects native byte order and converts it to that of the file.
fn write_words(samples: &[f32], bytes: &mut [u8], bits: impl Fn(f32) -> u32) {
    for (word, &sample) in bytes.chunks_exact_mut(4).zip(samples) {
        word.copy_from_slice(&bits(sample).to_ne_bytes());
    }
}

fn write_halves(samples: &[f32], bytes: &mut [u8], contain: impl Fn(f32) -> f32) {
    const CHUNK: usize = 256;
    let (mut contained, mut halves) = ([0.0_f32; CHUNK], [f16::ZERO; CHUNK]);
    for (samples, bytes) in samples.chunks(CHUNK).zip(bytes.chunks_mut(2 * CHUNK)) {
        let (contained, halves) = (&mut contained[..samples.len()], &mut halves[..samples.len()]);
        for (to, from) in contained.iter_mut().zip(samples) {
            *to = contain(*from);
        }
        halves.convert_from_f32_slice(contained);
        for (word, half) in bytes.chunks_exact_mut(2).zip(halves) {
            word.copy_from_slice(&half.to_ne_bytes());
        }
    }
}

/// The largest half float.
const LIMIT: f32 = f16::MAX.to_f32_const();

/// Replaces NaN by 0, and clamps to the range of half floats.
fn contained_in_half(sample: f32) -> f32 {
    if sample.is_nan() { 0.0 } else { sample.clamp(-LIMIT, LIMIT) }
}

/// Keeps NaN and infinities, and clamps finite numbers to the range of half floats.
fn finite_in_half(sample: f32) -> f32 {
    if sample.is_finite() { sample.clamp(-LIMIT, LIMIT) } else { sample }
}
