//! Extracts the pictures of a file: colour and alpha, ready to be warped.
//!
//! In: a plate. Out: a [`FlatPicture`] for each of its colour layers, as a plate of its own.

use crate::image::{Channel, Frame, Plate, PlatePart, Storage};
use crate::pipeline::PipelineError;
use crate::plate::{ColorLayer, Planes, color_layers, scaled};
use crate::scene::Picture;
use crate::shot::Shot;
use crate::space::{FrameSize, FrameWindow, PixelRect};
use std::path::{Path, PathBuf};

/// The channels of a picture, in order.
pub(super) const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// A flat picture.
#[derive(Clone, Debug)]
pub(super) struct FlatPicture {
    pub(super) path: PathBuf,
    pub(super) name: String,
    /// [`CHANNELS`], premultiplied, in one part; the display window begins at 0, 0.
    pub(super) plate: Plate,
    /// Whether the file has an alpha channel for the picture.
    has_alpha: bool,
    /// Half float if all colour channels are, otherwise full float.
    pub(super) storage: Storage,
}

/// Returns all pictures of a plate, in the order of its parts and channels, and a list of what is left out.
///
/// Pictures in channels `R`, `G`, `B`, `A` (or luminance `Y`) are named after the file, or after their part; a picture
/// in `hair.R` and so on is named `hair`.
pub(super) fn flat_pictures(
    shot: &Shot,
    path: &Path,
    plate: &Plate,
) -> Result<(Vec<FlatPicture>, Vec<String>), PipelineError> {
    let stem = path.file_stem().map_or_else(|| "picture".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let has_parts = plate.parts.len() > 1;
    let (layers, left_out) = color_layers(plate, &shot.warp.semantics);
    if layers.is_empty() {
        let what = format!("{} has no channels R, G, B or Y that hold colour", path.display());
        let hint = "give a file that holds colour, or say in [[warp.channels]] which channels do";
        return Err(PipelineError::mismatch(shot, "image", what, hint));
    }
    let flat_pictures = layers.into_iter().map(|ColorLayer { part, name, channels }| {
        let own = || part.name.clone().filter(|_| has_parts).unwrap_or_else(|| stem.clone());
        let name = if name.is_empty() { own() } else { name };
        flat_picture((path, name), (plate, part), channels)
    });
    Ok((flat_pictures.collect(), left_out))
}

/// Builds the picture of a part. Missing colour channels are 0, a missing alpha is 1.
fn flat_picture(
    (path, name): (&Path, String),
    (plate, part): (&Plate, &PlatePart),
    channels: [Option<&Channel>; 4],
) -> FlatPicture {
    let is_half = channels[..3].iter().flatten().all(|channel| channel.storage == Storage::Half);
    let plane = |(channel, missing): (Option<&Channel>, f32)| {
        channel.map_or_else(|| vec![missing; part.data_window.area()], |channel| channel.samples.clone())
    };
    let planes = channels.into_iter().zip([0.0, 0.0, 0.0, 1.0]).map(plane);
    FlatPicture {
        path: path.to_owned(),
        name,
        plate: pictured(plate.frame_size(), plate.window_of(part), planes),
        has_alpha: channels[3].is_some(),
        storage: if is_half { Storage::Half } else { Storage::Float },
    }
}

/// Builds a plate from [`CHANNELS`].
pub(super) fn pictured(frame: FrameSize, window: PixelRect, planes: impl IntoIterator<Item = Vec<f32>>) -> Plate {
    plate_of(FrameWindow { frame, window }, CHANNELS.into_iter().zip(planes))
}

/// Builds a plate from named planes.
pub(super) fn plate_of<'a>(
    FrameWindow { frame, window: data_window }: FrameWindow,
    named: impl IntoIterator<Item = (&'a str, Vec<f32>)>,
) -> Plate {
    let channels =
        named.into_iter().map(|(name, samples)| Channel { name: name.to_owned(), storage: Storage::Float, samples });
    let (display, pixel_aspect) = (frame.window(), frame.pixel_aspect);
    Plate::from_frame(Frame { display, data_window, pixel_aspect, channels: channels.collect() })
}

impl FlatPicture {
    /// Returns the outline data of the picture for the scene.
    pub(super) fn picture(&self) -> Picture<'_> {
        let part = self.part();
        let alpha = self.has_alpha.then_some(part.channels[3].samples.as_slice());
        Picture { path: self.path.clone(), name: self.name.clone(), window: part.data_window, alpha }
    }

    /// Returns the window of stored pixels.
    pub(super) fn window(&self) -> PixelRect {
        self.part().data_window
    }

    /// Returns the samples of [`CHANNELS`], each #pixels of the window.
    pub(super) fn planes(&self) -> impl Iterator<Item = &[f32]> {
        self.part().channels.iter().map(|channel| channel.samples.as_slice())
    }

    /// Returns the coverage of every pixel.
    pub(super) fn alpha(&self) -> &[f32] {
        &self.part().channels[3].samples
    }

    /// Returns the part that holds the channels.
    fn part(&self) -> &PlatePart {
        self.plate.parts.first().expect("a flat_picture is made of one part")
    }

    /// Returns an empty picture that keeps the index and name of this one.
    #[cfg(any(test, feature = "cli"))]
    pub(super) fn blank(&self) -> Self {
        let nowhere = PixelRect { width: 0, height: 0, ..self.part().data_window };
        let plate = pictured(self.plate.frame_size(), nowhere, [const { Vec::new() }; 4]);
        Self { path: self.path.clone(), name: self.name.clone(), plate, ..*self }
    }

    /// Resamples the picture to another frame size, with a filter as wide as the larger of source and destination pixels.
    pub(super) fn scaled(&self, from: FrameSize, to: FrameSize) -> Self {
        let part = self.part();
        let planes = part.channels.iter().map(|channel| channel.samples.as_slice()).collect();
        let (window, planes) = scaled(&Planes { window: part.data_window, planes }, from, to);
        Self { path: self.path.clone(), name: self.name.clone(), plate: pictured(to, window, planes), ..*self }
    }
}
