//! The source of the shape that a warp preserves.
//!
//! In: the host's choice. Out: its content as a [`Key`].

use super::LiveError;
use super::key::{Key, KeyWriter};
use super::process_cache::CACHE;
use crate::scene::files_beside;
use crate::shot::Shot;
use crate::space::{FrameSize, PixelRect};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::UNIX_EPOCH;

/// What the lattice is laid over, and whose shape the warp preserves.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSource<'a> {
    /// The whole frame, as one flat card.
    Frame,
    /// A picture that covers all of its window, in pixels of the frame.
    Window(PixelRect),
    /// The visible part of a picture, by its alpha.
    Coverage(Coverage<'a>),
    /// The animated model of a shot file: the lattice follows it, and pins stick to it.
    Shot(ShotShape),
}

/// The alpha of the whole picture; hosts that render in tiles pass all of it for every tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage<'a> {
    /// Window in image space, in pixels of the frame passed to [`warp`](super::warp).
    pub window: PixelRect,
    /// `window.area()` samples, rows from the top.
    pub alpha: &'a [f32],
}

/// A shot file, and how it is evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotShape {
    /// The shot file (`.toml`).
    pub path: PathBuf,
    /// Node name of the camera; `None`: the camera of the shot.
    pub camera: Option<String>,
    /// The layer that the pins belong to; `None`: the first layer in screen space.
    pub layer: Option<String>,
    /// The current frame; may be fractional.
    pub frame: f64,
    /// The frame in which [`Pin::rest`](super::Pin::rest) is measured: pins are cast onto the surface visible in that
    /// frame, and follow it. A pin that hits nothing stays fixed on the screen, and the report says so.
    pub pin_frame: i32,
    /// How the file's own pins are treated.
    pub own_pins: OwnPins,
}

/// How a shot's own pins are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OwnPins {
    /// They act together with the host's pins.
    #[default]
    Act,
    /// They are ignored, because the host has read them into its parameters.
    LeftOut,
}

impl ShapeSource<'_> {
    /// Hashes everything that the scene of the shape depends on.
    ///
    /// # Errors
    /// [`LiveError`] if a shot file cannot be read.
    pub(super) fn key(&self, frame: FrameSize) -> Result<Key, LiveError> {
        let mut key = KeyWriter::new();
        match self {
            Self::Frame => _ = key.word(0).float(frame.aspect()),
            Self::Window(window) => {
                let sides = [window.x as u64, window.y as u64, window.width.into(), window.height.into()];
                key.word(3).words(&sides).words(&[
                    frame.width.into(),
                    frame.height.into(),
                    frame.pixel_aspect.to_bits(),
                ]);
            }
            Self::Coverage(Coverage { window, alpha }) => {
                let sides = [window.x as u64, window.y as u64, window.width.into(), window.height.into()];
                let size = [frame.width.into(), frame.height.into(), frame.pixel_aspect.to_bits()];
                key.word(1).words(&sides).words(&size).samples(alpha);
            }
            Self::Shot(shot) => {
                key.word(2);
                write_file(&mut key, &shot.path);
                let read = read(&shot.path)?;
                read.files().for_each(|path| write_file(&mut key, path));
                if let Some(scene) = read.scene() {
                    beside(scene)?.iter().for_each(|path| write_file(&mut key, path));
                }
                for name in [&shot.camera, &shot.layer] {
                    key.word(name.is_some().into()).text(name.as_deref().unwrap_or_default());
                }
            }
        }
        Ok(key.finish())
    }
}

/// Reads a shot file, cached until the file changes.
pub(super) fn read(path: &Path) -> Result<Arc<Shot>, LiveError> {
    CACHE.shots.get(file_key(path), || Ok(Shot::read(path)?))
}

/// Returns the buffer and image files of a scene, cached until its file changes.
fn beside(scene: &Path) -> Result<Arc<Vec<PathBuf>>, LiveError> {
    CACHE.files_beside.get(file_key(scene), || Ok(files_beside(scene)?))
}

fn file_key(path: &Path) -> Key {
    let mut key = KeyWriter::new();
    write_file(&mut key, path);
    key.finish()
}

/// Hashes a file by its path, time and length, so that a saved file gets a new key. A missing file has neither time nor length.
fn write_file(key: &mut KeyWriter, path: &Path) {
    let state = std::fs::metadata(path).ok();
    let changed = state.as_ref().and_then(|state| state.modified().ok());
    let since = changed.and_then(|changed| changed.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    key.text(&path.to_string_lossy()).word(since.as_secs()).word(since.subsec_nanos().into());
    key.word(state.map_or(u64::MAX, |state| state.len()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shots_and_what_lies_beside_scenes_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let [scene, shot] = ["scene.gltf", "shot.toml"].map(|name| folder.path().join(name));
        let text = r#"{ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 36, "uri": "points.bin" }] }"#;
        std::fs::write(&scene, text).expect("written");
        let text = "version = 1\nscene = \"scene.gltf\"\nframes = { first = 1, last = 1 }\nsize = [16, 9]\n";
        std::fs::write(&shot, text).expect("written");
        assert_eq!(*beside(&scene).expect("a scene"), [folder.path().join("points.bin")]);
        read(&shot).expect("a shot");
        let kept =
            || (CACHE.files_beside.peek(file_key(&scene)).is_some(), CACHE.shots.peek(file_key(&shot)).is_some());
        assert_eq!(kept(), (true, true));
    }
}
