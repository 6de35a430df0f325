//! Which frames of an earlier run are kept.
//!
//! In: a path, and what the frame would say about itself if it were written now. Out: it is kept, or the reason why not.

#[cfg(feature = "cli")]
use super::FrameMetadata;
use super::provenance::{self, Provenance};
use super::{PictureKind, complete, exr_guard, exr_head, png_note};
use crate::space::FrameSize;
use std::fmt;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// What a frame that is kept has to say.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected<'a> {
    /// Its number.
    pub(crate) frame: i32,
    /// Digest of all that it is made of: settings, a dot, and what files hold.
    pub(crate) shot_hash: &'a str,
    /// The display window; `None`: any.
    pub(crate) size: Option<FrameSize>,
    /// What draws, as in [`super::FrameMetadata::device`]. Processor or graphics device counts, not the name.
    pub(crate) device: &'a str,
}

/// How much of a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Depth {
    /// Head, offset table and the starts of chunks: about a millisecond.
    Head,
    /// Everything, for the checksum of the pixels.
    Pixels,
}

/// Why a frame is written again.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Redo {
    /// Nothing is there.
    Missing,
    /// The file is cut off or damaged.
    Damaged,
    /// The file says nothing that pinwarp would have written.
    Foreign,
    /// Another version wrote it.
    OtherVersion(String),
    /// It is another frame.
    OtherFrame(i32),
    /// Its display window has another size, pixels.
    OtherSize([u32; 2]),
    /// It was made from other settings or pins.
    OtherShot,
    /// A file that it was made from held something else.
    OtherContents,
    /// A device of another class drew it.
    OtherDevice(String),
    /// The pixels are not those that were written.
    Checksum,
    /// The picture beside it is missing, damaged or of another state.
    Preview,
}

impl fmt::Display for Redo {
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

/// What a frame says about itself, once its file is known to be whole.
///
/// # Errors
/// [`Redo::Missing`], [`Redo::Damaged`], [`Redo::Foreign`] or, where the pixels are read, [`Redo::Checksum`].
#[cfg(feature = "cli")]
pub(crate) fn read_whole(path: &Path, depth: Depth) -> Result<FrameMetadata, Redo> {
    let (found, _) = fields(path)?;
    if depth == Depth::Pixels && !has_right_pixels(path) {
        return Err(Redo::Checksum);
    }
    Ok(FrameMetadata::from_provenance(found))
}

/// Whether a frame that is there is the one that would be written now.
///
/// # Errors
/// The reason why it is not.
pub(crate) fn check_kept(path: &Path, expected: &Expected, depth: Depth) -> Result<(), Redo> {
    let (found, size) = fields(path)?;
    expected.check(&found, size)?;
    if depth == Depth::Pixels && !has_right_pixels(path) {
        return Err(Redo::Checksum);
    }
    Ok(())
}

/// What a whole file says, and its size in pixels.
fn fields(path: &Path) -> Result<(Provenance, [u32; 2]), Redo> {
    if !path.is_file() {
        return Err(if super::is_there(path) { Redo::Damaged } else { Redo::Missing });
    }
    match PictureKind::of(path) {
        Some(PictureKind::Png) => png_fields(path),
        _ => exr_fields(path),
    }
}

/// What a whole PNG file says, and its size in pixels.
fn png_fields(path: &Path) -> Result<(Provenance, [u32; 2]), Redo> {
    let note = png_note::read(path).map_err(|_| Redo::Damaged)?;
    Ok((note.fields.ok_or(Redo::Foreign)?, note.size))
}

/// What a whole EXR file says, and the size of its display window in pixels.
fn exr_fields(path: &Path) -> Result<(Provenance, [u32; 2]), Redo> {
    if !complete::is_complete(path) {
        return Err(Redo::Damaged);
    }
    let head = exr_guard::read_head(path).map_err(|_| Redo::Damaged)?;
    let first = head.headers.first().ok_or(Redo::Damaged)?;
    let window = first.shared_attributes.display_window.size;
    let size = [window.width(), window.height()].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    Ok((provenance::from_layer(&first.own_attributes).ok_or(Redo::Foreign)?, size))
}

/// Whether the pixels are those that were written. The checksums of a PNG file's chunks are read with its note.
fn has_right_pixels(path: &Path) -> bool {
    PictureKind::of(path) == Some(PictureKind::Png) || is_checksum_right(path).unwrap_or(false)
}

impl Expected<'_> {
    fn check(&self, found: &Provenance, [width, height]: [u32; 2]) -> Result<(), Redo> {
        let is_of_size = self.size.is_none_or(|size| [size.width, size.height] == [width, height]);
        if found.version != provenance::VERSION {
            Err(Redo::OtherVersion(found.version.clone()))
        } else if found.frame != self.frame {
            Err(Redo::OtherFrame(found.frame))
        } else if !is_of_size {
            Err(Redo::OtherSize([width, height]))
        } else if found.shot_hash != self.shot_hash {
            let settings = |hash: &str| hash.split_once('.').map(|(settings, _)| settings.to_owned());
            let is_same_shot = settings(&found.shot_hash).is_some_and(|own| settings(self.shot_hash) == Some(own));
            Err(if is_same_shot { Redo::OtherContents } else { Redo::OtherShot })
        } else if is_processor(&found.device) != is_processor(self.device) {
            Err(Redo::OtherDevice(found.device.clone()))
        } else {
            Ok(())
        }
    }
}

/// Whether a device is the processor: `CPU`.
fn is_processor(device: &str) -> bool {
    device.trim_start_matches("the ").starts_with("CPU")
}

/// Whether everything behind the head has the checksum that the head names.
fn is_checksum_right(path: &Path) -> std::io::Result<bool> {
    let mut file = File::open(path)?;
    let stamps = exr_head::find_checksums(&mut file)?;
    let Some(&place) = stamps.places.first() else { return Ok(false) };
    let mut found = [0; exr_head::CHECKSUM_DIGITS];
    file.seek(SeekFrom::Start(place))?;
    file.read_exact(&mut found)?;
    Ok(found == *exr_head::checksum(&mut file, stamps.head_end)?.as_bytes())
}
