//! The size of a document's plates, which is read once, until their files are read again: a shot is parsed at every edit.

use crate::image::plate_size;
use crate::shot::{Shot, ShotError};
use crate::space::FrameSize;
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// The size of a plate over a range of frames, once it is known.
#[derive(Debug, Default)]
pub(super) struct KnownSize(RefCell<Option<(PathBuf, [i32; 2], FrameSize)>>);

impl KnownSize {
    /// Parses the text of a shot file at a path.
    ///
    /// # Errors
    /// As [`Shot::parse`].
    pub(super) fn parsed(&self, text: &str, path: &Path) -> Result<Shot, ShotError> {
        Shot::parse_with(text, path, &|plate, frames| self.of(plate, frames))
    }

    /// Returns the size of a plate over a range of frames; `None` if none can be read, which is not remembered.
    fn of(&self, plate: &Path, frames: [i32; 2]) -> Option<FrameSize> {
        let mut known = self.0.borrow_mut();
        if let Some((path, range, size)) = &*known
            && path == plate
            && *range == frames
        {
            return Some(*size);
        }
        let size = plate_size(plate, frames)?;
        *known = Some((plate.to_owned(), frames, size));
        Some(size)
    }

    /// Forgets the size: the files may have changed.
    pub(super) fn forget(&self) {
        self.0.replace(None);
    }
}

#[cfg(test)]
mod tests {
    use crate::edit::Document;
    use crate::image::{Preview, write_png};

    #[test]
    fn the_size_of_plates_is_read_once_until_the_files_are_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |frame: i32| folder.path().join(format!("p.{frame:02}.png"));
        let write = |frame: i32, width: u32| write_png(&at(frame), &Preview::transparent(width, 9)).expect("written");
        let text = "plate = 'p.##.png'\nframes = { first = 1, last = 9 }\nsamples = 4\n";
        let mut document = Document::new(&folder.path().join("shot.toml"), text.to_owned()).expect("a shot");
        let mut samples = 4;
        let mut edited = |document: &mut Document| {
            samples += 1;
            let text = text.replace("samples = 4", &format!("samples = {samples}"));
            document.change("edit", text, None).expect("a shot");
            document.shot().size.width
        };
        assert_eq!(edited(&mut document), 1920, "there is no plate");
        // The first frame is missing, the second one is being written.
        std::fs::write(at(2), "incomplete").expect("written");
        write(3, 30);
        assert_eq!(edited(&mut document), 30, "plates appear");
        write(2, 20);
        assert_eq!(edited(&mut document), 30, "an edit reads no plate");
        document.read_files_again();
        assert_eq!((document.shot().size.width, edited(&mut document)), (20, 20));
        let other = text.replace("last = 9", "last = 2").replace("first = 1", "first = 2");
        write(2, 22);
        document.change("edit", other, None).expect("a shot");
        assert_eq!(document.shot().size.width, 22, "the size of other frames is another one");
    }
}
