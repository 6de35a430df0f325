//! A shot file being edited: its text, the parsed shot, and the edit history.
//!
//! In: new texts, one per edit. Out: the validated [`Shot`]; the file, with comments and order preserved. A text that
//! is not a valid shot is rejected, so that what is saved can always be rendered.

use super::EditError;
use super::command::{Command, merged};
use super::history::History;
use super::journal::{Journal, Unfinished};
use crate::files::{SHOT_BYTES, read_text};
use crate::image::replace_text;
use crate::pipeline::path_between;
use crate::scene::Scene;
use crate::shot::edit::{Setting, put_setting};
use crate::shot::{Shot, ShotError, Source};
use std::path::{Path, PathBuf};

/// An open shot file.
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    text: String,
    /// The file's contents as last read or written; `None` if the file does not exist yet.
    on_disk: Option<String>,
    shot: Shot,
    history: History,
    journal: Option<Journal>,
    /// The scene of a new shot, which was loaded to write the shot.
    scene: Option<Scene>,
}

/// The result of checking the file on disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DiskChange {
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
    /// Reads a shot file.
    ///
    /// # Errors
    /// [`EditError`] if the file cannot be read or is not a valid shot.
    pub fn open(path: &Path) -> Result<Self, EditError> {
        let text = read_text(path, SHOT_BYTES).map_err(|source| EditError::Io { path: path.to_owned(), source })?;
        let mut document = Self::new(path, text.clone())?;
        document.on_disk = Some(text);
        Ok(document)
    }

    /// Creates a shot that has no file yet.
    ///
    /// # Errors
    /// [`EditError`] if the text is not a valid shot.
    pub fn new(path: &Path, text: String) -> Result<Self, EditError> {
        let shot = Shot::parse(&text, path)?;
        let (path, history) = (path.to_owned(), History::default());
        Ok(Self { path, text, on_disk: None, shot, history, journal: None, scene: None })
    }

    /// Keeps a scene that is loaded already, so that it need not be loaded again.
    pub(crate) fn with_scene(self, scene: Option<Scene>) -> Self {
        Self { scene, ..self }
    }

    /// Takes the loaded scene.
    pub(crate) const fn take_scene(&mut self) -> Option<Scene> {
        self.scene.take()
    }

    /// Restores a document from the journal of a killed editor.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn recovered(left: Unfinished) -> Result<Self, EditError> {
        let mut document = Self::new(&left.path, left.text)?;
        document.on_disk = read_text(&left.path, SHOT_BYTES).ok();
        document.history = left.history;
        Ok(document)
    }

    /// Starts a journal in a folder. Failures are ignored: editing goes on without one.
    pub(crate) fn keep_journal(&mut self, folder: &Path) {
        self.journal = match Journal::begin(folder, &self.path, &self.text) {
            Ok(journal) => Some(journal),
            Err(error) => {
                tracing::warn!("{}: no journal can be kept: {error}", folder.display());
                None
            }
        };
    }

    /// Returns the path of the shot file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the text.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the parsed shot.
    #[must_use]
    pub const fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the edit history.
    #[must_use]
    pub const fn history(&self) -> &History {
        &self.history
    }

    /// Returns whether there are unsaved changes.
    #[must_use]
    pub fn is_dirty(&self) -> bool {
        self.on_disk.as_deref() != Some(&self.text)
    }

    /// Replaces the text. Consecutive changes with the same `series` are undone together.
    ///
    /// # Errors
    /// [`ShotError`] if the text is not a valid shot; the document is then unchanged.
    pub(crate) fn change(&mut self, label: &str, text: String, series: Option<&str>) -> Result<(), ShotError> {
        let Some(command) = Command::between(label, &self.text, &text) else { return Ok(()) };
        self.shot = Shot::parse(&text, &self.path)?;
        let recorded = self.history.record(command, series, &self.text);
        self.text = text;
        self.note(|journal| journal.note(&recorded));
        Ok(())
    }

    /// Ends the series: the next change is undone separately.
    pub(crate) fn end_series(&mut self) {
        self.history.end_series();
    }

    /// Undoes the last change; returns its label.
    pub(crate) fn undo(&mut self) -> Option<String> {
        let (text, label) = self.history.undo(&self.text)?;
        self.put_old(text);
        self.note(Journal::note_undo);
        Some(label)
    }

    /// Redoes the change undone last; returns its label.
    pub(crate) fn redo(&mut self) -> Option<String> {
        let (text, label) = self.history.redo(&self.text)?;
        self.put_old(text);
        self.note(Journal::note_redo);
        Some(label)
    }

    /// Restores a text that was valid before.
    fn put_old(&mut self, text: String) {
        if let Ok(shot) = Shot::parse(&text, &self.path) {
            self.shot = shot;
        }
        self.text = text;
    }

    fn note(&mut self, note: impl FnOnce(&mut Journal) -> std::io::Result<()>) {
        if let Some(journal) = &mut self.journal
            && let Err(error) = note(journal)
        {
            tracing::warn!("the journal cannot be written: {error}");
            self.journal = None;
        }
    }

    /// Saves the file.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be written.
    pub(crate) fn save(&mut self) -> Result<(), EditError> {
        replace_text(&self.path, &self.text)?;
        self.on_disk = Some(self.text.clone());
        Ok(())
    }

    /// Saves to another path, which becomes the document's. Relative paths of scenes and pictures are adjusted.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub(crate) fn save_as(&mut self, path: &Path) -> Result<(), EditError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let seen = |file: &Path| {
            let file = path_between(folder, file)?;
            Ok::<_, EditError>(file.to_string_lossy().replace('\\', "/"))
        };
        let moved = match &self.shot.source {
            Source::Scene(scene) => Some(("scene", Setting::Text(seen(scene)?))),
            Source::Images(images) => match &images[..] {
                [only] => Some(("image", Setting::Text(seen(only)?))),
                all => {
                    let all: Result<Vec<String>, EditError> = all.iter().map(|image| seen(image)).collect();
                    Some(("image", Setting::Texts(all?)))
                }
            },
            Source::Frame => None,
        };
        let is_elsewhere = path.parent() != self.path.parent();
        let text = match moved.filter(|_| is_elsewhere) {
            Some((key, setting)) => put_setting(&self.text, &[key], &setting)?,
            None => self.text.clone(),
        };
        let shot = Shot::parse(&text, path)?;
        replace_text(path, &text)?;
        if let Some(command) = Command::between("Save as", &self.text, &text) {
            let recorded = self.history.record(command, None, &self.text);
            self.note(|journal| journal.note(&recorded));
        }
        (self.path, self.shot, self.on_disk) = (path.to_owned(), shot, Some(text.clone()));
        self.text = text;
        let path = self.path.clone();
        self.note(|journal| journal.note_path(&path));
        Ok(())
    }

    /// Checks whether another program wrote the file: reloads it if there are no unsaved changes, and merges them if they are in
    /// other places.
    ///
    /// # Errors
    /// [`EditError`] if the file on disk is not a valid shot.
    pub fn check_disk(&mut self) -> Result<DiskChange, EditError> {
        let Some(known) = &self.on_disk else { return Ok(DiskChange::None) };
        let Ok(text) = read_text(&self.path, SHOT_BYTES) else { return Ok(DiskChange::None) };
        if text == *known {
            return Ok(DiskChange::None);
        }
        if self.is_dirty() && text != self.text {
            let merged = merged(known, &self.text, &text);
            let is_merged = merged.is_some_and(|merged| self.change("Merge with the file", merged, None).is_ok());
            if !is_merged {
                return Ok(DiskChange::Conflict(text));
            }
            self.on_disk = Some(text);
            return Ok(DiskChange::Merged);
        }
        self.take_from_disk(text)?;
        Ok(DiskChange::Reloaded)
    }

    /// Takes over the text that another program wrote, as one undoable change.
    ///
    /// # Errors
    /// [`EditError`] if it is not a valid shot.
    pub(crate) fn take_from_disk(&mut self, text: String) -> Result<(), EditError> {
        self.change("Reload from disk", text.clone(), None)?;
        self.on_disk = Some(text);
        Ok(())
    }

    /// Keeps the document's text; the next save overwrites what another program wrote.
    pub(crate) fn keep_own(&mut self, on_disk: String) {
        self.on_disk = Some(on_disk);
    }
}
