//! Plates for quick drafts: decoded once, with the channels that viewers show, in the size of the draft.
//!
//! In: the file of a plate, the sizes of the frame and of the draft. Out: a [`Plate`].

use super::recent::Recent;
use crate::image::{Channel, Frame, ImageError, Plate, read_any};
use crate::plate::{Planes, scaled};
use crate::space::FrameSize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Channels that viewers show.
const SHOWN: [&str; 4] = ["R", "G", "B", "A"];

/// The most recent plates.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct PlateDrafts(Recent<Key, Plate>);

/// A file as it was read, and the sizes of frame and draft.
#[derive(Debug, PartialEq)]
struct Key {
    path: PathBuf,
    written: Option<SystemTime>,
    bytes: Option<u64>,
    sizes: [FrameSize; 2],
}

impl PlateDrafts {
    /// Returns a plate, smaller than its file by the ratio of the sizes of draft and frame.
    ///
    /// # Errors
    /// [`ImageError`] if the file cannot be read.
    pub(in crate::pipeline) fn of(
        &self,
        path: &Path,
        [frame, draft]: [FrameSize; 2],
    ) -> Result<Arc<Plate>, ImageError> {
        let file = path.metadata().ok();
        let written = file.as_ref().and_then(|file| file.modified().ok());
        let bytes = file.map(|file| file.len());
        let key = Key { path: path.to_owned(), written, bytes, sizes: [frame, draft] };
        self.0.try_of(key, || Ok(shown(read_any(path)?, [frame, draft])))
    }
}

/// Returns the channels of a plate that viewers show, scaled by the ratio of two frame sizes.
fn shown(plate: Plate, [frame, draft]: [FrameSize; 2]) -> Plate {
    let from = plate.frame_size();
    let side = |own: u32, frame: u32, draft: u32| {
        let side = f64::from(own) * f64::from(draft) / f64::from(frame.max(1));
        (side.round() as u32).clamp(1, own.max(1))
    };
    let to = FrameSize {
        width: side(from.width, frame.width, draft.width),
        height: side(from.height, frame.height, draft.height),
        ..from
    };
    let mut whole = plate.into_frame();
    whole.channels.retain(|channel| SHOWN.contains(&&*channel.name));
    if to == from {
        return Plate::from_frame(whole);
    }
    let window = whole.data_window.relative_to(whole.display);
    let planes = whole.channels.iter().map(|channel| channel.samples.as_slice()).collect();
    let (data_window, planes) = scaled(&Planes { window, planes }, from, to);
    let channels = whole.channels.iter().zip(planes);
    let channels = channels.map(|(Channel { name, storage, .. }, samples)| Channel {
        name: name.clone(),
        storage: *storage,
        samples,
    });
    Plate::from_frame(Frame {
        display: to.window(),
        data_window,
        pixel_aspect: whole.pixel_aspect,
        channels: channels.collect(),
    })
}
