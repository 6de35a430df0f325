//! Validates shots that show pictures instead of a model.
//!
//! In: the raw key `image`. Out: paths.

use super::Check;
use crate::image::{PictureKind, SequencePath};
use crate::shot::raw::{RawImage, RawLayer, RawSpace};
use std::path::{Path, PathBuf};

impl Check<'_> {
    /// Returns the resolved paths of the pictures.
    pub(super) fn images(&mut self, raw: &RawImage) -> Vec<PathBuf> {
        let paths = raw.paths();
        for (index, (key, path)) in paths.iter().enumerate() {
            let is_sequence = SequencePath::of_input(&self.folder().join(path)).is_ok_and(|path| path.has_counter());
            if PictureKind::of(Path::new(path)).is_none() {
                let hint = format!("{}; a .gltf or .glb file is a `scene`", PictureKind::REMEDY);
                self.fault(key, format!("{path:?} is not the name of a picture"), hint);
            } else if is_sequence {
                let hint = "write `plate` instead, give its layer `matte = \"alpha\"`, and run `pinwarp warp`";
                self.fault(key, "pictures of a shot are single images, but this is a sequence", hint);
            } else if paths[..index].iter().any(|(_, other)| other == path) {
                self.fault(key, format!("{path:?} is listed twice"), "remove one of them, or copy the file");
            }
        }
        paths.iter().map(|(_, path)| self.folder().join(path)).collect()
    }

    /// Rejects world-space lattices for pictures.
    pub(super) fn image_layer(&mut self, raw: &RawLayer, key: &str) {
        if raw.lattice.space == RawSpace::World {
            let hint = "remove it, or give a `scene` instead of pictures";
            self.fault(&format!("{key}.lattice.space"), "pictures are flat and are warped on the screen", hint);
        }
    }
}
