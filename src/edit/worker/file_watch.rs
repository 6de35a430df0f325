//! Whether the files of a shot changed on disk: a look at their times, while there is nothing else to do.

use crate::pipeline::OpenShot;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Files and the times at which they were written.
#[derive(Debug, Default)]
pub(super) struct FileWatch {
    shot: PathBuf,
    stamps: Vec<(PathBuf, Option<SystemTime>)>,
}

/// What changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Changed {
    /// The shot file.
    pub(super) shot: bool,
    /// What it is about: scene, pictures, masks.
    pub(super) scene: bool,
}

fn stamp(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

impl FileWatch {
    /// Watches the files of a loaded shot.
    pub(super) fn of(open: &OpenShot) -> Self {
        let shot = open.given();
        let paths = std::iter::once(&shot.path).chain(shot.files()).chain(&open.prepared().scene.files_beside);
        Self { shot: shot.path.clone(), stamps: paths.map(|path| (path.clone(), stamp(path))).collect() }
    }

    /// What changed since the last look. Files that are gone are being written, or will be missed when they are needed.
    pub(super) fn look(&mut self) -> Changed {
        let mut changed = Changed::default();
        for (path, known) in &mut self.stamps {
            let now = stamp(path);
            if now.is_some() && now != *known {
                *known = now;
                if *path == self.shot { changed.shot = true } else { changed.scene = true }
            }
        }
        changed
    }
}
