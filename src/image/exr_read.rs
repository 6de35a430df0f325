//! An EXR file becomes a frame.
//!
//! In: a path. Out: [`Frame`] with all channels in the file's order (alphabetical in each part); metadata.

use super::{Channel, Frame, FrameMetadata, ImageError, Storage};
use crate::space::PixelRect;
use exr::block::chunk::CompressedBlock;
use exr::image::{AnyChannel, AnyChannels, FlatImage, FlatSamples, Layer};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::Compression;
use exr::meta::header::Header;
use half::slice::HalfFloatSliceExt;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Reads a flat EXR file: all channels of its first part, and those of further parts with the same data window and new
/// names.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened, is damaged or cut off, is deep, or has subsampled channels.
pub fn read_exr(path: &Path) -> Result<Frame, ImageError> {
    check_size(path)?;
    check_dwa(path)?;
    let image = exr::image::read::read_all_flat_layers_from_file(path).map_err(|failed| read_error(path, failed))?;
    frame_from_image(path, image)
}

/// One wrong byte in the head may promise a picture of petabytes: asks for the memory before the reader takes it.
fn check_size(path: &Path) -> Result<(), ImageError> {
    let head = MetaData::read_from_file(path, false).map_err(|failed| read_error(path, failed))?;
    let part_bytes = head.headers.iter().map(|header| {
        let pixels = header.layer_size.width() as u128 * header.layer_size.height() as u128;
        pixels * header.channels.bytes_per_pixel as u128
    });
    let bytes = part_bytes.sum::<u128>();
    let is_there_memory = usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    if is_there_memory {
        return Ok(());
    }
    let what = format!("its head promises {} GB of pixels, more than this machine can hold", bytes / 1_000_000_000);
    Err(ImageError::damaged(path, what))
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

/// A DWA chunk begins with nine sizes that the reader believes as they stand. Goes through the chunks without decoding.
fn check_dwa(path: &Path) -> Result<(), ImageError> {
    let damaged = |failed| read_error(path, failed);
    let file = File::open(path).map_err(|source| ImageError::reading(path, source))?;
    let reader = exr::block::read(BufReader::new(file), false).map_err(damaged)?;
    let headers = reader.headers().to_vec();
    if !headers.iter().any(is_dwa) {
        return Ok(());
    }
    for chunk in reader.all_chunks(false).map_err(damaged)? {
        let chunk = chunk.map_err(damaged)?;
        let bytes = match &chunk.compressed_block {
            CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
            CompressedBlock::Tile(block) => &block.compressed_pixels_le,
            _ => continue,
        };
        if headers.get(chunk.layer_index).is_some_and(|header| is_dwa(header) && !are_dwa_sizes_sane(header, bytes)) {
            return Err(ImageError::damaged(path, "a DWA chunk promises more than its block can hold"));
        }
    }
    Ok(())
}

fn is_dwa(header: &Header) -> bool {
    matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_))
}

/// The sizes follow the version, eight bytes each (OpenEXR, DataSizesSingle). Blocks of 8x8 make a thin picture 64 times
/// larger at worst.
fn are_dwa_sizes_sane(header: &Header, chunk: &[u8]) -> bool {
    let limit = 64 * header.max_block_byte_size() as u64 + (1 << 16);
    let sizes = chunk.chunks_exact(8).skip(1).take(9).filter_map(|bytes| bytes.first_chunk::<8>());
    sizes.copied().all(|bytes| u64::from_le_bytes(bytes) <= limit)
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

fn frame_from_image(path: &Path, image: FlatImage) -> Result<Frame, ImageError> {
    let display = image.attributes.display_window;
    let mut parts = image.layer_data.into_iter();
    let first = parts.next().ok_or_else(|| ImageError::damaged(path, "it has no parts"))?;
    let window = first.absolute_bounds();
    let mut frame = Frame {
        display: rect(path, display.position, display.size)?,
        data_window: rect(path, window.position, window.size)?,
        pixel_aspect: f64::from(image.attributes.pixel_aspect),
        channels: frame_channels(path, first)?,
    };
    for part in parts.filter(|part| part.absolute_bounds() == window) {
        let more = frame_channels(path, part)?;
        let new: Vec<_> = more.into_iter().filter(|channel| frame.channel(&channel.name).is_none()).collect();
        frame.channels.extend(new);
    }
    Ok(frame)
}

fn frame_channels(path: &Path, part: Layer<AnyChannels<FlatSamples>>) -> Result<Vec<Channel>, ImageError> {
    part.channel_data.list.into_iter().map(|channel| frame_channel(path, channel)).collect()
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
