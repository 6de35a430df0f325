//! Plates for quick drafts: decoded once, with the channels that viewers show and the mattes of the layers, in the size of
//! the draft.
//!
//! In: the file of a plate, its layers, the sizes of the frame and of the draft. Out: a [`PlateDraft`].

use super::recent::Recent;
use crate::image::{Channel, Frame, Plate, read_any};
use crate::pipeline::PipelineError;
use crate::plate::{LayerJob, Matte, Planes, Semantic, WarpSettings, scaled, scaled_matte};
use crate::space::FrameSize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Channels that viewers show.
const SHOWN: [&str; 4] = ["R", "G", "B", "A"];

/// A plate in the size of a draft.
#[derive(Debug)]
pub(in crate::pipeline) struct PlateDraft {
    pub(in crate::pipeline) plate: Plate,
    /// The matte of each layer.
    pub(in crate::pipeline) mattes: Vec<Option<Matte>>,
}

/// The most recent plates.
#[derive(Debug, Default)]
pub(in crate::pipeline) struct PlateDrafts(Recent<Key, PlateDraft>);

/// What a draft depends on: a file as it was read, the sizes of frame and draft, the mattes and how channels are understood.
#[derive(Debug, PartialEq)]
struct Key {
    path: PathBuf,
    written: Option<SystemTime>,
    bytes: Option<u64>,
    sizes: [FrameSize; 2],
    mattes: Vec<Option<Matte>>,
    semantics: Vec<(String, Semantic)>,
}

impl PlateDrafts {
    /// Returns a plate and the mattes of its layers, smaller than the file by the ratio of the sizes of draft and frame.
    ///
    /// # Errors
    /// [`PipelineError`] if the file cannot be read, or lacks what a matte refers to.
    pub(in crate::pipeline) fn of(
        &self,
        path: &Path,
        (layers, settings): (&[LayerJob], &WarpSettings),
        [frame, draft]: [FrameSize; 2],
    ) -> Result<Arc<PlateDraft>, PipelineError> {
        let file = path.metadata().ok();
        let key = Key {
            path: path.to_owned(),
            written: file.as_ref().and_then(|file| file.modified().ok()),
            bytes: file.map(|file| file.len()),
            sizes: [frame, draft],
            mattes: layers.iter().map(|layer| layer.matte.clone()).collect(),
            semantics: settings.semantics.clone(),
        };
        self.0.try_of(key, || {
            let plate = read_any(path)?;
            let to = small_size(plate.frame_size(), [frame, draft]);
            let matte = |layer: &LayerJob| {
                let named = (layer.name.as_str(), layer.matte.as_ref()?);
                Some(scaled_matte(&plate, named, settings, to))
            };
            let mattes = layers.iter().map(|layer| matte(layer).transpose()).collect::<Result<_, _>>()?;
            Ok(PlateDraft { mattes, plate: shown(plate, to) })
        })
    }
}

/// Returns a plate's size, smaller by the ratio of two frame sizes.
fn small_size(from: FrameSize, [frame, draft]: [FrameSize; 2]) -> FrameSize {
    let side = |own: u32, frame: u32, draft: u32| {
        let side = f64::from(own) * f64::from(draft) / f64::from(frame.max(1));
        (side.round() as u32).clamp(1, own.max(1))
    };
    FrameSize {
        width: side(from.width, frame.width, draft.width),
        height: side(from.height, frame.height, draft.height),
        ..from
    }
}

/// Returns the channels of a plate that viewers show, in another size.
fn shown(plate: Plate, to: FrameSize) -> Plate {
    let from = plate.frame_size();
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
