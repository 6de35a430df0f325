//! Writes a plate as an EXR file.
//!
//! In: [`Plate`]. Out: a file with the same parts, channels, attributes, compression and tiles.

use super::atomic::Destination;
use super::exr_file::{self, Lines, NonFinitePolicy, check_aspect, check_channels, check_window, size_of, text};
use super::{Channel, ImageError, Plate, PlatePart};
use crate::space::PixelRect;
use exr::image::{AnyChannel, AnyChannels, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{IntegerBounds, LineOrder};
use std::borrow::Cow;
use std::collections::HashSet;

/// Writes `plate` atomically and deterministically, as [`super::write_exr`] does.
///
/// Each part keeps its compression, even if lossy, and its tiles; tiles in random order are written in increasing order. A part without
/// pixels is written as one empty pixel. NaN and infinities are preserved; finite half samples beyond ±65504 become ±65504.
///
/// # Errors
/// [`ImageError::Io`] if the disk is full or the directory is not writable; [`ImageError::Frame`] if the plate is
/// malformed: no parts, duplicate part names, samples that do not match their window.
pub fn write_plate<'a>(to: impl Into<Destination<'a>>, plate: &Plate) -> Result<(), ImageError> {
    let to = to.into();
    check(plate).map_err(|what| ImageError::frame(to.path, what))?;
    let parts: Vec<_> = plate.parts.iter().map(|part| with_a_pixel(part, plate.display)).collect();
    let mut shared = plate.attributes.clone();
    shared.display_window = IntegerBounds::new(Vec2(plate.display.x, plate.display.y), size_of(plate.display));
    shared.pixel_aspect = plate.pixel_aspect as f32;
    let layers = parts.iter().map(|part| exr_layer(part)).collect();
    exr_file::write(to, &Image { attributes: shared, layer_data: layers })
}

/// Checks the requirements of EXR; the error describes what is wrong.
fn check(plate: &Plate) -> Result<(), String> {
    if plate.parts.is_empty() || plate.display.area() == 0 {
        return Err("the plate has no parts or no pixels".into());
    }
    check_aspect(plate.pixel_aspect)?;
    check_window("display window", plate.display)?;
    check_names(&plate.parts)?;
    for part in &plate.parts {
        let within = |what| format!("part '{}': {what}", part.name.as_deref().unwrap_or_default());
        check_window("data window", part.data_window).map_err(within)?;
        check_channels(&part.channels, part.data_window).map_err(within)?;
    }
    Ok(())
}

/// Checks that the parts of a multi-part file have distinct names.
fn check_names(parts: &[PlatePart]) -> Result<(), String> {
    let mut names = HashSet::new();
    for part in parts.iter().filter(|_| parts.len() > 1) {
        let Some(name) = &part.name else { return Err("a part has no name, which files of several parts need".into()) };
        if !names.insert(name) {
            return Err(format!("two parts are called '{name}'"));
        }
    }
    Ok(())
}

/// Replaces an empty data window, which EXR does not allow, by one empty pixel.
fn with_a_pixel(part: &PlatePart, display: PixelRect) -> Cow<'_, PlatePart> {
    if part.data_window.area() > 0 {
        return Cow::Borrowed(part);
    }
    let window = PixelRect { x: display.x, y: display.y, width: 1, height: 1 };
    let nothing = |channel: &Channel| Channel { samples: vec![channel.empty_value()], ..channel.clone() };
    Cow::Owned(part.with_channels(window, part.channels.iter().map(nothing).collect()))
}

fn exr_layer(part: &PlatePart) -> Layer<AnyChannels<Lines<'_>>> {
    let mut attributes = part.attributes.clone();
    attributes.layer_position = Vec2(part.data_window.x, part.data_window.y);
    attributes.layer_name = part.name.as_deref().map(text);
    attributes.view_name = part.view.as_deref().map(text);
    let mut encoding = part.encoding;
    if encoding.line_order == LineOrder::Unspecified {
        // Blocks would be written in the order in which threads finish them.
        encoding.line_order = LineOrder::Increasing;
    }
    // AnyChannels::sort establishes the alphabetical order that EXR requires.
    let channels = AnyChannels::sort(part.channels.iter().map(|channel| exr_channel(part, channel)).collect());
    Layer::new(size_of(part.data_window), attributes, encoding, channels)
}

fn exr_channel<'a>(part: &PlatePart, channel: &'a Channel) -> AnyChannel<Lines<'a>> {
    let new = AnyChannel::new(text(&channel.name), Lines::of(channel, NonFinitePolicy::Kept));
    let quantize_linearly = part.linear.get(&channel.name).copied().unwrap_or(new.quantize_linearly);
    AnyChannel { quantize_linearly, ..new }
}
