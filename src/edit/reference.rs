//! Reference pictures above or below the frame, for matching by eye, such as a director's draw-over. They belong to the
//! window, not to the shot.
//!
//! In: pictures or sequences. Out: their decoded pictures of a frame.

use super::EditError;
use super::picture::{Picture, Quality};
use crate::image::{SequencePath, read_any};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A reference picture.
#[derive(Clone, Debug)]
pub(crate) struct Reference {
    path: PathBuf,
    /// Opacity, 0 to 1.
    pub(crate) opacity: f32,
    /// Whether it is drawn above the frame; else below.
    pub(crate) is_above: bool,
    /// Offset to the right and up, in frame heights.
    pub(crate) offset: [f32; 2],
    /// Its height in frame heights.
    pub(crate) scale: f32,
    /// The file that was read last, and its picture, if it could be read.
    loaded: Option<(PathBuf, Option<Arc<Picture>>)>,
}

impl Reference {
    /// Opens a picture, or a path with a frame counter.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be read.
    pub(crate) fn open(path: &Path, frame: i32) -> Result<Self, EditError> {
        let mut reference =
            Self { path: path.to_owned(), opacity: 0.5, is_above: true, offset: [0.0; 2], scale: 1.0, loaded: None };
        let file = reference.file_of(frame)?;
        reference.load(&file)?;
        Ok(reference)
    }

    /// Returns whether it shows this picture or sequence.
    pub(crate) fn is_of(&self, path: &Path) -> bool {
        self.path == path
    }

    /// Forgets what was decoded, because the file may have changed.
    pub(crate) fn read_again(&mut self) {
        self.loaded = None;
    }

    /// Returns the name of its file.
    #[must_use]
    pub(crate) fn name(&self) -> String {
        self.path
            .file_name()
            .map_or_else(|| self.path.display().to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Returns the picture of a frame; `None` if the sequence lacks it.
    pub(crate) fn at(&mut self, frame: i32) -> Option<Arc<Picture>> {
        let file = self.file_of(frame).ok()?;
        if self.loaded.as_ref().is_none_or(|(known, _)| *known != file) {
            // What cannot be read is not tried again until another frame is seen.
            self.loaded = Some((file.clone(), None));
            self.load(&file).ok()?;
        }
        self.loaded.as_ref()?.1.clone()
    }

    fn file_of(&self, frame: i32) -> Result<PathBuf, EditError> {
        if self.path.is_file() {
            return Ok(self.path.clone());
        }
        Ok(SequencePath::parse(&self.path)?.path_of(frame))
    }

    fn load(&mut self, file: &Path) -> Result<(), EditError> {
        let frame = read_any(file)?.into_frame();
        self.loaded = Some((file.to_owned(), Some(Arc::new(Picture::of(&frame, (0, 0), Quality::Final)))));
        Ok(())
    }
}
