//! A shot file being edited: its text, the parsed shot, and the edit history.
//!
//! In: new texts, one per edit. Out: the validated [`Shot`]; the file, with comments and order preserved. A text that
//! is not a valid shot is rejected, so that what is saved can always be rendered.

mod disk;
mod known_size;
mod relocation;

pub(crate) use disk::DiskChange;

use super::EditError;
use super::command::Command;
use super::history::History;
use super::journal::Journal;
use super::journal_line::Line;
use super::stored_path::StoredPath;
use super::unfinished::taken_up;
use crate::files::{SHOT_BYTES, read_text};
use crate::scene::{FileAccess, Scene};
use crate::shot::{Shot, ShotError};
use known_size::KnownSize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An open shot file.
#[derive(Debug)]
pub(crate) struct Document {
    /// Its absolute path.
    path: PathBuf,
    text: String,
    /// The contents of files as last read or written: the document's, and those that it had before it was saved elsewhere.
    known: BTreeMap<PathBuf, String>,
    shot: Shot,
    plate_size: KnownSize,
    /// The files that the scene may refer to.
    access: FileAccess,
    /// Whether it ever had a file.
    had_file: bool,
    history: History,
    journal: Option<Journal>,
    /// What is wrong with the journal, until it is told.
    journal_fault: Option<String>,
    /// The scene of a new shot, which was loaded to write the shot.
    scene: Option<Scene>,
}

impl Document {
    /// Reads a shot file.
    ///
    /// # Errors
    /// [`EditError`] if the file cannot be read or is not a valid shot.
    pub(crate) fn open(path: &Path) -> Result<Self, EditError> {
        let text = read_text(path, SHOT_BYTES).map_err(|source| EditError::Io { path: path.to_owned(), source })?;
        let mut document = Self::new(path, text.clone())?;
        document.known.insert(document.path.clone(), text);
        document.had_file = true;
        Ok(document)
    }

    /// Creates a shot that has no file yet.
    ///
    /// # Errors
    /// [`EditError`] if the text is not a valid shot.
    pub(crate) fn new(path: &Path, text: String) -> Result<Self, EditError> {
        let path = absolute(path);
        let plate_size = KnownSize::default();
        let shot = plate_size.parsed(&text, &path)?;
        let (known, history, access) = (BTreeMap::new(), History::default(), FileAccess::default());
        Ok(Self {
            path,
            text,
            known,
            shot,
            plate_size,
            access,
            had_file: false,
            history,
            journal: None,
            journal_fault: None,
            scene: None,
        })
    }

    /// Sets which files the scene may refer to; shot files do not store this.
    pub(crate) fn allowing(mut self, access: FileAccess) -> Self {
        self.access = access;
        self.shot.allow_outside = access == FileAccess::Anywhere;
        self
    }

    /// Parses a text as this document's, at a path.
    fn parsed(&self, text: &str, path: &Path) -> Result<Shot, ShotError> {
        Ok(Shot { allow_outside: self.access == FileAccess::Anywhere, ..self.plate_size.parsed(text, path)? })
    }

    /// Keeps a scene that is loaded already, so that it need not be loaded again.
    pub(crate) fn with_scene(self, scene: Option<Scene>) -> Self {
        Self { scene, ..self }
    }

    /// Takes the loaded scene.
    pub(crate) const fn take_scene(&mut self) -> Option<Scene> {
        self.scene.take()
    }

    /// Restores a document from the journal of a killed editor, and goes on with that journal.
    ///
    /// # Errors
    /// As [`Self::new`], and if another editor has the journal open; the journal then stays.
    pub(crate) fn recovered(journal: &Path) -> Result<Self, EditError> {
        let io = |source| EditError::Io { path: journal.to_owned(), source };
        let (left, file) = taken_up(journal).map_err(io)?;
        let mut document = Self::new(&left.path, left.text)?;
        (document.known, document.history, document.had_file) = (left.known, left.history, true);
        document.journal = Some(Journal::resume(left.journal, file, left.length).map_err(io)?);
        Ok(document)
    }

    /// Starts a journal in a folder, unless the document has one. Without one, editing goes on, and a fault is told.
    pub(crate) fn keep_journal(&mut self, folder: &Path) {
        let begin = Line::Begin { path: StoredPath(self.path.clone()), text: self.text.clone() };
        let disk = self.on_disk().map(|text| Line::Disk(Some(text.to_owned())));
        let lines: Vec<Line> = std::iter::once(begin).chain(disk).collect();
        match Journal::begin(folder, &lines) {
            Ok(journal) => self.journal = Some(journal),
            Err(error) => {
                let what = format!("{}: no journal of the changes can be kept: {error}", folder.display());
                self.journal_fault = Some(format!("{what}; save often"));
            }
        }
    }

    /// Returns whether changes are written to a journal.
    pub(crate) const fn has_journal(&self) -> bool {
        self.journal.is_some()
    }

    /// Returns what is wrong with the journal, once.
    pub(crate) const fn take_journal_fault(&mut self) -> Option<String> {
        self.journal_fault.take()
    }

    /// Returns the absolute path of the shot file.
    #[must_use]
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the text.
    #[must_use]
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the parsed shot.
    #[must_use]
    pub(crate) const fn shot(&self) -> &Shot {
        &self.shot
    }

    /// Returns the edit history.
    #[must_use]
    pub(crate) const fn history(&self) -> &History {
        &self.history
    }

    /// Returns whether there are unsaved changes.
    #[must_use]
    pub(crate) fn is_dirty(&self) -> bool {
        self.on_disk() != Some(&self.text)
    }

    /// Returns whether something would be lost if the document was closed: a shot without a file that nobody changed is made again
    /// from its scene.
    #[must_use]
    pub(crate) fn has_unsaved_work(&self) -> bool {
        let is_untouched = !self.had_file && self.history.labels().next().is_none();
        self.is_dirty() && !is_untouched
    }

    /// Replaces the text. Consecutive changes with the same `series` are undone together.
    ///
    /// # Errors
    /// [`ShotError`] if the text is not a valid shot; the document is then unchanged.
    pub(crate) fn change(&mut self, label: &str, text: String, series: Option<&str>) -> Result<(), ShotError> {
        let Some(command) = Command::between(label, &self.text, &text) else { return Ok(()) };
        self.shot = self.parsed(&text, &self.path)?;
        let recorded = self.history.record(command, series, &self.text);
        self.text = text;
        self.note(&recorded.into());
        Ok(())
    }

    /// Reads what the shot takes from its files again, such as the size of its plates.
    pub(crate) fn read_files_again(&mut self) {
        self.plate_size.forget();
        if let Ok(shot) = self.parsed(&self.text, &self.path) {
            self.shot = shot;
        }
    }

    /// Ends the series: the next change is undone separately.
    pub(crate) fn end_series(&mut self) {
        self.history.end_series();
    }

    /// Undoes the last change; returns its label. If the document was saved elsewhere by it, its path is the former one again.
    pub(crate) fn undo(&mut self) -> Option<String> {
        let (text, command) = self.history.undo(&self.text)?;
        let label = self.put_old(text, &command.label, command.paths().map(|[before, _]| before));
        self.note(&Line::Undo);
        Some(label)
    }

    /// Redoes the change undone last; returns its label.
    pub(crate) fn redo(&mut self) -> Option<String> {
        let (text, command) = self.history.redo(&self.text)?;
        let label = self.put_old(text, &command.label, command.paths().map(|[_, after]| after));
        self.note(&Line::Redo);
        Some(label)
    }

    /// Restores a text that was valid before, and the path that the document had then. Returns the label for the user.
    fn put_old(&mut self, text: String, label: &str, path: Option<&Path>) -> String {
        let label = match path {
            Some(path) => {
                path.clone_into(&mut self.path);
                format!("{label}; the shot is {}", path.display())
            }
            None => label.to_owned(),
        };
        if let Ok(shot) = self.parsed(&text, &self.path) {
            self.shot = shot;
        }
        self.text = text;
        label
    }

    fn note(&mut self, line: &Line) {
        let Some(journal) = &mut self.journal else { return };
        let is_told = journal.is_behind();
        if let Err(error) = journal.note(line)
            && !is_told
        {
            let what = format!("The journal of the changes cannot be written: {error}");
            self.journal_fault = Some(format!("{what}; save now, as a crash would lose what is not saved"));
        }
    }
}

/// Returns a path that does not depend on the working directory.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const SHOT: &str = "scene = \"x.glb\"\nframes = { first = 1, last = 6 }\nsamples = 4\n";

    fn journals(folder: &Path) -> Vec<PathBuf> {
        fs::read_dir(folder).expect("there").map(|entry| entry.expect("readable").path()).collect()
    }

    /// Leaves the journal of a document as a kill does: without its lock.
    fn kill(document: Document, folder: &Path) -> PathBuf {
        let [journal] = &journals(folder)[..] else { panic!("one journal") };
        let bytes = fs::read(journal).expect("written");
        drop(document);
        fs::write(journal, bytes).expect("written");
        journal.clone()
    }

    #[test]
    fn files_outside_stay_allowed_through_edits() {
        let document = Document::new(Path::new("shot.toml"), SHOT.to_owned()).expect("a shot");
        assert!(!document.shot().allow_outside);
        let mut document = document.allowing(FileAccess::Anywhere);
        document.change("edit", SHOT.replace("samples = 4", "samples = 5"), None).expect("a shot");
        assert!(document.shot().allow_outside && document.shot().samples == 5);
        document.undo();
        assert!(document.shot().allow_outside && document.shot().samples == 4);
    }

    #[test]
    fn work_survives_a_second_kill_after_its_recovery() {
        let folder = tempfile::tempdir().expect("a folder");
        let [shot, kept] = ["shot.toml", "journals"].map(|name| folder.path().join(name));
        fs::write(&shot, SHOT).expect("written");
        let mut document = Document::open(&shot).expect("a shot");
        document.keep_journal(&kept);
        let [first, second] = [5, 6].map(|samples| SHOT.replace("samples = 4", &format!("samples = {samples}")));
        document.change("first", first.clone(), None).expect("a shot");
        let journal = kill(document, &kept);
        // It is killed again without another change, and once more with one.
        let document = Document::recovered(&journal).expect("it is left");
        assert_eq!((document.text(), document.is_dirty()), (first.as_str(), true));
        assert!(Document::recovered(&journal).is_err(), "it is open");
        let journal = kill(document, &kept);
        let mut document = Document::recovered(&journal).expect("it is left");
        document.change("second", second.clone(), None).expect("a shot");
        let journal = kill(document, &kept);
        let mut document = Document::recovered(&journal).expect("it is left");
        assert_eq!(document.text(), second);
        assert_eq!(
            [document.undo(), document.undo(), document.undo()],
            [Some("second".into()), Some("first".into()), None]
        );
        assert_eq!((document.text(), document.is_dirty()), (SHOT, false));
        drop(document);
        assert!(journals(&kept).is_empty());
    }

    #[test]
    fn a_shot_that_is_opened_again_keeps_its_journal() {
        let folder = tempfile::tempdir().expect("a folder");
        let [shot, kept] = ["shot.toml", "journals"].map(|name| folder.path().join(name));
        fs::write(&shot, SHOT).expect("written");
        let open = || {
            let mut document = Document::open(&shot).expect("a shot");
            document.keep_journal(&kept);
            document
        };
        let first = open();
        let second = open();
        drop(first);
        assert_eq!(journals(&kept).len(), 1);
        drop(second);
        assert!(journals(&kept).is_empty());
    }

    #[test]
    fn a_journal_that_cannot_be_kept_is_told_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut document = Document::new(&folder.path().join("shot.toml"), SHOT.to_owned()).expect("a shot");
        let file = folder.path().join("file");
        fs::write(&file, "").expect("written");
        document.keep_journal(&file);
        assert!(document.take_journal_fault().is_some_and(|fault| fault.contains("save often")));
        assert_eq!(document.take_journal_fault(), None);
    }

    #[test]
    #[cfg(unix)]
    fn a_shot_of_any_name_has_a_journal() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().expect("a folder");
        let shot = folder.path().join(std::ffi::OsStr::from_bytes(b"\xff.toml"));
        let kept = folder.path().join("journals");
        let mut document = Document::new(&shot, SHOT.to_owned()).expect("a shot");
        document.keep_journal(&kept);
        assert!(document.has_journal(), "{:?}", document.take_journal_fault());
        document.change("edit", SHOT.replace("samples = 4", "samples = 5"), None).expect("a shot");
        let document = Document::recovered(&kill(document, &kept)).expect("it is left");
        assert_eq!(document.path(), shot);
    }
}
