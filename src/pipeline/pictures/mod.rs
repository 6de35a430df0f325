//! Shots of pictures: the pictures are read once, solved like models, and drawn by warping them.
//!
//! In: the paths of a shot. Out: a [`Gallery`] and the scene that represents it; frames.

mod branches;
mod composite_parts;
#[cfg(any(test, feature = "editor"))]
mod draft;
mod drawing;
#[cfg(any(test, feature = "cli"))]
mod element;
mod frames;
mod paint;
#[cfg(any(test, feature = "editor"))]
pub(super) mod plate_drafts;
mod read;
mod recent;

#[cfg(any(test, feature = "editor"))]
pub(super) use draft::paint_draft;
pub(super) use drawing::{drawing_in, drawing_of};
pub(super) use frames::{left_out_channels, paint_frames};
#[cfg(any(test, feature = "editor", feature = "python"))]
pub(super) use frames::{paint_frame, times};

use crate::image::{ImageError, PictureExtent, Storage, picture_extent, read_any};
use crate::memory;
use crate::pipeline::PipelineError;
use crate::scene::{Picture, Scene, picture_cards};
use crate::shot::Shot;
use crate::space::FrameSize;
use read::FlatPicture;
use recent::Recent;
use std::path::{Path, PathBuf};

/// The pictures of a shot from back to front, one per node of its scene.
#[derive(Clone, Debug)]
pub(super) struct Gallery {
    /// Size at which the pictures are drawn, which is that of the frame; they are scaled to it when loaded.
    frame: FrameSize,
    flat_pictures: Vec<FlatPicture>,
    /// Full float unless all pictures are half float.
    storage: Storage,
    /// The same pictures in the sizes of drafts.
    #[cfg_attr(not(any(test, feature = "editor")), expect(dead_code, reason = "only the editor draws drafts"))]
    small: Recent<FrameSize, Gallery>,
}

impl Gallery {
    /// Reads all pictures and lays them out as a scene.
    ///
    /// # Errors
    /// [`PipelineError`] if a picture cannot be read, is empty, or does not match the size of the others or the shape of the frame.
    pub(super) fn load(shot: &Shot, paths: &[PathBuf]) -> Result<(Self, Scene), PipelineError> {
        check_memory(paths)?;
        let (mut flat_pictures, mut left_out) = (Vec::new(), Vec::new());
        let mut frame: Option<(FrameSize, &Path)> = None;
        for path in paths {
            let plate = read_any(path)?;
            let size = plate.frame_size();
            match frame {
                Some((first, of)) if first != size => return Err(unequal(shot, (first, of), (size, path))),
                _ => frame = Some((size, path)),
            }
            let (found, others) = read::flat_pictures(shot, path, &plate)?;
            flat_pictures.extend(found);
            left_out.extend(
                plate.left_out.iter().chain(&others).map(|what| format!("left out of {}: {what}", path.display())),
            );
        }
        let Some((frame, first)) = frame else {
            return Err(PipelineError::mismatch(shot, "image", "names no picture", "name one"));
        };
        check_shape(shot, frame, first)?;
        check_names(shot, &flat_pictures)?;
        let pictures: Vec<Picture> = flat_pictures.iter().map(FlatPicture::picture).collect();
        let mut scene = picture_cards(frame, &pictures)?;
        scene.warnings.extend(left_out);
        let is_half = flat_pictures.iter().all(|flat_picture| flat_picture.storage == Storage::Half);
        let storage = if is_half { Storage::Half } else { Storage::Float };
        let gallery = Self { frame, flat_pictures, storage, small: Recent::default() }.sized(shot.size);
        Ok((gallery, scene))
    }

    /// Scales the pictures to another frame of the same shape.
    fn sized(self, size: FrameSize) -> Self {
        if [self.frame.width, self.frame.height] == [size.width, size.height] { self } else { self.scaled(size) }
    }

    /// Returns the pictures in another size.
    fn scaled(&self, size: FrameSize) -> Self {
        let flat_pictures =
            self.flat_pictures.iter().map(|flat_picture| flat_picture.scaled(self.frame, size)).collect();
        Self { frame: size, flat_pictures, storage: self.storage, small: Recent::default() }
    }
}

/// Checks the memory for all decoded pictures, the rendered frame, and one warped picture.
fn check_memory(paths: &[PathBuf]) -> Result<(), PipelineError> {
    let mut needed = 0;
    for path in paths {
        let PictureExtent { pixels, samples } = picture_extent(path)?;
        needed += 12 * samples + 40 * pixels;
        memory::check(needed).map_err(|source| ImageError::TooLarge { path: path.clone(), source })?;
    }
    Ok(())
}

fn sides(size: FrameSize) -> String {
    let FrameSize { width, height, pixel_aspect } = size;
    let aspect = if pixel_aspect == 1.0 { String::new() } else { format!(" (pixel aspect {pixel_aspect})") };
    format!("{width} x {height}{aspect}")
}

fn unequal(shot: &Shot, (first, of): (FrameSize, &Path), (size, path): (FrameSize, &Path)) -> PipelineError {
    let what = format!("{} shows {} pixels, {} shows {}", of.display(), sides(first), path.display(), sides(size));
    PipelineError::mismatch(shot, "image", what, "save all pictures of a shot on canvases of one size")
}

/// Checks the aspect ratio: a frame of another size shows the pictures scaled, one of another aspect ratio cannot.
fn check_shape(shot: &Shot, frame: FrameSize, path: &Path) -> Result<(), PipelineError> {
    if shot.size.is_as_wide_as(frame.aspect()) {
        return Ok(());
    }
    let what = format!(
        "the frame of {} pixels does not have the aspect ratio of {}, {}",
        sides(shot.size),
        path.display(),
        sides(frame)
    );
    Err(PipelineError::mismatch(shot, "size", what, "leave `size` out, or give one of the picture's aspect ratio"))
}

/// Checks that the pictures have different names, by which layers, pins and picks distinguish them.
fn check_names(shot: &Shot, flat_pictures: &[FlatPicture]) -> Result<(), PipelineError> {
    for (index, flat_picture) in flat_pictures.iter().enumerate() {
        if let Some(other) = flat_pictures[..index].iter().find(|other| other.name == flat_picture.name) {
            let what = format!(
                "{} and {} both hold a picture '{}'",
                other.path.display(),
                flat_picture.path.display(),
                flat_picture.name
            );
            return Err(PipelineError::mismatch(shot, "image", what, "rename one of them"));
        }
    }
    Ok(())
}
