//! Reads the size of a picture without decoding it.
//!
//! In: the path of a PNG, JPEG or EXR file, or of a sequence. Out: its display window as a [`FrameSize`].

use super::{ImageError, PictureKind, SequencePath};
use crate::space::FrameSize;
use ::image::metadata::Orientation;
use ::image::{ImageDecoder, ImageReader};
use std::collections::BTreeSet;
use std::path::Path;

/// Returns the size of a picture's display window. Reads only the header.
///
/// # Errors
/// [`ImageError`] if the extension is not that of an EXR, PNG or JPEG file, the file cannot be opened, or its header is damaged.
pub fn picture_size(path: &Path) -> Result<FrameSize, ImageError> {
    if PictureKind::known(path)? == PictureKind::Exr {
        let head = super::exr_guard::read_head(path)?;
        let first = head.headers.first().ok_or_else(|| ImageError::damaged(path, "it has no parts"))?;
        let shared = &first.shared_attributes;
        let [width, height] = [shared.display_window.size.width(), shared.display_window.size.height()]
            .map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        return Ok(FrameSize { width, height, pixel_aspect: f64::from(shared.pixel_aspect) });
    }
    crate::files::check_regular(path).map_err(|source| ImageError::reading(path, source))?;
    let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
    let reader = reader.map_err(|source| ImageError::reading(path, source))?;
    let mut decoder = reader.into_decoder().map_err(|failed| ImageError::damaged(path, failed.to_string()))?;
    let (width, height) = decoder.dimensions();
    let is_lying = matches!(
        decoder.orientation().unwrap_or(Orientation::NoTransforms),
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH
    );
    Ok(if is_lying { FrameSize::new(height, width) } else { FrameSize::new(width, height) })
}

/// Returns the size of a sequence: that of `first`, else of the first of `others` that can be read.
///
/// # Errors
/// As [`picture_size`] of `first`, if none can be read.
pub(crate) fn sequence_size(
    sequence: &SequencePath,
    (first, others): (i32, impl Iterator<Item = i32>),
) -> Result<FrameSize, ImageError> {
    let size = |frame: i32| picture_size(&sequence.path_of(frame));
    size(first).or_else(|fault| {
        let there: BTreeSet<i32> = sequence.frames_on_disk().ok().flatten().into_iter().flatten().collect();
        others.filter(|frame| there.contains(frame)).find_map(|frame| size(frame).ok()).ok_or(fault)
    })
}

/// Returns the size of a plate as [`sequence_size`] does; `None` if none of these frames can be read.
#[must_use]
pub(crate) fn plate_size(plate: &Path, [first, last]: [i32; 2]) -> Option<FrameSize> {
    let sequence = SequencePath::of_input(plate).ok()?;
    sequence_size(&sequence, (first, first..=last)).ok()
}

/// The amount of data in a decoded picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PictureExtent {
    /// Pixels of the data windows of all parts, or of the display window if that is larger.
    pub(crate) pixels: u128,
    /// Samples of all channels.
    pub(crate) samples: u128,
}

/// Returns the amount of data in a decoded picture, to estimate memory. Reads only the header.
///
/// # Errors
/// As [`picture_size`].
pub(crate) fn picture_extent(path: &Path) -> Result<PictureExtent, ImageError> {
    let size = picture_size(path)?;
    let shown = u128::from(size.width) * u128::from(size.height);
    if PictureKind::known(path)? != PictureKind::Exr {
        return Ok(PictureExtent { pixels: shown, samples: 4 * shown });
    }
    let head = super::exr_guard::read_head(path)?;
    let parts = head.headers.iter().map(|part| {
        let pixels = part.layer_size.width() as u128 * part.layer_size.height() as u128;
        (pixels, pixels * part.channels.list.len() as u128)
    });
    let (pixels, samples) = parts.fold((0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok(PictureExtent { pixels: pixels.max(shown), samples })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Preview, write_png};

    #[test]
    fn a_sequence_has_the_size_of_its_first_frame_that_can_be_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let size = |frames: [i32; 2]| {
            let sequence = SequencePath::parse(&at("p.##.png")).expect("a sequence");
            sequence_size(&sequence, (frames[0], frames[0]..=frames[1]))
        };
        std::fs::write(at("p.02.png"), "broken").expect("written");
        for (frame, width) in [(3, 30), (4, 40)] {
            write_png(&at(&format!("p.{frame:02}.png")), &Preview::transparent(width, 9)).expect("written");
        }
        assert_eq!(size([1, 9]).expect("frame 3"), FrameSize::new(30, 9));
        assert_eq!(size([4, 9]).expect("frame 4"), FrameSize::new(40, 9));
        let told = size([1, 2]).expect_err("none can be read").to_string();
        assert!(told.contains("p.01.png"), "the first one is told: {told}");
    }
}
