//! An EXR file becomes a frame.
//!
//! In: a path. Out: [`Frame`] with all channels in the file's order (alphabetical in each part); metadata.

use super::{Frame, FrameMetadata, ImageError, exr_guard, read_plate};
use std::path::Path;

/// Reads a flat EXR file: all channels of its first part, and those of further parts with the same data window and new
/// names.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened, is damaged or cut off, is deep, or has subsampled channels.
pub fn read_exr(path: &Path) -> Result<Frame, ImageError> {
    Ok(read_plate(path)?.into_frame())
}

/// What a file written by [`super::write_exr`] or [`super::write_plate`] says about itself; `None` where the file came
/// from elsewhere. The camera is not read back. Only the head of the file is read.
///
/// # Errors
/// [`ImageError`] where the file cannot be opened or its head is damaged.
pub fn read_metadata(path: &Path) -> Result<Option<FrameMetadata>, ImageError> {
    let head = exr_guard::read_head(path)?;
    Ok(head.headers.first().and_then(|header| FrameMetadata::from_layer(&header.own_attributes)))
}
