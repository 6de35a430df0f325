//! A TOML text as a tree that records the line of every key.
//!
//! In: a text and its file name. Out: [`Document`], and errors with positions in the text.

use super::{KeyLines, ShotError};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A parsed text.
pub(super) struct Document<'a> {
    /// The file, for messages.
    pub(super) path: &'a Path,
    /// Its text.
    pub(super) text: &'a str,
    /// The tree.
    pub(super) root: Spanned<DeValue<'a>>,
    /// The lines of its keys.
    pub(super) lines: KeyLines,
}

impl<'a> Document<'a> {
    /// Parses a text.
    ///
    /// # Errors
    /// [`ShotError::Syntax`] if it is not TOML.
    pub(super) fn parse(text: &'a str, path: &'a Path) -> Result<Self, ShotError> {
        let table = DeTable::parse(text).map_err(|error| syntax_error(text, path, &error))?;
        let root = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
        let mut lines = KeyLines::default();
        collect_lines(&LineStarts::of(text), &root, "", &mut lines);
        Ok(Self { path, text, root, lines })
    }

    /// Returns the one-based line of a key; if the key is missing, that of the table that should contain it.
    pub(super) fn line(&self, key: &str) -> usize {
        self.lines.of(key)
    }

    /// Returns whether the file contains this key (or list item).
    pub(super) fn has(&self, key: &str) -> bool {
        self.lines.has(key)
    }

    /// Creates a fault at a key of this document.
    pub(super) fn fault(&self, key: &str, what: impl Into<String>, hint: impl Into<String>) -> ShotError {
        ShotError::Invalid {
            path: self.path.to_owned(),
            line: self.line(key),
            key: key.to_owned(),
            what: what.into(),
            hint: hint.into(),
        }
    }
}

/// Converts a TOML parser error, with its position.
pub(super) fn syntax_error(text: &str, path: &Path, error: &toml::de::Error) -> ShotError {
    let (line, column) = line_column(text, error.span().map_or(0, |span| span.start));
    ShotError::Syntax { path: path.to_owned(), line, column, what: error.message().replace('\n', ", ") }
}

/// Returns `parent.key`, or `key` at the top level; keys that are not bare are quoted as in TOML.
pub(super) fn child(parent: &str, key: &str) -> String {
    let is_plain = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    let key = if is_plain { key.to_owned() } else { format!("{key:?}") };
    if parent.is_empty() { key } else { format!("{parent}.{key}") }
}

/// Byte offsets of the line starts, so that looking up a line does not scan the text before it.
struct LineStarts(Vec<usize>);

impl LineStarts {
    fn of(text: &str) -> Self {
        let newlines = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n');
        Self(std::iter::once(0).chain(newlines.map(|(at, _)| at + 1)).collect())
    }

    /// Returns the one-based line of a byte offset.
    fn line(&self, offset: usize) -> usize {
        self.0.partition_point(|&start| start <= offset)
    }
}

fn collect_lines(starts: &LineStarts, node: &Spanned<DeValue>, path: &str, lines: &mut KeyLines) {
    match node.get_ref() {
        DeValue::Table(table) => {
            for (key, value) in table {
                let path = child(path, key.get_ref());
                collect_lines(starts, value, &path, lines);
                lines.insert(path, starts.line(key.span().start));
            }
        }
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                let path = format!("{path}[{index}]");
                collect_lines(starts, item, &path, lines);
                lines.insert(path, starts.line(item.span().start));
            }
        }
        _ => {}
    }
}

/// Returns the one-based line and column of a byte offset.
fn line_column(text: &str, offset: usize) -> (usize, usize) {
    let before = &text.as_bytes()[..offset.min(text.len())];
    let line_start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |newline| newline + 1);
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    // Counts characters by skipping the continuation bytes of UTF-8.
    let column = 1 + before[line_start..].iter().filter(|&&byte| byte & 0xC0 != 0x80).count();
    (line, column)
}
