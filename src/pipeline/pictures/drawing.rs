//! Reads a picture of a shot anew, at its own resolution, to find the lines of the drawing.
//!
//! In: the paths of a shot. Out: a [`Drawing`], which does not depend on the size of the frame, and the size of its canvas.

use super::read::{FlatPicture, flat_pictures};
use crate::image::{Drawing, read_any};
use crate::pipeline::PipelineError;
use crate::shot::{Shot, Source};
use std::path::Path;

/// Reads the first picture of a file; `None` if it is empty.
///
/// # Errors
/// [`PipelineError`] if the file cannot be read or holds no colour.
pub(in crate::pipeline) fn drawing_in(shot: &Shot, file: &Path) -> Result<Option<(Drawing, [u32; 2])>, PipelineError> {
    let (found, _) = flat_pictures(shot, file, &read_any(file)?)?;
    Ok(found.first().and_then(drawn))
}

/// Reads the picture of this name; `None` if the shot has none, or if it is empty.
///
/// # Errors
/// [`PipelineError`] if a file cannot be read.
pub(in crate::pipeline) fn drawing_of(shot: &Shot, name: &str) -> Result<Option<(Drawing, [u32; 2])>, PipelineError> {
    let Source::Images(paths) = &shot.source else { return Ok(None) };
    for path in paths {
        let (found, _) = flat_pictures(shot, path, &read_any(path)?)?;
        if let Some(picture) = found.iter().find(|picture| picture.name == name) {
            return Ok(drawn(picture));
        }
    }
    Ok(None)
}

fn drawn(picture: &FlatPicture) -> Option<(Drawing, [u32; 2])> {
    let size = picture.plate.frame_size();
    let size = [size.width, size.height];
    let planes: Vec<&[f32]> = picture.planes().collect();
    Some((Drawing::of(planes.try_into().ok()?, picture.window(), size)?, size))
}
