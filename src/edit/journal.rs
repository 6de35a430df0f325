//! A write-ahead journal of edits, so that no work is lost if the editor is killed.
//!
//! In: the changes of a document. Out: a file with one JSON object per line, locked while its editor lives.

use super::journal_line::{ENDING, Line};
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::Builder;

/// The journal of one open document. Dropping it deletes the file; a killed process leaves it behind.
#[derive(Debug)]
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Number of bytes of whole lines in the file.
    length: u64,
    /// Lines that could not be written yet.
    pending: Vec<u8>,
}

impl Journal {
    /// Starts a journal in a folder, which is created if needed.
    ///
    /// # Errors
    /// I/O errors of creating or writing the file.
    pub(super) fn begin(folder: &Path, lines: &[Line]) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        // Each journal has a name of its own, as a document may be opened again while it is open.
        let ending = format!(".{ENDING}");
        let (file, path) = Builder::new().prefix("shot-").suffix(&ending).tempfile_in(folder)?.keep()?;
        // Some network file systems have no locks; the journal is kept anyway.
        let _ = file.lock();
        let mut journal = Self::resume(path, file, 0)?;
        lines.iter().try_for_each(|line| journal.note(line))?;
        Ok(journal)
    }

    /// Continues a journal after its first bytes; the file must be locked.
    ///
    /// # Errors
    /// I/O errors of cutting off the rest of the file, which is then kept as it is.
    pub(super) fn resume(path: PathBuf, mut file: File, length: u64) -> io::Result<Self> {
        cut(&mut file, length)?;
        Ok(Self { path, file, length, pending: Vec::new() })
    }

    /// Writes a line, after those that could not be written before.
    ///
    /// # Errors
    /// I/O errors of writing; the line is then written with the next one.
    pub(super) fn note(&mut self, line: &Line) -> io::Result<()> {
        let is_torn = self.is_behind();
        serde_json::to_writer(&mut self.pending, line)?;
        self.pending.push(b'\n');
        if is_torn {
            // A line that was written in part would hide those after it.
            cut(&mut self.file, self.length)?;
        }
        // A single write, so that a line is written whole or not at all. Once it returns, the operating system holds
        // the data, even if the process is killed.
        self.file.write_all(&self.pending)?;
        self.length += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }

    /// Returns whether there are lines that could not be written.
    pub(super) const fn is_behind(&self) -> bool {
        !self.pending.is_empty()
    }
}

/// Cuts off what follows the first bytes of a file, so that writing goes on there.
fn cut(file: &mut File, length: u64) -> io::Result<()> {
    file.set_len(length)?;
    file.seek(SeekFrom::Start(length)).map(drop)
}

impl Drop for Journal {
    fn drop(&mut self) {
        // A panic must leave the work behind.
        if !std::thread::panicking() {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_could_not_be_written_follow_as_soon_as_they_can() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut journal = Journal::begin(folder.path(), &[Line::Undo]).expect("writable");
        let path = journal.path.clone();
        // A file that cannot be written stands for a full disk.
        let writable = std::mem::replace(&mut journal.file, File::open(&path).expect("there"));
        journal.note(&Line::Redo).expect_err("the file is read-only");
        journal.note(&Line::Undo).expect_err("still");
        assert!(journal.is_behind());
        let mut torn = fs::OpenOptions::new().append(true).open(&path).expect("there");
        torn.write_all(b"\"re").expect("a part of a line");
        journal.file = writable;
        journal.note(&Line::Redo).expect("there is room again");
        assert!(!journal.is_behind());
        assert_eq!(fs::read_to_string(&path).expect("kept"), "\"undo\"\n\"redo\"\n\"undo\"\n\"redo\"\n");
        drop(journal);
        assert!(!path.exists());
    }
}
