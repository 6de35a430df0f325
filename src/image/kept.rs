//! Decides which frames of an earlier run are kept.
//!
//! In: a path, and the expected metadata of the frame. Out: it is kept, or the reason why not.

#[cfg(feature = "cli")]
use super::FrameMetadata;
use super::provenance::{self, Provenance};
use super::{PictureKind, complete, exr_guard, exr_head, png_note};
use crate::space::FrameSize;
use std::fmt;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// The metadata that a kept frame must have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected<'a> {
    /// Frame number.
    pub(crate) frame: i32,
    /// Digest of all inputs: settings, a dot, and the contents of files.
    pub(crate) shot_hash: &'a str,
    /// The display window; `None`: any.
    pub(crate) size: Option<FrameSize>,
    /// Rendering device, as in [`super::FrameMetadata::device`]. Only CPU or GPU is compared, not the name.
    pub(crate) device: &'a str,
}

/// How much of a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// Header, offset table and the starts of chunks: about a millisecond.
    Head,
    /// Everything, to verify the checksum of the pixels.
    Pixels,
}

/// Why a frame is written again.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum StaleReason {
    /// The file does not exist.
    Missing,
    /// The file is truncated or damaged.
    Damaged,
    /// The file has no metadata of pinwarp.
    Foreign,
    /// Written by another version.
    OtherVersion(String),
    /// The file contains another frame.
    OtherFrame(i32),
    /// The display window has another size, in pixels.
    OtherSize([u32; 2]),
    /// Settings or pins have changed.
    OtherShot,
    /// The contents of an input file have changed.
    OtherContents,
    /// Drawn by another class of device.
    OtherDevice(String),
    /// The checksum of the pixels does not match.
    Checksum,
    /// The preview beside it is missing, damaged or outdated.
    Preview,
}

impl fmt::Display for StaleReason {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => out.write_str("it is missing"),
            Self::Damaged => out.write_str("the file is cut off or damaged"),
            Self::Foreign => out.write_str("pinwarp did not write the file"),
            Self::OtherVersion(version) if version.is_empty() => out.write_str("an older pinwarp wrote it"),
            Self::OtherVersion(version) => write!(out, "pinwarp {version} wrote it"),
            Self::OtherFrame(frame) => write!(out, "the file holds frame {frame}"),
            Self::OtherSize([width, height]) => write!(out, "its size is {width} x {height}"),
            Self::OtherShot => out.write_str("it was made from another state of the shot"),
            Self::OtherContents => {
                out.write_str("a file that it is made from (scene, picture, plate or lattice) has changed")
            }
            Self::OtherDevice(device) => write!(out, "it was drawn on {device}"),
            Self::Checksum => out.write_str("its pixels do not match their checksum"),
            Self::Preview => out.write_str("its preview is missing or out of date"),
        }
    }
}

/// Returns the metadata of a frame after checking that its file is complete.
///
/// # Errors
/// [`StaleReason::Missing`], [`StaleReason::Damaged`], [`StaleReason::Foreign`] or, if the pixels are read, [`StaleReason::Checksum`].
#[cfg(feature = "cli")]
pub(crate) fn read_whole(path: &Path, depth: Depth) -> Result<FrameMetadata, StaleReason> {
    let (found, _) = fields(path)?;
    if depth == Depth::Pixels && !has_right_pixels(path) {
        return Err(StaleReason::Checksum);
    }
    Ok(FrameMetadata::from_provenance(found))
}

/// Checks whether an existing frame equals the one that would be written now.
///
/// # Errors
/// The reason if it does not.
pub(crate) fn check_kept(path: &Path, expected: &Expected, depth: Depth) -> Result<(), StaleReason> {
    let (found, size) = fields(path)?;
    expected.check(&found, size)?;
    if depth == Depth::Pixels && !has_right_pixels(path) {
        return Err(StaleReason::Checksum);
    }
    Ok(())
}

/// Returns the metadata of a complete file, and its size in pixels.
fn fields(path: &Path) -> Result<(Provenance, [u32; 2]), StaleReason> {
    if !path.is_file() {
        return Err(if super::is_there(path) { StaleReason::Damaged } else { StaleReason::Missing });
    }
    match PictureKind::of(path) {
        Some(PictureKind::Png) => png_fields(path),
        _ => exr_fields(path),
    }
}

/// Returns the metadata of a complete PNG file, and its size in pixels.
fn png_fields(path: &Path) -> Result<(Provenance, [u32; 2]), StaleReason> {
    let note = png_note::read(path).map_err(|_| StaleReason::Damaged)?;
    Ok((note.fields.ok_or(StaleReason::Foreign)?, note.size))
}

/// Returns the metadata of a complete EXR file, and the size of its display window in pixels.
fn exr_fields(path: &Path) -> Result<(Provenance, [u32; 2]), StaleReason> {
    if !complete::is_complete(path) {
        return Err(StaleReason::Damaged);
    }
    let head = exr_guard::read_head(path).map_err(|_| StaleReason::Damaged)?;
    let first = head.headers.first().ok_or(StaleReason::Damaged)?;
    let window = first.shared_attributes.display_window.size;
    let size = [window.width(), window.height()].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    Ok((provenance::from_layer(&first.own_attributes).ok_or(StaleReason::Foreign)?, size))
}

/// Verifies the pixels. The chunk checksums of a PNG file have already been verified with its metadata.
fn has_right_pixels(path: &Path) -> bool {
    PictureKind::of(path) == Some(PictureKind::Png) || is_checksum_right(path).unwrap_or(false)
}

impl Expected<'_> {
    fn check(&self, found: &Provenance, [width, height]: [u32; 2]) -> Result<(), StaleReason> {
        let is_of_size = self.size.is_none_or(|size| [size.width, size.height] == [width, height]);
        if found.version != provenance::VERSION {
            Err(StaleReason::OtherVersion(found.version.clone()))
        } else if found.frame != self.frame {
            Err(StaleReason::OtherFrame(found.frame))
        } else if !is_of_size {
            Err(StaleReason::OtherSize([width, height]))
        } else if found.shot_hash != self.shot_hash {
            let settings = |hash: &str| hash.split_once('.').map(|(settings, _)| settings.to_owned());
            let is_same_shot = settings(&found.shot_hash).is_some_and(|own| settings(self.shot_hash) == Some(own));
            Err(if is_same_shot { StaleReason::OtherContents } else { StaleReason::OtherShot })
        } else if is_processor(&found.device) != is_processor(self.device) {
            Err(StaleReason::OtherDevice(found.device.clone()))
        } else {
            Ok(())
        }
    }
}

/// Whether a device is the CPU.
fn is_processor(device: &str) -> bool {
    device.trim_start_matches("the ").starts_with("CPU")
}

/// Whether the checksum in the header matches everything after it.
fn is_checksum_right(path: &Path) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    let stamps = exr_head::find_checksums(&mut file)?;
    let Some(&place) = stamps.places.first() else { return Ok(false) };
    let mut found = [0; exr_head::CHECKSUM_DIGITS];
    file.seek(SeekFrom::Start(place))?;
    file.read_exact(&mut found)?;
    Ok(found == *exr_head::checksum(&mut file, stamps.head_end)?.as_bytes())
}
