//! Reads an EXR file into a frame.
//!
//! In: a path. Out: [`Frame`] with all channels in file order (alphabetical in each part); metadata.

use super::{Frame, FrameMetadata, ImageError, exr_guard, read_plate};
use std::path::Path;

/// Reads a flat EXR file: all channels of its first part, and those of further parts with the same data window and new names.
///
/// # Errors
/// [`ImageError`] if the file cannot be opened, is damaged or truncated, is deep, or has subsampled channels.
pub fn read_exr(path: &Path) -> Result<Frame, ImageError> {
    Ok(read_plate(path)?.into_frame())
}

/// Reads the metadata of a file written by [`super::write_exr`] or [`super::write_plate`]; `None` for files of other
/// programs. The camera is not read back. Reads only the header.
///
/// # Errors
/// [`ImageError`] if the file cannot be opened or its header is damaged.
pub fn read_metadata(path: &Path) -> Result<Option<FrameMetadata>, ImageError> {
    let head = exr_guard::read_head(path)?;
    Ok(head.headers.first().and_then(|header| FrameMetadata::from_layer(&header.own_attributes)))
}
