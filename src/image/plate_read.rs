//! Reads an EXR file into a plate.
//!
//! In: a path. Out: [`Plate`] with everything in the file except for the smaller levels of mip maps.

use super::cryptomatte::take_in_manifests;
use super::exr_file::string;
use super::plate::no_shared_attributes;
use super::{Channel, ImageError, Plate, PlatePart, Storage, exr_guard};
use crate::space::PixelRect;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{LevelMode, SampleType};
use exr::meta::header::{Header, ImageAttributes};
use exr::meta::{BlockDescription, MetaData};
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;
use std::path::Path;

/// Reads a flat EXR file: all parts, views, channels and attributes. Keeps tiling; of mip maps only the largest level
/// is read, which [`Plate::left_out`] reports. Cryptomatte manifests in sidecar files are loaded into the header.
///
/// # Errors
/// [`ImageError`] if the file cannot be opened, is damaged or truncated, is deep, or has subsampled channels.
pub fn read_plate(path: &Path) -> Result<Plate, ImageError> {
    let head = exr_guard::checked_head(path)?;
    let read = exr::image::read::read_all_flat_layers_from_file(path);
    let image = read.map_err(|failed| exr_guard::read_error(path, failed))?;
    let shared = image.attributes;
    let parts = image.layer_data.into_iter().map(|layer| plate_part(path, layer));
    let mut plate = Plate {
        display: rect(path, shared.display_window.position, shared.display_window.size)?,
        pixel_aspect: f64::from(shared.pixel_aspect),
        parts: parts.collect::<Result<_, _>>()?,
        left_out: head.headers.iter().enumerate().filter_map(left_out).collect(),
        attributes: shared_attributes(head),
    };
    if plate.parts.is_empty() {
        return Err(ImageError::damaged(path, "it has no parts"));
    }
    take_in_manifests(&mut plate, path);
    Ok(plate)
}

/// Reads the header of a flat EXR file: parts, windows, channels and attributes, without samples.
///
/// # Errors
/// [`ImageError`] if the file cannot be opened or its header is damaged.
pub(super) fn read_plate_head(path: &Path) -> Result<Plate, ImageError> {
    let head = exr_guard::read_head(path)?;
    let first = head.headers.first().ok_or_else(|| ImageError::damaged(path, "it has no parts"))?;
    let (window, aspect) = (first.shared_attributes.display_window, first.shared_attributes.pixel_aspect);
    let display = rect(path, window.position, window.size)?;
    let parts = head.headers.into_iter().map(|header| part_head(path, header)).collect::<Result<_, _>>()?;
    let mut plate = Plate::new(display, f64::from(aspect), parts);
    take_in_manifests(&mut plate, path);
    Ok(plate)
}

fn part_head(path: &Path, header: Header) -> Result<PlatePart, ImageError> {
    let data_window = rect(path, header.own_attributes.layer_position, header.layer_size)?;
    let storage = |kind: SampleType| match kind {
        SampleType::F16 => Storage::Half,
        SampleType::F32 => Storage::Float,
        SampleType::U32 => Storage::Uint,
    };
    let channels = header.channels.list.iter().map(|channel| Channel {
        name: string(&channel.name),
        storage: storage(channel.sample_type),
        samples: Vec::new(),
    });
    let mut part = PlatePart::new(data_window, channels.collect());
    part.encoding.compression = header.compression;
    part.attributes = header.own_attributes;
    part.name = part.attributes.layer_name.take().as_ref().map(string);
    part.view = part.attributes.view_name.take().as_ref().map(string);
    Ok(part)
}

/// Merges the shared attributes: parts should agree on them, but some programs set them in one part only.
fn shared_attributes(head: MetaData) -> ImageAttributes {
    let mut shared = no_shared_attributes();
    for header in head.headers {
        let own = header.shared_attributes;
        shared.chromaticities = shared.chromaticities.or(own.chromaticities);
        shared.time_code = shared.time_code.or(own.time_code);
        own.other.into_iter().for_each(|(name, value)| {
            shared.other.entry(name).or_insert(value);
        });
    }
    shared
}

fn left_out((index, header): (usize, &Header)) -> Option<String> {
    let BlockDescription::Tiles(tiles) = header.blocks else { return None };
    let levels = match tiles.level_mode {
        LevelMode::Singular => return None,
        LevelMode::MipMap => "mip",
        LevelMode::RipMap => "rip",
    };
    let name = header.own_attributes.layer_name.as_ref().map_or_else(|| (index + 1).to_string(), string);
    Some(format!("part '{name}': the smaller {levels} levels"))
}

fn plate_part(path: &Path, layer: Layer<AnyChannels<FlatSamples>>) -> Result<PlatePart, ImageError> {
    let data_window = rect(path, layer.attributes.layer_position, layer.size)?;
    let mut attributes = layer.attributes;
    attributes.layer_position = Vec2(0, 0);
    let list = layer.channel_data.list;
    Ok(PlatePart {
        name: attributes.layer_name.take().as_ref().map(string),
        view: attributes.view_name.take().as_ref().map(string),
        data_window,
        linear: list.iter().map(|channel| (string(&channel.name), channel.quantize_linearly)).collect(),
        channels: list
            .into_vec()
            .into_par_iter()
            .map(|channel| plate_channel(path, channel))
            .collect::<Result<_, _>>()?,
        attributes,
        encoding: layer.encoding,
    })
}

fn rect(path: &Path, position: Vec2<i32>, size: Vec2<usize>) -> Result<PixelRect, ImageError> {
    let side = |pixels| u32::try_from(pixels).map_err(|_| ImageError::damaged(path, "its windows are too large"));
    Ok(PixelRect { x: position.x(), y: position.y(), width: side(size.width())?, height: side(size.height())? })
}

fn plate_channel(path: &Path, channel: AnyChannel<FlatSamples>) -> Result<Channel, ImageError> {
    let name = string(&channel.name);
    if channel.sampling != Vec2(1, 1) {
        let what = format!("channel '{name}' is subsampled; export RGB at full resolution");
        return Err(ImageError::unsupported(path, what));
    }
    let (storage, samples) = match channel.sample_data {
        FlatSamples::F16(halves) => (Storage::Half, halves.to_f32_vec()),
        FlatSamples::F32(floats) => (Storage::Float, floats),
        FlatSamples::U32(ids) => (Storage::Uint, ids.into_iter().map(f32::from_bits).collect()),
    };
    Ok(Channel { name, storage, samples })
}
