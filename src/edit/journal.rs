//! A write-ahead journal of edits, so that no work is lost if the editor is killed.
//!
//! In: the changes of a document. Out: a file with one JSON object per line; after a crash, the restored document.

use super::command::Command;
use super::history::{History, Recorded};
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// File extension of journals.
const ENDING: &str = "pinwarp-journal";

/// A line of a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Line {
    /// The file, its text when the journal began, and the id of the editing process.
    Begin {
        path: PathBuf,
        text: String,
        process: u32,
    },
    Do(Command),
    /// Replaces the last command.
    Join(Option<Command>),
    Undo,
    Redo,
    /// The document was saved to another path.
    Path(PathBuf),
}

/// The journal of one open document. Dropping it deletes the file; a killed process leaves it behind.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
}

/// A document restored from the journal of a killed editor.
#[derive(Clone, Debug)]
pub(crate) struct Unfinished {
    /// The shot file.
    pub(crate) path: PathBuf,
    /// Its text with all journalled changes.
    pub(crate) text: String,
    /// The undo history.
    pub(crate) history: History,
    /// The journal's path.
    pub(crate) journal: PathBuf,
}

impl Journal {
    /// Starts a journal in a folder, which is created if needed.
    ///
    /// # Errors
    /// I/O errors of creating or writing the file.
    pub(crate) fn begin(folder: &Path, document: &Path, text: &str) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let process = std::process::id();
        let name = XxHash3_128::oneshot(document.as_os_str().as_encoded_bytes());
        let path = folder.join(format!("{name:032x}-{process}.{ENDING}"));
        let file = OpenOptions::new().create(true).write(true).truncate(true).open(&path)?;
        let mut journal = Self { path, file };
        journal.write(&Line::Begin { path: document.to_owned(), text: text.to_owned(), process })?;
        Ok(journal)
    }

    /// Records a change.
    ///
    /// # Errors
    /// I/O errors of writing.
    pub(crate) fn note(&mut self, recorded: &Recorded) -> io::Result<()> {
        self.write(&match recorded {
            Recorded::Added(command) => Line::Do(command.clone()),
            Recorded::Joined(command) => Line::Join(command.clone()),
        })
    }

    /// Records an undo.
    ///
    /// # Errors
    /// I/O errors of writing.
    pub(crate) fn note_undo(&mut self) -> io::Result<()> {
        self.write(&Line::Undo)
    }

    /// Records a redo.
    ///
    /// # Errors
    /// I/O errors of writing.
    pub(crate) fn note_redo(&mut self) -> io::Result<()> {
        self.write(&Line::Redo)
    }

    /// Records that the document has another path.
    ///
    /// # Errors
    /// I/O errors of writing.
    pub(crate) fn note_path(&mut self, document: &Path) -> io::Result<()> {
        self.write(&Line::Path(document.to_owned()))
    }

    fn write(&mut self, line: &Line) -> io::Result<()> {
        let mut bytes = serde_json::to_vec(line)?;
        bytes.push(b'\n');
        // A single write, so that a line is written whole or not at all. Once it returns, the operating system holds
        // the data, even if the process is killed.
        self.file.write_all(&bytes)
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Returns the documents that killed editors left in a folder of journals; journals of running processes are skipped.
#[must_use]
pub(crate) fn unfinished(folder: &Path) -> Vec<Unfinished> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut found: Vec<Unfinished> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == ENDING))
        .filter_map(|path| read(&path))
        .collect();
    found.sort_by(|a, b| a.journal.cmp(&b.journal));
    found
}

/// Replays a journal up to the first truncated line; `None` if it holds no changes, or its process is still running.
fn read(journal: &Path) -> Option<Unfinished> {
    let mut lines = BufReader::new(File::open(journal).ok()?).lines().map_while(Result::ok);
    let Line::Begin { mut path, text: begun, process } = serde_json::from_str(&lines.next()?).ok()? else {
        return None;
    };
    if process == std::process::id() || Path::new("/proc").join(process.to_string()).exists() {
        return None;
    }
    let (mut text, mut history) = (begun.clone(), History::default());
    for line in lines {
        let Ok(line) = serde_json::from_str::<Line>(&line) else { break };
        if let Line::Path(moved) = line {
            path = moved;
            continue;
        }
        let Some((after, next)) = replay(line, &text, history.clone()) else { break };
        (text, history) = (after, next);
    }
    (text != begun).then(|| Unfinished { path, text, history, journal: journal.to_owned() })
}

/// Applies a line to text and history.
fn replay(line: Line, text: &str, mut history: History) -> Option<(String, History)> {
    let after = match line {
        Line::Begin { .. } | Line::Path(_) => return None,
        Line::Do(command) => {
            let after = command.apply(text)?;
            history.record(command, None, text);
            after
        }
        Line::Join(command) => {
            let (before, _) = history.undo(text)?;
            match command {
                None => before,
                Some(command) => {
                    let after = command.apply(&before)?;
                    history.record(command, None, &before);
                    after
                }
            }
        }
        Line::Undo => history.undo(text)?.0,
        Line::Redo => history.redo(text)?.0,
    };
    Some((after, history))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Leaves a journal as a killed process would: the file stays, with the id of a process that does not run.
    fn killed(folder: &Path, journal: Journal) {
        let text = fs::read_to_string(&journal.path).expect("it is there");
        let dead = text.replacen(&format!("\"process\":{}", std::process::id()), "\"process\":4194305", 1);
        drop(journal);
        fs::write(folder.join(format!("left.{ENDING}")), dead).expect("written");
    }

    #[test]
    fn a_killed_editor_s_work_comes_back_with_its_history() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::begin(folder.path(), Path::new("/shots/a.toml"), "one").expect("writable");
        let (mut history, mut text) = (History::default(), "one".to_owned());
        for (to, series) in [("two", None), ("three", Some("n")), ("four", Some("n")), ("five", None)] {
            let command = Command::between(to, &text, to).expect("they differ");
            journal.note(&history.record(command, series, &text)).expect("written");
            text = to.to_owned();
        }
        (text, _) = history.undo(&text).expect("five");
        journal.note_undo().expect("written");
        journal.note_path(Path::new("/shots/b.toml")).expect("written");
        assert_eq!((text.as_str(), unfinished(folder.path()).len()), ("four", 0), "it lives");
        killed(folder.path(), journal);
        let [left] = &unfinished(folder.path())[..] else { panic!("one is left") };
        assert_eq!((left.text.as_str(), left.path.as_path()), ("four", Path::new("/shots/b.toml")));
        let mut history = left.history.clone();
        let (before, _) = history.undo(&left.text).expect("three and four are one series");
        assert_eq!(before, "two");
    }

    #[test]
    fn a_line_cut_off_loses_itself_alone() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::begin(folder.path(), Path::new("a.toml"), "one").expect("writable");
        let command = Command::between("edit", "one", "two").expect("they differ");
        journal.note(&Recorded::Added(command)).expect("written");
        journal.file.write_all(b"{\"do\":{\"label\":\"cut").expect("written");
        killed(folder.path(), journal);
        assert_eq!(unfinished(folder.path())[0].text, "two");
    }
}
