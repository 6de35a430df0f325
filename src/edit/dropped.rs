//! Files dropped together: which of them is opened, and what becomes of the others.
//!
//! In: paths. Out: candidates to open, pictures to lay over the frame, and the rest. The files themselves are not read.

use crate::image::PictureKind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// What was dropped.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dropped {
    /// What may be opened: shots first, as they name scenes that may have been dropped with them; else in order.
    pub(crate) candidates: Vec<PathBuf>,
    /// Pictures beside them; numbered ones as a sequence, `draw.####.png`.
    pub(crate) pictures: Vec<PathBuf>,
    /// Files of other kinds.
    pub(crate) others: Vec<PathBuf>,
}

impl Dropped {
    /// Sorts files by their kinds. Without a shot, scene or problem the first picture or sequence is opened.
    pub(crate) fn of(paths: impl IntoIterator<Item = PathBuf>) -> Self {
        let mut found = Self::default();
        for path in paths {
            if PictureKind::of(&path).is_some() {
                found.pictures.push(path);
            } else if ["toml", "glb", "gltf", "json"].contains(&ending(&path).as_str()) {
                found.candidates.push(path);
            } else {
                found.others.push(path);
            }
        }
        found.candidates.sort_by_key(|path| ending(path) != "toml");
        found.pictures = sequences(&found.pictures);
        if found.candidates.is_empty() && !found.pictures.is_empty() {
            found.candidates.push(found.pictures.remove(0));
        }
        if found.candidates.is_empty() && !found.others.is_empty() {
            // Opening it says what can be opened.
            found.candidates.push(found.others.remove(0));
        }
        found
    }
}

fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Replaces pictures that differ in a number at the end of their names by the sequence that they are.
fn sequences(pictures: &[PathBuf]) -> Vec<PathBuf> {
    let patterns: Vec<Option<PathBuf>> = pictures.iter().map(|path| pattern(path)).collect();
    let mut seen = BTreeSet::new();
    let mut found = Vec::new();
    for (path, pattern) in pictures.iter().zip(&patterns) {
        let is_many = pattern.is_some() && patterns.iter().filter(|other| *other == pattern).count() > 1;
        let path = pattern.as_ref().filter(|_| is_many).unwrap_or(path);
        if seen.insert(path.clone()) {
            found.push(path.clone());
        }
    }
    found
}

/// Returns the name of a picture with its number replaced by a counter; `None` if it has no number.
fn pattern(path: &Path) -> Option<PathBuf> {
    let (stem, ending) = path.file_name()?.to_str()?.rsplit_once('.')?;
    let before = stem.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let digits = stem.len() - before.len();
    (digits > 0).then(|| path.with_file_name(format!("{before}{}.{ending}", "#".repeat(digits))))
}

/// Returns the sequence that a picture belongs to, and how many pictures it has; `None` if no other picture of its folder differs from
/// it in the number alone.
pub(in crate::edit) fn sequence_around(picture: &Path) -> Option<(PathBuf, usize)> {
    let sequence = pattern(picture)?;
    let folder = picture.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names = std::fs::read_dir(folder).ok()?.flatten().map(|entry| picture.with_file_name(entry.file_name()));
    let count = names.filter(|name| pattern(name).as_ref() == Some(&sequence)).count();
    (count > 1).then_some((sequence, count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_belongs_to_the_sequence_of_its_neighbours() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.01.png", "a.02.png", "a.003.png", "b.01.png", "c.png"] {
            std::fs::write(folder.path().join(name), "").expect("written");
        }
        let around = |name: &str| sequence_around(&folder.path().join(name));
        assert_eq!(around("a.02.png"), Some((folder.path().join("a.##.png"), 2)));
        assert_eq!(["a.003.png", "b.01.png", "c.png", "a.##.png"].map(around), [const { None }; 4]);
    }

    fn of(names: &[&str]) -> [Vec<String>; 3] {
        let found = Dropped::of(names.iter().map(PathBuf::from));
        let words = |paths: Vec<PathBuf>| paths.iter().map(|path| path.display().to_string()).collect();
        [words(found.candidates), words(found.pictures), words(found.others)]
    }

    #[test]
    fn shots_are_opened_and_pictures_lie_beside_them() {
        let found = of(&["a/d.0002.png", "m.glb", "notes.txt", "a/d.0001.png", "s.toml", "b/key.png"]);
        assert_eq!(found, [vec!["s.toml", "m.glb"], vec!["a/d.####.png", "b/key.png"], vec!["notes.txt"]]);
    }

    #[test]
    fn pictures_alone_are_opened_as_one_or_as_a_sequence() {
        assert_eq!(of(&["f.11.exr", "f.12.exr", "f.png"]), [vec!["f.##.exr"], vec!["f.png"], vec![]]);
        assert_eq!(of(&["f.11.exr"]), [vec!["f.11.exr"], vec![], vec![]]);
        assert_eq!(of(&["x/f.1.exr", "y/f.1.exr"]), [vec!["x/f.1.exr"], vec!["y/f.1.exr"], vec![]]);
        assert_eq!(of(&["notes.txt"]), [vec!["notes.txt"], vec![], vec![]]);
        assert_eq!(of(&[]), [vec![] as Vec<String>, vec![], vec![]]);
    }
}
