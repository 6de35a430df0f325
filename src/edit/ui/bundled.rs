//! Example scenes bundled with the program.

use crate::edit::EditError;
use crate::image::{replace_bytes, replace_text};
use std::path::{Path, PathBuf};

/// A bundled scene.
pub(super) struct Bundled {
    pub(super) title: &'static str,
    pub(super) words: &'static str,
    folder: &'static str,
    /// File names and contents; the first is the shot.
    files: &'static [(&'static str, &'static [u8])],
}

macro_rules! bundled {
    ($folder:literal, $title:literal, $words:literal, $($file:literal),*) => {
        Bundled {
            title: $title,
            words: $words,
            folder: $folder,
            files: &[$(($file, include_bytes!(concat!("../../../scenes/", $folder, "/", $file)))),*],
        }
    };
}

/// All bundled scenes.
pub(super) const BUNDLED: [Bundled; 6] = [
    bundled!("walker", "Walking gnome", "animated, three layers", "shot.toml", "walker.glb"),
    bundled!("gingerman", "Gingerman", "a pose, one layer", "shot.toml", "gingerman.glb"),
    bundled!("teapot", "Teapot", "squash and stretch", "shot.toml", "teapot.glb"),
    bundled!("hare", "Hare on a turntable", "a lattice in the scene", "shot.toml", "hare.glb"),
    bundled!("cat", "Cat", "a drawing", "shot.toml", "cat.png"),
    bundled!("flag", "Flag", "two drawings", "shot.toml", "flag.png", "pole.png"),
];

impl Bundled {
    /// Returns the path of its shot in the folder that it is unpacked into.
    pub(super) fn shot(&self, scenes: &Path) -> PathBuf {
        scenes.join(self.folder).join(self.files[0].0)
    }

    /// Unpacks a copy into a folder, unless one exists; returns the path of its shot.
    pub(super) fn unpack(&self, scenes: &Path) -> Result<PathBuf, EditError> {
        let folder = scenes.join(self.folder);
        let io = |source| EditError::Io { path: folder.clone(), source };
        std::fs::create_dir_all(&folder).map_err(io)?;
        for (name, bytes) in self.files {
            let path = folder.join(name);
            if path.exists() {
                continue;
            }
            match std::str::from_utf8(bytes) {
                Ok(text) => replace_text(&path, text)?,
                Err(_) => replace_bytes(&*path, bytes)?,
            }
        }
        Ok(self.shot(scenes))
    }
}
