//! Detects changes of a shot's files on disk, by polling modification times while idle.

use super::plate_watch::{PlateWatch, stamp};
use crate::pipeline::OpenShot;
use crate::shot::Shot;
use std::path::PathBuf;
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
    /// Whether a scene, picture or mask changed.
    pub(super) scene: bool,
    /// First and last frames, the last ones included, whose plates changed.
    pub(super) plates: Vec<[i32; 2]>,
}

impl FileWatch {
    /// Watches the files of a loaded shot.
    pub(super) fn of(open: &OpenShot) -> Self {
        let shot = open.given();
        let paths = std::iter::once(&shot.path).chain(shot.files()).chain(&open.prepared().scene.files_beside);
        let stamps = paths.map(|path| (path.clone(), stamp(path))).collect();
        Self { shot: shot.path.clone(), stamps, plate: PlateWatch::of(shot) }
    }

    /// Watches the plate of an edited shot, which may have other frames.
    pub(super) fn follow_plate(&mut self, open: &OpenShot) {
        if !self.plate.is_of(open.given()) {
            self.plate = PlateWatch::of(open.given());
        }
    }

    /// Watches the files that a shot names, too, even if they cannot be loaded. Returns whether another shot was watched before.
    pub(super) fn add(&mut self, shot: &Shot) -> bool {
        let is_other = self.shot != shot.path;
        if is_other {
            *self = Self { shot: shot.path.clone(), stamps: Vec::new(), plate: PlateWatch::of(shot) };
        }
        for path in std::iter::once(&shot.path).chain(shot.files()) {
            if self.stamps.iter().all(|(known, _)| known != path) {
                self.stamps.push((path.clone(), stamp(path)));
            }
        }
        is_other
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
}
