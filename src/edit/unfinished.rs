//! Work that killed editors left in journals.
//!
//! In: a folder of journals. Out: the documents with unsaved changes, and their histories.

use super::history::{History, Recorded};
use super::journal_line::{ENDING, Line};
use crate::files::{SHOT_BYTES, read_text};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A document restored from the journal of a killed editor.
#[derive(Clone, Debug)]
pub(crate) struct Unfinished {
    /// The shot file.
    pub(crate) path: PathBuf,
    /// Its text with all journalled changes.
    pub(super) text: String,
    /// The contents of files as the editor last read or wrote them.
    pub(super) known: BTreeMap<PathBuf, String>,
    /// The undo history.
    pub(crate) history: History,
    /// The journal's path.
    pub(crate) journal: PathBuf,
    /// Number of bytes of the journal's whole lines.
    pub(super) length: u64,
}

/// Returns the documents that killed editors left in a folder of journals, the latest first. Journals of running editors
/// are skipped, and those whose work is saved are deleted.
#[must_use]
pub(crate) fn unfinished(folder: &Path) -> Vec<Unfinished> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<(SystemTime, Unfinished)> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == ENDING))
        .filter_map(|path| {
            // Some file systems lock only files that may be written.
            let file = OpenOptions::new().read(true).write(true).open(&path).ok()?;
            let is_locked = lock(&file).ok()?;
            let written = file.metadata().and_then(|data| data.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
            let replayed = Replay::read(&file)?;
            if replayed.is_work() {
                return Some((written, replayed.left(path)));
            }
            if is_locked && replayed.is_whole {
                let _ = fs::remove_file(&path);
            }
            None
        })
        .collect();
    found.sort_by_key(|(written, _)| Reverse(*written));
    found.into_iter().map(|(_, left)| left).collect()
}

/// Reads a journal to continue it: returns its document, and its locked file.
///
/// # Errors
/// I/O errors, also if another editor has recovered it meanwhile.
pub(super) fn taken_up(journal: &Path) -> io::Result<(Unfinished, File)> {
    let file = OpenOptions::new().read(true).write(true).open(journal)?;
    lock(&file)?;
    let replayed = Replay::read(&file).ok_or_else(|| io::Error::new(ErrorKind::InvalidData, "it holds no shot"))?;
    Ok((replayed.left(journal.to_owned()), file))
}

/// Deletes a journal, unless another editor has recovered it meanwhile.
pub(crate) fn forget(journal: &Path) {
    let _ = taken_up(journal).and_then(|_locked| fs::remove_file(journal));
}

/// Locks the journal of an editor that does not run; returns false if the file system has no locks.
fn lock(file: &File) -> io::Result<bool> {
    match file.try_lock() {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => {
            Err(io::Error::new(ErrorKind::WouldBlock, "another window of the editor has it open"))
        }
        Err(TryLockError::Error(_)) => Ok(false),
    }
}

/// A document while its journal is read.
struct Replay {
    path: PathBuf,
    begun: String,
    text: String,
    history: History,
    known: BTreeMap<PathBuf, String>,
    /// Whether the journal says what was on disk.
    has_disk: bool,
    length: u64,
    /// Whether every line was understood.
    is_whole: bool,
}

impl Replay {
    /// Repeats a journal up to the first line that is cut off or does not fit; `None` if it has no beginning.
    fn read(file: &File) -> Option<Self> {
        let mut lines = BufReader::new(file);
        let mut bytes = Vec::new();
        let mut next = || -> Option<(u64, Option<Line>)> {
            bytes.clear();
            let length = lines.read_until(b'\n', &mut bytes).ok().filter(|length| *length > 0)?;
            Some((length as u64, bytes.ends_with(b"\n").then(|| serde_json::from_slice(&bytes).ok()).flatten()))
        };
        let (length, Some(Line::Begin { path, text })) = next()? else { return None };
        let mut replay = Self {
            path: path.0,
            begun: text.clone(),
            text,
            history: History::default(),
            known: BTreeMap::new(),
            has_disk: false,
            length,
            is_whole: true,
        };
        while let Some((length, line)) = next() {
            if line.and_then(|line| replay.repeat(line)).is_none() {
                replay.is_whole = false;
                break;
            }
            replay.length += length;
        }
        Some(replay)
    }

    /// Repeats a line; `None`, and no effect, if it does not fit.
    fn repeat(&mut self, line: Line) -> Option<()> {
        match line {
            Line::Begin { .. } => return None,
            Line::Do(command) => {
                let path = command.paths().map(|[_, path]| path.to_owned());
                self.text = self.history.repeat(Recorded::Added(command), &self.text)?;
                path.into_iter().for_each(|path| self.path = path);
            }
            Line::Join(command) => self.text = self.history.repeat(Recorded::Joined(command), &self.text)?,
            Line::Undo => {
                let (text, command) = self.history.undo(&self.text)?;
                self.text = text;
                command.paths().into_iter().for_each(|[path, _]| self.path = path.to_owned());
            }
            Line::Redo => {
                let (text, command) = self.history.redo(&self.text)?;
                self.text = text;
                command.paths().into_iter().for_each(|[_, path]| self.path = path.to_owned());
            }
            Line::Path(path) => self.path = path.0,
            Line::Disk(text) => {
                self.has_disk = true;
                match text {
                    Some(text) => _ = self.known.insert(self.path.clone(), text),
                    None => _ = self.known.remove(&self.path),
                }
            }
        }
        Some(())
    }

    /// Returns whether there are changes that are in no file.
    fn is_work(&self) -> bool {
        let is_changed =
            if self.has_disk { self.known.get(&self.path) != Some(&self.text) } else { self.text != self.begun };
        is_changed && !read_text(&self.path, SHOT_BYTES).is_ok_and(|text| text == self.text)
    }

    fn left(self, journal: PathBuf) -> Unfinished {
        let Self { path, text, history, known, length, .. } = self;
        Unfinished { path, text, known, history, journal, length }
    }
}

#[cfg(test)]
mod tests {
    use super::super::command::Command;
    use super::super::journal::Journal;
    use super::super::stored_path::StoredPath;
    use super::*;

    fn begin(path: &str, text: &str) -> Line {
        Line::Begin { path: StoredPath(path.into()), text: text.to_owned() }
    }

    fn change(from: &str, to: &str) -> Line {
        Line::Do(Command::between("edit", from, to).expect("they differ"))
    }

    /// Writes a journal as a killed editor leaves it: without a lock.
    fn leave(folder: &Path, name: &str, lines: &[Line]) -> PathBuf {
        let path = folder.join(format!("{name}.{ENDING}"));
        let lines = lines.iter().map(|line| serde_json::to_string(line).expect("written") + "\n");
        fs::write(&path, lines.collect::<String>()).expect("written");
        path
    }

    #[test]
    fn a_killed_editor_s_work_comes_back_with_its_history() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut lines = vec![begin("/none/a.toml", "one")];
        let (mut history, mut text) = (History::default(), "one".to_owned());
        for (to, series) in [("two", None), ("three", Some("n")), ("four", Some("n")), ("five", None)] {
            let command = Command::between(to, &text, to).expect("they differ");
            lines.push(history.record(command, series, &text).into());
            text = to.to_owned();
        }
        lines.extend([Line::Undo, Line::Path(StoredPath("/none/b.toml".into()))]);
        let living = Journal::begin(folder.path(), &lines).expect("writable");
        assert!(unfinished(folder.path()).is_empty(), "it lives");
        leave(folder.path(), "left", &lines);
        let [left] = &unfinished(folder.path())[..] else { panic!("one is left") };
        assert_eq!((left.text.as_str(), left.path.as_path()), ("four", Path::new("/none/b.toml")));
        let mut history = left.history.clone();
        let (before, _) = history.undo(&left.text).expect("three and four are one series");
        assert_eq!(before, "two");
        drop(living);
        assert_eq!(unfinished(folder.path()).len(), 1, "the other one stays");
    }

    #[test]
    fn a_line_cut_off_loses_itself_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = leave(folder.path(), "left", &[begin("/none/a.toml", "one"), change("one", "two")]);
        let whole = fs::read_to_string(&path).expect("there");
        fs::write(&path, format!("{whole}{{\"do\":{{\"label\":\"cut")).expect("written");
        assert_eq!(unfinished(folder.path())[0].text, "two");
        // What is journalled after the recovery comes back, too.
        let (left, file) = taken_up(&path).expect("nobody has it open");
        let mut journal = Journal::resume(path.clone(), file, left.length).expect("writable");
        journal.note(&change("two", "three")).expect("written");
        assert_eq!(taken_up(&path).map(|_| ()).expect_err("it is open").kind(), ErrorKind::WouldBlock);
        forget(&path);
        let again = fs::read_to_string(&path).expect("there");
        drop(journal);
        fs::write(&path, again).expect("written");
        let [left] = &unfinished(folder.path())[..] else { panic!("one is left") };
        assert_eq!((left.text.as_str(), left.history.labels().count()), ("three", 2));
    }

    #[test]
    fn work_that_is_in_a_file_is_not_offered() {
        let folder = tempfile::tempdir().expect("a folder");
        let shot = folder.path().join("a.toml");
        let name = shot.to_str().expect("Unicode");
        let disk = |text: &str| Line::Disk(Some(text.to_owned()));
        let saved = [begin(name, "one"), disk("one"), change("one", "two"), disk("two")];
        // Saved, and changed by another program afterwards.
        fs::write(&shot, "other").expect("written");
        let path = leave(folder.path(), "saved", &saved);
        assert!(unfinished(folder.path()).is_empty());
        assert!(!path.exists(), "nothing is left in it");
        // Undone after it was saved: the text of the beginning is not in the file.
        leave(folder.path(), "undone", &[&saved[..], &[Line::Undo]].concat());
        let [left] = &unfinished(folder.path())[..] else { panic!("one is left") };
        assert_eq!((left.text.as_str(), left.known.get(&shot).map(String::as_str)), ("one", Some("two")));
        // The file holds it after all: the editor was killed between the file and the journal.
        fs::write(&shot, "one").expect("written");
        assert!(unfinished(folder.path()).is_empty());
        // The file was removed while it was open, and nothing was changed.
        fs::remove_file(&shot).expect("there");
        leave(folder.path(), "removed", &[begin(name, "one"), disk("one"), Line::Disk(None)]);
        assert_eq!(unfinished(folder.path()).len(), 1);
    }
}
