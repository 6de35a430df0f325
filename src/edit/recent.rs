//! The shots that were open last, for the start page.
//!
//! In: a JSON list in the state folder. Out: shots that are still there, the newest first. A list that cannot be read is empty.

use super::EditError;
use super::stored_path::StoredPath;
use crate::files::{TABLE_BYTES, read_text};
use crate::image::replace_text;
use std::path::{Path, PathBuf};

/// Maximum number of shots that are kept.
const COUNT: usize = 8;

/// Returns the shots of a list that are still there.
#[must_use]
pub(crate) fn recent_shots(list: &Path) -> Vec<PathBuf> {
    read(list).into_iter().filter(|shot| shot.is_file()).collect()
}

/// Puts a shot at the head of a list; it may be saved later.
///
/// # Errors
/// [`EditError`] if the list cannot be written.
pub(crate) fn remember_shot(list: &Path, shot: &Path) -> Result<(), EditError> {
    let shot = std::path::absolute(shot).unwrap_or_else(|_| shot.to_owned());
    let old = read(list).into_iter().filter(|other| *other != shot);
    let new: Vec<StoredPath> = std::iter::once(shot.clone()).chain(old).take(COUNT).map(StoredPath).collect();
    let text = serde_json::to_string_pretty(&new).unwrap_or_default();
    Ok(replace_text(list, &text)?)
}

fn read(list: &Path) -> Vec<PathBuf> {
    let text = read_text(list, TABLE_BYTES).unwrap_or_default();
    let paths: Vec<StoredPath> = serde_json::from_str(&text).unwrap_or_default();
    paths.into_iter().map(|StoredPath(path)| path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn eight_shots_that_are_still_there_are_kept_newest_first() {
        let folder = tempfile::tempdir().expect("a folder");
        let list = folder.path().join("state/recent.json");
        assert!(recent_shots(&list).is_empty());
        let shots: Vec<PathBuf> = (0..10).map(|number| folder.path().join(format!("{number}.toml"))).collect();
        for shot in shots.iter().chain([&shots[4]]) {
            fs::write(shot, "").expect("written");
            remember_shot(&list, shot).expect("written");
        }
        let names = |list: &Path| -> String {
            let name = |shot: &PathBuf| shot.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            recent_shots(list).iter().map(name).collect()
        };
        assert_eq!(names(&list), "49876532");
        fs::remove_file(&shots[9]).expect("removed");
        assert_eq!(names(&list), "4876532", "it is not there any more");
        fs::write(&list, "no list").expect("written");
        assert!(recent_shots(&list).is_empty());
    }
}
