//! Validates shots that show pictures instead of a model.
//!
//! In: the raw key `image`. Out: paths, and the frame size if the shot does not set it.

use super::Check;
use crate::image::{PictureKind, SequencePath, picture_size};
use crate::shot::raw::{RawImage, RawLayer, RawShot, RawSpace};
use crate::space::FrameSize;
use std::path::{Path, PathBuf};

/// Default frame size.
const DEFAULT_SIZE: [u32; 2] = [1920, 1080];

impl Check<'_> {
    /// Returns the resolved paths of the pictures.
    pub(super) fn images(&mut self, raw: &RawImage) -> Vec<PathBuf> {
        let paths = raw.paths();
        for (index, (key, path)) in paths.iter().enumerate() {
            let is_sequence = SequencePath::parse(Path::new(path)).is_ok_and(|path| path.has_counter());
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

    /// Returns the frame size: the shot's, else that of its first picture.
    pub(super) fn size(&mut self, raw: &RawShot, images: Option<&[PathBuf]>) -> FrameSize {
        let aspect = raw.pixel_aspect.unwrap_or(1.0);
        let framed = |[width, height]: [u32; 2]| FrameSize { width, height, pixel_aspect: aspect };
        let Some(first) = images.and_then(<[_]>::first).filter(|_| raw.size.is_none()) else {
            return framed(raw.size.unwrap_or(DEFAULT_SIZE));
        };
        match picture_size(first) {
            Ok(size) => FrameSize { pixel_aspect: raw.pixel_aspect.unwrap_or(size.pixel_aspect), ..size },
            Err(error) => {
                let hint = "the size of the frame is that of the first picture; mend its path, or give `size`";
                self.fault("image", error.to_string(), hint);
                framed(DEFAULT_SIZE)
            }
        }
    }

    /// Rejects world-space lattices for pictures.
    pub(super) fn image_layer(&mut self, raw: &RawLayer, key: &str) {
        if raw.lattice.space == RawSpace::World {
            let hint = "remove it, or give a `scene` instead of pictures";
            self.fault(&format!("{key}.lattice.space"), "pictures are flat and are warped on the screen", hint);
        }
    }
}
