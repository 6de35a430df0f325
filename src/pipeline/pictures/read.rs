//! One picture of a file: its colour and alpha, ready to be warped.
//!
//! In: a plate. Out: a [`Sheet`] for each of its layers that has colour.

use super::super::PipelineError;
use crate::image::{Channel, Plate, PlatePart, Storage};
use crate::plate::{Filter, Planes, WarpMap, resampled};
use crate::scene::Picture;
use crate::shot::Shot;
use crate::space::{FrameSize, PixelRect};
use std::path::{Path, PathBuf};

/// A flat picture, in the space of its display window.
#[derive(Clone, Debug)]
pub(super) struct Sheet {
    pub(super) path: PathBuf,
    pub(super) name: String,
    /// The pixels that are stored, relative to the display window.
    pub(super) window: PixelRect,
    /// R, G, B and A, associated, each #pixels of the window.
    pub(super) planes: [Vec<f32>; 4],
    /// The picture has an alpha of its own.
    has_alpha: bool,
    /// The finest of its channels.
    pub(super) storage: Storage,
}

/// All pictures of a plate, in the order of its parts and channels: channels `R`, `G`, `B`, `A` (or grey `Y`) are named
/// after the file, or their part; `hair.R` and so on are `hair`.
pub(super) fn sheets(shot: &Shot, path: &Path, plate: Plate) -> Result<Vec<Sheet>, PipelineError> {
    let stem = path.file_stem().map_or_else(|| "picture".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let has_parts = plate.parts.len() > 1;
    let mut sheets = Vec::new();
    for part in &plate.parts {
        let own = part.name.clone().filter(|_| has_parts).unwrap_or_else(|| stem.clone());
        let mut layers: Vec<&str> = Vec::new();
        for (layer, _) in part.channels.iter().map(|channel| split(&channel.name)) {
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        }
        sheets.extend(layers.into_iter().filter_map(|layer| sheet(part, layer)).map(|sheet| Sheet {
            path: path.to_owned(),
            name: if sheet.name.is_empty() { own.clone() } else { sheet.name.clone() },
            window: PixelRect {
                x: part.data_window.x - plate.display.x,
                y: part.data_window.y - plate.display.y,
                ..part.data_window
            },
            ..sheet
        }));
    }
    if sheets.is_empty() {
        let what = format!("{} has no channels R, G, B or Y", path.display());
        return Err(PipelineError::mismatch(shot, "image", what, "give a file that holds colour"));
    }
    Ok(sheets)
}

/// Layer and channel: `hair.R` is `R` of `hair`, `R` is of no layer.
fn split(name: &str) -> (&str, &str) {
    name.rsplit_once('.').unwrap_or(("", name))
}

/// The colour of a layer; `None` where it has none.
fn sheet(part: &PlatePart, layer: &str) -> Option<Sheet> {
    let channel = |wanted: &str| part.channels.iter().find(|channel| split(&channel.name) == (layer, wanted));
    let grey = channel("Y");
    let colour = ["R", "G", "B"].map(|name| channel(name).or(grey));
    let alpha = channel("A");
    if colour.iter().all(Option::is_none) {
        return None;
    }
    let plane = |of: Option<&Channel>, value: f32| {
        of.map_or_else(|| vec![value; part.data_window.area()], |channel| channel.samples.clone())
    };
    let is_half = colour.iter().flatten().all(|channel| channel.storage == Storage::Half);
    Some(Sheet {
        path: PathBuf::new(),
        name: layer.to_owned(),
        window: part.data_window,
        planes: [plane(colour[0], 0.0), plane(colour[1], 0.0), plane(colour[2], 0.0), plane(alpha, 1.0)],
        has_alpha: alpha.is_some(),
        storage: if is_half { Storage::Half } else { Storage::Float },
    })
}

impl Sheet {
    /// What it covers, for the scene.
    pub(super) fn picture(&self) -> Picture<'_> {
        let alpha = self.has_alpha.then_some(self.planes[3].as_slice());
        Picture { path: self.path.clone(), name: self.name.clone(), window: self.window, alpha }
    }

    /// Its samples, for filters.
    pub(super) fn samples(&self) -> Planes<'_> {
        Planes { window: self.window, planes: self.planes.iter().map(Vec::as_slice).collect() }
    }

    /// The same picture with other pixels: a filter as wide as they are where they are larger.
    pub(super) fn scaled(&self, from: FrameSize, to: FrameSize) -> Self {
        let factor = [f64::from(from.width) / f64::from(to.width), f64::from(from.height) / f64::from(to.height)];
        let along = |start: i32, length: u32, factor: f64| {
            let end = (f64::from(start) + f64::from(length)) / factor;
            let start = (f64::from(start) / factor).floor();
            (start as i32, (end.ceil() - start).max(0.0) as u32)
        };
        let (x, width) = along(self.window.x, self.window.width, factor[0]);
        let (y, height) = along(self.window.y, self.window.height, factor[1]);
        let window = PixelRect { x, y, width, height };
        // In the map's own pixels: the source of pixel (i, j) lies at ((i + .5) fx, (j + .5) fy).
        let mut map = WarpMap::identity(from, window);
        for (index, offset) in map.offsets.iter_mut().enumerate() {
            let place = [x + (index % width as usize) as i32, y + (index / width as usize) as i32];
            *offset = [0, 1].map(|axis| ((f64::from(place[axis]) + 0.5) * (factor[axis] - 1.0)) as f32);
        }
        let planes = resampled(&map, &self.samples(), Filter::Ewa);
        let planes = <[Vec<f32>; 4]>::try_from(planes).expect("a plane comes out for each that goes in");
        Self { path: self.path.clone(), name: self.name.clone(), window, planes, ..*self }
    }
}
