//! The lines of a journal: JSON objects.
//!
//! In: what happens to a document. Out: lines that repeat it.

use super::command::Command;
use super::history::Recorded;
use super::stored_path::StoredPath;
use serde::{Deserialize, Serialize};

/// File extension of journals.
pub(super) const ENDING: &str = "pinwarp-journal";

/// A line of a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    /// The absolute path of the shot file, and the text when the journal began.
    Begin {
        path: StoredPath,
        text: String,
    },
    Do(Command),
    /// Replaces the last command.
    Join(Option<Command>),
    Undo,
    Redo,
    /// The document was saved to another path, with the same text.
    Path(StoredPath),
    /// The text of the shot file on disk; `None` if it was removed.
    Disk(Option<String>),
}

impl From<Recorded> for Line {
    fn from(recorded: Recorded) -> Self {
        match recorded {
            Recorded::Added(command) => Self::Do(command),
            Recorded::Joined(command) => Self::Join(command),
        }
    }
}
