//! Reads the size of a picture without decoding it.
//!
//! In: the path of a PNG, JPEG or EXR file, or of a sequence. Out: its display window as a [`FrameSize`].

use super::{ImageError, PictureKind, SequencePath};
use crate::space::FrameSize;
use ::image::metadata::Orientation;
use ::image::{ImageDecoder, ImageReader};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime};

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
    sized_frame(sequence, (first, others)).map(|(_, size)| size)
}

/// Returns the frame whose size is that of a sequence, with its size.
fn sized_frame(
    sequence: &SequencePath,
    (first, others): (i32, impl Iterator<Item = i32>),
) -> Result<(i32, FrameSize), ImageError> {
    let size = |frame: i32| Ok((frame, picture_size(&sequence.path_of(frame))?));
    size(first).or_else(|fault| {
        let there: BTreeSet<i32> = sequence.frames_on_disk().ok().flatten().into_iter().flatten().collect();
        others.filter(|frame| there.contains(frame)).find_map(|frame| size(frame).ok()).ok_or(fault)
    })
}

/// Age of files below which nothing is remembered of them: they may change again without another time.
const SETTLED: Duration = Duration::from_secs(3);

/// Most sequences that are remembered.
const MAX_KNOWN: usize = 64;

/// The time and length of a file; of a folder, the time of the last file that was added or removed.
type Stamp = Option<(SystemTime, u64)>;

/// The size of a sequence, with what it was read from.
#[derive(Clone, Debug, PartialEq)]
struct KnownSize {
    /// The folder, the first frame, and the file with this size.
    files: [(PathBuf, Stamp); 3],
    size: FrameSize,
}

/// Sizes by pattern, first and last frame.
static KNOWN: Mutex<BTreeMap<(PathBuf, [i32; 2]), KnownSize>> = Mutex::new(BTreeMap::new());

/// Returns the size of a plate as [`sequence_size`] does; `None` if none of these frames can be read. While folder and files stay as they
/// are it is not read again, so that shots can be parsed at every edit.
#[must_use]
pub(crate) fn plate_size(plate: &Path, [first, last]: [i32; 2]) -> Option<FrameSize> {
    let key = (plate.to_owned(), [first, last]);
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
    if let Some(known) = known.filter(|known| known.files.iter().all(|(path, old)| stamp(path) == *old)) {
        return Some(known.size);
    }
    let sequence = SequencePath::of_input(plate).ok()?;
    let (frame, size) = sized_frame(&sequence, (first, first..=last)).ok()?;
    let (path, shown) = (sequence.path_of(first), sequence.path_of(frame));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned();
    let files = [folder, path, shown].map(|path| (stamp(&path), path)).map(|(stamp, path)| (path, stamp));
    let is_settled = |stamp: &Stamp| stamp.is_none_or(|(time, _)| time.elapsed().is_ok_and(|age| age > SETTLED));
    let mut all = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if all.len() >= MAX_KNOWN {
        all.clear();
    }
    all.remove(&key);
    if files.iter().all(|(_, stamp)| is_settled(stamp)) {
        all.insert(key, KnownSize { files, size });
    }
    Some(size)
}

fn stamp(path: &Path) -> Stamp {
    let data = std::fs::metadata(path).ok()?;
    Some((data.modified().ok()?, data.len()))
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

    #[cfg(unix)]
    #[test]
    fn the_size_of_a_plate_is_read_again_only_where_files_changed() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let (plate, picture) = (at("p.##.png"), |width: u32| Preview::transparent(width, 9));
        let date = |path: &Path, hours: u64| {
            let time = SystemTime::now() - Duration::from_secs(3600 * hours);
            std::fs::File::open(path).and_then(|file| file.set_modified(time)).expect("dated");
        };
        let width = || plate_size(&plate, [1, 9]).map(|size| size.width);
        assert_eq!(width(), None);
        write_png(&at("p.02.png"), &picture(20)).expect("written");
        assert_eq!(width(), Some(20));
        date(&at("p.02.png"), 2);
        date(folder.path(), 2);
        assert_eq!(width(), Some(20));
        // Damaged with the same length and time: nobody looks into it.
        let data = std::fs::metadata(at("p.02.png")).expect("there");
        std::fs::write(at("p.02.png"), vec![0; data.len() as usize]).expect("written");
        let file = std::fs::File::options().write(true).open(at("p.02.png")).expect("there");
        file.set_modified(data.modified().expect("known")).expect("dated");
        assert_eq!(width(), Some(20), "what is settled is remembered");
        write_png(&at("p.02.png"), &picture(22)).expect("written");
        assert_eq!(width(), Some(22));
        // A frame that appears comes first.
        date(&at("p.02.png"), 2);
        date(folder.path(), 2);
        assert_eq!(width(), Some(22));
        write_png(&at("p.01.png"), &picture(10)).expect("written");
        assert_eq!(width(), Some(10));
        std::fs::remove_file(at("p.01.png")).expect("there");
        std::fs::remove_file(at("p.02.png")).expect("there");
        assert_eq!(width(), None);
    }
}
