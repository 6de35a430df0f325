//! Detects changes of a shot's files on disk, by polling modification times while idle.

use super::plate_watch::{PlateWatch, stamp};
use crate::shot::Shot;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Files and their modification times.
#[derive(Debug, Default)]
pub(super) struct FileWatch {
    shot: PathBuf,
    stamps: Vec<(PathBuf, Option<SystemTime>)>,
    plate: PlateWatch,
}

/// The changed files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Changed {
    /// Whether the shot file changed.
    pub(super) shot: bool,
    /// Whether a scene, a file beside it, a picture or a mask changed.
    pub(super) scene: bool,
    /// First and last frames, the last ones included, whose plates changed.
    pub(super) plates: Vec<[i32; 2]>,
}

impl FileWatch {
    /// Returns whether this shot is watched, under whatever edits.
    pub(super) fn is_of(&self, shot: &Shot) -> bool {
        self.shot == shot.path
    }

    /// Watches the files that a shot names, too, and those beside its scene, even if they cannot be loaded. Returns whether another
    /// shot was watched before.
    pub(super) fn add(&mut self, shot: &Shot, beside: &[PathBuf]) -> bool {
        let is_other = !self.is_of(shot);
        if is_other {
            *self = Self { shot: shot.path.clone(), stamps: Vec::new(), plate: PlateWatch::of(shot) };
        }
        std::iter::once(&shot.path).chain(shot.files()).chain(beside).for_each(|path| self.watch(path));
        is_other
    }

    fn watch(&mut self, path: &Path) {
        if self.stamps.iter().all(|(known, _)| known != path) {
            self.stamps.push((path.to_owned(), stamp(path)));
        }
    }

    /// Watches the files of a loaded shot alone, with those beside its scene. Files that were watched before they were read keep
    /// their times, so that what was written meanwhile is found.
    pub(super) fn keep(&mut self, shot: &Shot, beside: &[PathBuf]) {
        let used: Vec<&PathBuf> = std::iter::once(&shot.path).chain(shot.files()).chain(beside).collect();
        self.stamps.retain(|(path, _)| used.contains(&path));
        used.into_iter().for_each(|path| self.watch(path));
    }

    /// Watches the plate of an edited shot, which may have other frames.
    pub(super) fn follow_plate(&mut self, shot: &Shot) {
        if !self.plate.is_of(shot) {
            self.plate = PlateWatch::of(shot);
        }
    }

    /// Returns what changed since the last call; a shot file that was removed has changed. Other missing files are
    /// ignored: either they are being written, or using them will report the error.
    pub(super) fn look(&mut self) -> Changed {
        let mut changed = Changed { plates: self.plate.look(), ..Changed::default() };
        for (path, known) in &mut self.stamps {
            let now = stamp(path);
            let is_shot = *path == self.shot;
            if now != *known && (is_shot || now.is_some()) {
                *known = now;
                if is_shot { changed.shot = true } else { changed.scene = true }
            }
        }
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_removed_shot_file_has_changed_and_a_removed_scene_has_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let paths = ["shot.toml", "scene.glb"].map(|name| folder.path().join(name));
        for path in &paths {
            fs::write(path, "").expect("written");
        }
        let stamps = paths.iter().map(|path| (path.clone(), stamp(path))).collect();
        let mut watch = FileWatch { shot: paths[0].clone(), stamps, plate: PlateWatch::default() };
        assert_eq!(watch.look(), Changed::default());
        for path in &paths {
            fs::remove_file(path).expect("there");
        }
        assert_eq!(watch.look(), Changed { shot: true, ..Changed::default() });
        assert_eq!(watch.look(), Changed::default(), "it is told once");
        fs::write(&paths[0], "").expect("written");
        assert_eq!(watch.look(), Changed { shot: true, ..Changed::default() });
    }

    fn shot(folder: &Path) -> Shot {
        let text = "scene = 'a.gltf'\nframes = { first = 1, last = 2 }\n[[layer]]\nname = 'all'\n";
        Shot::parse(text, &folder.join("shot.toml")).expect("a shot")
    }

    #[test]
    fn what_is_written_while_a_shot_is_loaded_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let shot = shot(folder.path());
        let old = shot.path.with_file_name("old.bin");
        let mut watch = FileWatch::default();
        assert!(watch.add(&shot, std::slice::from_ref(&old)));
        fs::write(folder.path().join("a.gltf"), "").expect("written");
        watch.keep(&shot, &[folder.path().join("b.png")]);
        assert_eq!(watch.look(), Changed { scene: true, ..Changed::default() });
        assert_eq!(watch.look(), Changed::default());
        fs::write(&old, "").expect("written");
        assert_eq!(watch.look(), Changed::default(), "it is not used any more");
        fs::write(folder.path().join("b.png"), "").expect("written");
        assert_eq!(watch.look(), Changed { scene: true, ..Changed::default() });
    }
}
