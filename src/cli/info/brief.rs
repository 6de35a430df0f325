//! Summaries of shots and lattice files.
//!
//! In: their paths. Out: their contents by name and count.

use super::Lines;
use crate::export::{LatticeFile, Track};
use crate::shot::{CameraRule, LayerSpace, Shot, Source};
use crate::spelling::pluralised;
use serde::Serialize;
use std::path::{Path, PathBuf};

#[derive(Serialize)]
pub(super) struct ShotInfo {
    kind: &'static str,
    file: PathBuf,
    scene: Option<PathBuf>,
    images: Vec<PathBuf>,
    plate: Option<PathBuf>,
    camera: String,
    /// First and last frame.
    frames: [i32; 2],
    rate: f64,
    size: [u32; 2],
    layers: Vec<LayerInfo>,
    output: PathBuf,
}

#[derive(Serialize)]
struct LayerInfo {
    name: String,
    space: &'static str,
    /// Handles per axis.
    dims: [usize; 3],
    pins: usize,
    handles: usize,
}

impl ShotInfo {
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let shot = Shot::read(path)?;
        let layers = shot.layers.iter().map(|layer| LayerInfo {
            name: layer.name.clone(),
            space: if matches!(layer.space, LayerSpace::Screen { .. }) { "screen" } else { "world" },
            dims: layer.space.dims(),
            pins: layer.pins.len(),
            handles: layer.handles.len(),
        });
        Ok(Self {
            kind: "shot",
            file: path.to_owned(),
            scene: shot.scene().map(Path::to_owned),
            images: if let Source::Images(images) = &shot.source { images.clone() } else { Vec::new() },
            plate: shot.plate.clone(),
            camera: match &shot.camera {
                CameraRule::Automatic => "the scene's first".to_owned(),
                CameraRule::Named(name) => name.clone(),
                CameraRule::Own(camera) => format!("its own, {}", pluralised(camera.keys.len(), "key", "keys")),
            },
            frames: [shot.frames.first, shot.frames.last],
            rate: shot.frames.rate,
            size: [shot.size.width, shot.size.height],
            layers: layers.collect(),
            output: shot.output.path,
        })
    }
}

impl Lines for ShotInfo {
    fn lines(&self) -> Vec<String> {
        let [first, last] = self.frames;
        let [width, height] = self.size;
        let rate = self.rate;
        let mut out =
            vec![format!("{}: frames {first} to {last} at {rate} fps, {width} x {height}", self.file.display())];
        out.extend(self.scene.iter().map(|scene| format!("scene: {}", scene.display())));
        out.extend(self.images.iter().map(|image| format!("image: {}", image.display())));
        out.extend(self.plate.iter().map(|plate| format!("plate: {}", plate.display())));
        if self.scene.is_some() {
            out.push(format!("camera: {}", self.camera));
        }
        for LayerInfo { name, space, dims: [x, y, z], pins, handles } in &self.layers {
            let pins = pluralised(*pins, "pin", "pins");
            let handles = pluralised(*handles, "moved handle", "moved handles");
            out.push(format!("layer {name}: {space} lattice of {x} x {y} x {z} handles, {pins}, {handles}"));
        }
        out.push(format!("output: {}", self.output.display()));
        out
    }
}

#[derive(Serialize)]
pub(super) struct LatticeInfo {
    kind: &'static str,
    file: PathBuf,
    frame_aspect: f64,
    rate: f64,
    layers: Vec<TrackInfo>,
}

#[derive(Serialize)]
struct TrackInfo {
    name: String,
    space: &'static str,
    /// First and last frame.
    frames: Option<[i32; 2]>,
    lattices: usize,
}

impl LatticeInfo {
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let file = LatticeFile::read(path)?;
        let layers = file.layers.iter().map(|layer| {
            let (space, frames): (_, Vec<i32>) = match &layer.track {
                Track::Screen(lattices) => ("screen", lattices.keys().copied().collect()),
                Track::World(lattices) => ("world", lattices.keys().copied().collect()),
            };
            let ends = frames.first().zip(frames.last()).map(|(first, last)| [*first, *last]);
            TrackInfo { name: layer.name.clone(), space, frames: ends, lattices: frames.len() }
        });
        let layers = layers.collect();
        Ok(Self { kind: "lattices", file: path.to_owned(), frame_aspect: file.frame_aspect, rate: file.rate, layers })
    }
}

impl Lines for LatticeInfo {
    fn lines(&self) -> Vec<String> {
        let mut out =
            vec![format!("{}: frame aspect {:.4}, {} fps", self.file.display(), self.frame_aspect, self.rate)];
        for TrackInfo { name, space, frames, lattices } in &self.layers {
            let frames = frames.map(|[first, last]| format!(", frames {first} to {last}")).unwrap_or_default();
            out.push(format!("layer {name}: {} of the {space}{frames}", pluralised(*lattices, "lattice", "lattices")));
        }
        out
    }
}
