//! The document's file: saving, and changes of other programs.
//!
//! In: the file on disk. Out: the file written, unless another program wrote it meanwhile; what changed.

use super::relocation::relocated;
use super::{Document, absolute};
use crate::edit::EditError;
use crate::edit::command::{Command, merged};
use crate::edit::journal_line::Line;
use crate::edit::stored_path::StoredPath;
use crate::files::{SHOT_BYTES, read_text};
use crate::image::replace_text;
use std::io::ErrorKind;
use std::path::Path;

/// The result of checking the file on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum DiskChange {
    /// Unchanged.
    None,
    /// Another program wrote it, and it was reloaded, as there are no unsaved changes.
    Reloaded,
    /// Another program wrote it while there are unsaved changes elsewhere in the file: both were kept.
    Merged,
    /// Another program wrote it while there are unsaved changes in the same place; holds the text on disk.
    Conflict(String),
}

impl Document {
    /// Returns the file's contents as last read or written; `None` if there is no file.
    pub(crate) fn on_disk(&self) -> Option<&str> {
        self.known.get(&self.path).map(String::as_str)
    }

    fn set_on_disk(&mut self, text: Option<String>) {
        self.had_file = true;
        match text.clone() {
            Some(text) => self.known.insert(self.path.clone(), text),
            None => self.known.remove(&self.path),
        };
        self.note(&Line::Disk(text));
    }

    /// Saves the file. What another program wrote meanwhile is merged first; with [`DiskChange::Conflict`] nothing is saved.
    ///
    /// # Errors
    /// [`EditError`] if the file cannot be written, or what is there cannot be read.
    pub(crate) fn save(&mut self) -> Result<DiskChange, EditError> {
        let found = self.read_disk().map_err(|source| EditError::Io { path: self.path.clone(), source })?;
        // What is no shot is not overwritten without a question, either.
        let change =
            self.follow_disk(found.clone()).unwrap_or_else(|_| found.map_or(DiskChange::None, DiskChange::Conflict));
        if !matches!(change, DiskChange::Conflict(_)) {
            replace_text(&self.path, &self.text)?;
            self.set_on_disk(Some(self.text.clone()));
        }
        Ok(change)
    }

    /// Saves to another path, which becomes the document's, and overwrites what is there. Relative paths of the files that
    /// the shot reads are adjusted; undoing this brings back the former path, too.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be written.
    pub(crate) fn save_as(&mut self, path: &Path) -> Result<(), EditError> {
        let path = absolute(path);
        let text = relocated(&self.text, [&self.path, &path])?;
        let shot = self.parsed(&text, &path)?;
        replace_text(&path, &text)?;
        match Command::between("Save as", &self.text, &text) {
            Some(command) => {
                let command = command.with_paths([&self.path, &path]);
                let recorded = self.history.record(command, None, &self.text);
                self.note(&recorded.into());
            }
            None => {
                self.end_series();
                self.note(&Line::Path(StoredPath(path.clone())));
            }
        }
        (self.path, self.shot, self.text) = (path, shot, text);
        self.set_on_disk(Some(self.text.clone()));
        Ok(())
    }

    /// Checks whether another program wrote the file: reloads it if there are no unsaved changes, and merges them if they are in
    /// other places. If the file was removed, all that is here counts as unsaved.
    ///
    /// # Errors
    /// [`EditError`] if the file on disk is not a valid shot.
    pub(crate) fn check_disk(&mut self) -> Result<DiskChange, EditError> {
        self.read_disk().map_or(Ok(DiskChange::None), |found| self.follow_disk(found))
    }

    /// Reads the file; `None` if there is none.
    fn read_disk(&self) -> std::io::Result<Option<String>> {
        match read_text(&self.path, SHOT_BYTES) {
            Ok(text) => Ok(Some(text)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Takes over, or merges, what was found on disk.
    fn follow_disk(&mut self, found: Option<String>) -> Result<DiskChange, EditError> {
        let Some(text) = found else {
            if self.on_disk().is_some() {
                self.set_on_disk(None);
            }
            return Ok(DiskChange::None);
        };
        if self.on_disk() == Some(&text) {
            return Ok(DiskChange::None);
        }
        if text == self.text {
            self.set_on_disk(Some(text));
            return Ok(DiskChange::None);
        }
        if !self.is_dirty() {
            self.take_from_disk(text)?;
            return Ok(DiskChange::Reloaded);
        }
        let merged = self.on_disk().and_then(|known| merged(known, &self.text, &text));
        let is_merged = merged.is_some_and(|merged| self.change("Merge with the file", merged, None).is_ok());
        if !is_merged {
            return Ok(DiskChange::Conflict(text));
        }
        self.set_on_disk(Some(text));
        Ok(DiskChange::Merged)
    }

    /// Takes over the text that another program wrote, as one undoable change.
    ///
    /// # Errors
    /// [`EditError`] if it is not a valid shot.
    pub(crate) fn take_from_disk(&mut self, text: String) -> Result<(), EditError> {
        self.change("Reload from disk", text.clone(), None)?;
        self.set_on_disk(Some(text));
        Ok(())
    }

    /// Keeps the document's text; the next save overwrites what another program wrote.
    pub(crate) fn keep_own(&mut self, on_disk: String) {
        self.set_on_disk(Some(on_disk));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;
    use tempfile::TempDir;

    const SHOT: &str = "scene = \"x.glb\"\nsize = [96, 54]\nframes = { first = 1, last = 6 }\nsamples = 4\n";

    fn with_samples(text: &str, samples: u32) -> String {
        text.replace("samples = 4", &format!("samples = {samples}"))
    }

    fn opened() -> (TempDir, PathBuf, Document) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("shot.toml");
        fs::write(&path, SHOT).expect("written");
        let document = Document::open(&path).expect("a shot");
        (folder, path, document)
    }

    #[test]
    fn saving_keeps_what_another_program_wrote_meanwhile() {
        let (_folder, path, mut document) = opened();
        document.change("edit", with_samples(SHOT, 5), None).expect("a shot");
        fs::write(&path, SHOT.replace("96, 54", "48, 27")).expect("written");
        assert_eq!(document.save().expect("writable"), DiskChange::Merged);
        let both = with_samples(SHOT, 5).replace("96, 54", "48, 27");
        assert_eq!((document.text(), fs::read_to_string(&path).expect("there")), (both.as_str(), both.clone()));
        assert!(!document.is_dirty());
        // In the same place, the user has to decide.
        document.change("edit", both.replace("samples = 5", "samples = 6"), None).expect("a shot");
        let other = both.replace("samples = 5", "samples = 7");
        fs::write(&path, &other).expect("written");
        assert_eq!(document.save().expect("readable"), DiskChange::Conflict(other.clone()));
        assert_eq!(fs::read_to_string(&path).expect("there"), other);
        document.keep_own(other);
        assert_eq!(document.save().expect("writable"), DiskChange::None);
        assert_eq!(fs::read_to_string(&path).expect("there"), document.text());
        // What is no shot is asked about, too, even without changes here.
        fs::write(&path, "version = [").expect("written");
        assert_eq!(document.save().expect("readable"), DiskChange::Conflict("version = [".into()));
    }

    #[test]
    fn a_file_that_appears_under_a_new_shot_is_asked_about() {
        let (_folder, path, _) = opened();
        let mut document = Document::new(&path, with_samples(SHOT, 5)).expect("a shot");
        assert_eq!(document.save().expect("readable"), DiskChange::Conflict(SHOT.into()));
    }

    #[test]
    fn a_removed_file_is_unsaved_work() {
        let (_folder, path, mut document) = opened();
        fs::remove_file(&path).expect("there");
        assert_eq!(document.check_disk().expect("it is gone"), DiskChange::None);
        assert!(document.is_dirty());
        assert_eq!(document.save().expect("writable"), DiskChange::None);
        assert_eq!(fs::read_to_string(&path).expect("saved"), SHOT);
        assert!(!document.is_dirty());
    }

    #[test]
    fn undo_of_saving_elsewhere_brings_back_the_path() {
        let (folder, path, mut document) = opened();
        document.change("edit", with_samples(SHOT, 5), None).expect("a shot");
        fs::create_dir(folder.path().join("below")).expect("made");
        let below = folder.path().join("below/shot.toml");
        let scene = document.shot().scene().map(Path::to_owned);
        document.save_as(&below).expect("writable");
        assert_eq!(document.path(), below);
        let same = |document: &Document| {
            document.shot().scene().and_then(Path::parent).and_then(|folder| folder.canonicalize().ok())
        };
        let scene_folder = scene.as_deref().and_then(Path::parent).and_then(|folder| folder.canonicalize().ok());
        assert_eq!(same(&document), scene_folder);
        assert!(document.undo().is_some_and(|label| label.starts_with("Save as")));
        assert_eq!((document.path(), document.shot().scene()), (path.as_path(), scene.as_deref()));
        assert!(document.is_dirty(), "the first change is not in this file");
        document.undo();
        assert_eq!((document.text(), document.is_dirty()), (SHOT, false));
        document.redo();
        document.redo();
        assert_eq!((document.path(), document.is_dirty()), (below.as_path(), false));
        assert_eq!(same(&document), scene_folder);
        assert_eq!(fs::read_to_string(&path).expect("there"), SHOT, "nothing was written to it");
    }
}
