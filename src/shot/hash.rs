//! A hash of a shot, for the metadata of its frames.
//!
//! In: a [`Shot`]. Out: hexadecimal text, independent of comments, formatting and folders.

use super::{Cut, KeyLines, Layer, Shot, Source};
use crate::plate::Holes;
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

impl Shot {
    /// Returns 32 hexadecimal digits over everything that affects the frames. Excluded are the name and folder of the
    /// shot file, the output path, and the contents of the scene file.
    #[must_use]
    pub(crate) fn hash(&self) -> String {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let mut content = self.clone();
        match &mut content.source {
            Source::Scene(scene) => *scene = portable(scene, folder),
            Source::Images(images) => images.iter_mut().for_each(|image| *image = portable(image, folder)),
            Source::Frame => {}
        }
        content.plate = content.plate.map(|plate| portable(&plate, folder));
        content.layers.iter_mut().filter_map(|layer| layer.transfer.as_mut()).for_each(|transfer| {
            transfer.file = portable(&transfer.file, folder);
        });
        for Layer { selection, connectivity, .. } in &mut content.layers {
            let masks = selection.mask.iter_mut().map(|mask| &mut mask.file);
            for file in connectivity.cuts.iter_mut().filter_map(Cut::file_mut).chain(masks) {
                *file = portable(file, folder);
            }
        }
        if let Holes::Plate(clean) = &mut content.warp.holes {
            *clean = portable(clean, folder);
        }
        content.path = PathBuf::new();
        content.lines = KeyLines::default();
        content.output.path = PathBuf::new();
        // The derived `Debug` text contains every field, with all digits of floats.
        digest(&format!("{content:?}"))
    }
}

/// Returns 32 hexadecimal digits over a text.
#[must_use]
pub(crate) fn digest(text: &str) -> String {
    format!("{:032x}", XxHash3_128::oneshot(text.as_bytes()))
}

/// Returns a path relative to the shot, with `/` separators; outside its folder only the file name counts.
fn portable(path: &Path, folder: &Path) -> PathBuf {
    match path.strip_prefix(folder) {
        Ok(relative) if !relative.is_absolute() => relative.to_string_lossy().replace('\\', "/").into(),
        _ => path.file_name().map(PathBuf::from).unwrap_or_default(),
    }
}
