//! The shot file: saved, and read again.
//!
//! In: user commands, changes on disk. Out: the file, messages.

use super::Session;
use crate::edit::{DiskChange, EditError};

impl Session {
    /// Saves the file, with what another program wrote elsewhere in it.
    ///
    /// # Errors
    /// [`EditError`] if it cannot be written, or another program wrote it where there are unsaved changes.
    pub(crate) fn save(&mut self) -> Result<(), EditError> {
        let change = self.document.save()?;
        let path = self.document.path().display().to_string();
        match change {
            DiskChange::None => self.say(saved(&path, self.fault())),
            DiskChange::Merged | DiskChange::Reloaded => {
                self.reload();
                self.say(format!("Saved {path}, with the changes of another program."));
            }
            DiskChange::Conflict(text) => {
                self.conflict = Some(text);
                let what = format!("{path} was not saved: another program wrote it");
                return Err(EditError::Unusable { what, hint: "choose which text to keep, then save".into() });
            }
        }
        Ok(())
    }

    /// Saves to another path, which becomes the document's.
    ///
    /// # Errors
    /// As [`Self::save`].
    pub(crate) fn save_as(&mut self, path: &std::path::Path) -> Result<(), EditError> {
        self.document.save_as(path)?;
        let told = saved(&path.display().to_string(), self.fault());
        self.document_changed();
        self.say(told);
        Ok(())
    }

    /// Reloads after the shot file or its scene changed on disk.
    pub(crate) fn reload(&mut self) {
        self.worker.forget();
        self.document.read_files_again();
        self.document_changed();
    }
}

/// Returns what is said after saving; `fault`: why the shot cannot be drawn.
fn saved(path: &str, fault: Option<&str>) -> String {
    match fault {
        None => format!("Saved {path}"),
        Some(fault) => format!("Saved {path}, but this shot cannot be drawn: {fault}"),
    }
}
