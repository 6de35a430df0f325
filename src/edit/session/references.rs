//! The reference pictures over and under the frame.
//!
//! In: paths. Out: a list in drawing order, the first one at the bottom.

use super::Session;
use crate::edit::EditError;
use crate::edit::reference::Reference;
use std::path::Path;

impl Session {
    /// Lays a picture, or a path with a frame counter, over the frame and over the other references. One that is there
    /// already keeps its place.
    ///
    /// # Errors
    /// [`EditError`] if there is no such file.
    pub(crate) fn add_reference(&mut self, path: &Path) -> Result<(), EditError> {
        let opened = Reference::open(path, self.playhead.frame())?;
        self.put_reference(path, opened);
        Ok(())
    }

    pub(super) fn put_reference(&mut self, path: &Path, opened: Reference) {
        if !self.references.iter().any(|known| known.is_of(path)) {
            self.references.push(opened);
        }
    }

    /// Returns the number of reference pictures.
    #[cfg(test)]
    #[must_use]
    pub(crate) const fn reference_count(&self) -> usize {
        self.references.len()
    }
}
