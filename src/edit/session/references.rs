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
        if !self.references.iter().any(|known| !known.is_rendered && known.is_of(path)) {
            self.references.push(opened);
        }
        Ok(())
    }

    /// Shows the frames of the last render in place of the frame, until the next edit or [`Self::leave_rendered`].
    pub(crate) fn look_at_render(&mut self) {
        let [first, last] = self.playhead.shot_range();
        let pattern = self.run().map_or(&self.document.shot().output.path, |run| &run.output).clone();
        // This frame need not be among those that were rendered.
        let open = |frame: i32| Reference::open(&pattern, frame);
        let other = || (first..=last).find_map(|frame| open(frame).ok());
        match open(self.playhead.frame()).or_else(|error| other().ok_or(error)) {
            Ok(mut reference) => {
                self.leave_rendered();
                (reference.opacity, reference.is_rendered) = (1.0, true);
                self.references.push(reference);
            }
            Err(error) => self.say(error.to_string()),
        }
    }

    /// Returns whether rendered frames are shown in place of the frame.
    #[must_use]
    pub(crate) fn shows_rendered(&self) -> bool {
        self.references.iter().any(|reference| reference.is_rendered)
    }

    /// Shows the frame again in place of rendered ones. Returns whether those were shown.
    pub(crate) fn leave_rendered(&mut self) -> bool {
        let was_shown = self.shows_rendered();
        self.references.retain(|reference| !reference.is_rendered);
        was_shown
    }

    /// Returns the number of reference pictures.
    #[cfg(test)]
    #[must_use]
    pub(crate) const fn reference_count(&self) -> usize {
        self.references.len()
    }
}
