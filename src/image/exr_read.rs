//! An EXR file becomes a frame.
//!
//! In: a path. Out: [`Frame`] with all channels of the first part, in the file's (alphabetical) order; metadata.

use super::{Channel, Frame, FrameMetadata, ImageError, Storage};
use crate::space::PixelRect;
use exr::image::{AnyChannel, AnyChannels, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::MetaData;
use half::slice::HalfFloatSliceExt;
use std::path::Path;

/// Reads all channels of the first part of a flat EXR file.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened, is damaged or cut off, is deep, or has subsampled channels.
pub fn read_exr(path: &Path) -> Result<Frame, ImageError> {
    let image = exr::image::read::read_first_flat_layer_from_file(path).map_err(|failed| read_error(path, failed))?;
    frame_from_image(path, image)
}

/// What a file written by [`super::write_exr`] says about itself; `None` where the file came from elsewhere. The camera
/// is not read back. Only the head of the file is read.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened or its head is damaged.
pub fn read_metadata(path: &Path) -> Result<Option<FrameMetadata>, ImageError> {
    let head = MetaData::read_from_file(path, false).map_err(|failed| read_error(path, failed))?;
    Ok(head.headers.first().and_then(|header| FrameMetadata::from_layer(&header.own_attributes)))
}

fn read_error(path: &Path, failed: exr::error::Error) -> ImageError {
    match failed {
        exr::error::Error::Io(source) => ImageError::reading(path, source),
        exr::error::Error::NotSupported(what) => {
            ImageError::unsupported(path, format!("{what}; export a flat scan-line EXR"))
        }
        other => ImageError::damaged(path, other.to_string()),
    }
}

fn frame_from_image(path: &Path, image: Image<Layer<AnyChannels<FlatSamples>>>) -> Result<Frame, ImageError> {
    let layer = image.layer_data;
    let display = image.attributes.display_window;
    let channels = layer.channel_data.list.into_iter().map(|channel| frame_channel(path, channel));
    Ok(Frame {
        display: rect(path, display.position, display.size)?,
        data_window: rect(path, layer.attributes.layer_position, layer.size)?,
        pixel_aspect: f64::from(image.attributes.pixel_aspect),
        channels: channels.collect::<Result<_, _>>()?,
    })
}

fn rect(path: &Path, position: Vec2<i32>, size: Vec2<usize>) -> Result<PixelRect, ImageError> {
    let side = |pixels| u32::try_from(pixels).map_err(|_| ImageError::damaged(path, "its windows are too large"));
    Ok(PixelRect { x: position.x(), y: position.y(), width: side(size.width())?, height: side(size.height())? })
}

fn frame_channel(path: &Path, channel: AnyChannel<FlatSamples>) -> Result<Channel, ImageError> {
    let name = channel.name.to_string();
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
