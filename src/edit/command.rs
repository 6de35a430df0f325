//! One change of a shot's text, as a reversible replacement.
//!
//! In: the text before and after. Out: plain data that converts either into the other. Every edit of a shot is one
//! command, so that all edits can be undone, redone and journalled.

use super::stored_path::StoredPath;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A change of a text, with a label for the user.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Command {
    /// A short description, such as "Move pin".
    pub(crate) label: String,
    /// Byte offset of the first difference.
    at: usize,
    removed: String,
    inserted: String,
    /// The path of the document before and after, if it was saved elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    paths: Option<Box<[StoredPath; 2]>>,
}

impl Command {
    /// Returns the command that turns one text into another; `None` if they are equal.
    #[must_use]
    pub(crate) fn between(label: &str, before: &str, after: &str) -> Option<Self> {
        if before == after {
            return None;
        }
        let mut at = before.bytes().zip(after.bytes()).take_while(|(a, b)| a == b).count();
        while !(before.is_char_boundary(at) && after.is_char_boundary(at)) {
            at -= 1;
        }
        let (from, to) = (&before[at..], &after[at..]);
        let mut same = from.bytes().rev().zip(to.bytes().rev()).take_while(|(a, b)| a == b).count();
        while !(from.is_char_boundary(from.len() - same) && to.is_char_boundary(to.len() - same)) {
            same -= 1;
        }
        let [removed, inserted] = [from, to].map(|text| text[..text.len() - same].to_owned());
        Some(Self { label: label.to_owned(), at, removed, inserted, paths: None })
    }

    /// Adds that the document is saved elsewhere: its path before and after.
    pub(super) fn with_paths(self, paths: [&Path; 2]) -> Self {
        Self { paths: Some(Box::new(paths.map(|path| StoredPath(path.to_owned())))), ..self }
    }

    /// Returns the path of the document before and after; `None` if it stays.
    pub(super) fn paths(&self) -> Option<[&Path; 2]> {
        self.paths.as_ref().map(|paths| paths.each_ref().map(|path| path.0.as_path()))
    }

    /// Returns the text after the change; `None` if `text` is not the text before it.
    #[must_use]
    pub(crate) fn apply(&self, text: &str) -> Option<String> {
        replaced(text, self.at, (&self.removed, &self.inserted))
    }

    /// Returns the text before the change; `None` if `text` is not the text after it.
    #[must_use]
    pub(crate) fn undo(&self, text: &str) -> Option<String> {
        replaced(text, self.at, (&self.inserted, &self.removed))
    }
}

/// Returns a text with the changes of two others; `None` if they change the same place, or places that touch.
#[must_use]
pub(crate) fn merged(base: &str, one: &str, other: &str) -> Option<String> {
    let (Some(a), Some(b)) = (Command::between("", base, one), Command::between("", base, other)) else {
        return Some(if base == one { other } else { one }.to_owned());
    };
    let (first, last) = if a.at <= b.at { (a, b) } else { (b, a) };
    // Both may be parts of one line, whose meaning they would then share.
    let end = first.at + first.removed.len();
    let is_apart = end <= last.at && base[end..last.at].contains('\n');
    is_apart.then(|| last.apply(base).and_then(|text| first.apply(&text))).flatten()
}

fn replaced(text: &str, at: usize, (old, new): (&str, &str)) -> Option<String> {
    let rest = text.get(at..)?.strip_prefix(old)?;
    Some([&text[..at], new, rest].concat())
}

#[cfg(test)]
mod tests {
    use super::{Command, merged};

    #[test]
    fn changes_of_any_kind_go_there_and_back() {
        let texts = ["", "a", "ab", "aba", "äöü", "äüö", "éé", "é", "x = 1 # ß\n", "x = 1 # ẞ\n", "aaaa", "aa"];
        for before in texts {
            for after in texts {
                match Command::between("edit", before, after) {
                    None => assert_eq!(before, after),
                    Some(command) => {
                        assert_eq!(command.apply(before).as_deref(), Some(after), "{before:?} to {after:?}");
                        assert_eq!(command.undo(after).as_deref(), Some(before), "{after:?} to {before:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_command_applies_to_its_own_text_alone() {
        let command = Command::between("Raise", "x = 1\ny = 2\n", "x = 3\ny = 2\n").expect("they differ");
        assert_eq!(command.apply("x = 1\ny = 2\n").as_deref(), Some("x = 3\ny = 2\n"));
        assert_eq!(command.undo("x = 3\ny = 2\n").as_deref(), Some("x = 1\ny = 2\n"));
        assert_eq!(command.apply("another text"), None);
    }

    #[test]
    fn changes_of_the_same_line_do_not_merge() {
        let base = "x = 1\ny = 2\nz = 3\n";
        assert_eq!(
            merged(base, "x = 9\ny = 2\nz = 3\n", "x = 1\ny = 2\nz = 8\n").as_deref(),
            Some("x = 9\ny = 2\nz = 8\n")
        );
        assert_eq!(merged(base, "x = 9\ny = 2\nz = 3\n", "x = 8\ny = 2\nz = 3\n"), None);
    }
}
