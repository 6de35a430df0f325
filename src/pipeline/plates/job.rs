//! What a warp of finished frames is asked to do, and what it tells while it does.

use super::super::events::lossy;
use super::super::{Existing, PreparedShot, Redone};
use crate::export::LatticeFile;
use crate::image::Durability;
use crate::plate::{ChannelReport, Matte, WarpSettings};
use crate::raster::DeviceChoice;
use serde::Serialize;
use std::path::PathBuf;

/// Finished frames, what warps them, and where they go.
#[derive(Debug)]
pub struct WarpJob<'a> {
    /// The frames: a path with a counter, or one picture that holds for all frames. EXR, PNG or JPEG files.
    pub plate: PathBuf,
    /// Where they go: EXR files, or PNG files where the plate is PNG or JPEG.
    pub output: PathBuf,
    /// What warps them.
    pub warp: PlateWarp<'a>,
    /// Filter, semantics, motion, holes.
    pub settings: WarpSettings,
    /// There, or back again.
    pub direction: WarpDirection,
    /// Layers that warp, by name; empty: all.
    pub layers: Vec<String>,
    /// Frames in the order wanted; empty: the shot's range, else the frames that are there.
    pub frames: Vec<i32>,
    /// What happens to frames that are already there.
    pub existing: Existing,
    /// What resamples colour, and draws the scene that fills holes.
    pub device: DeviceChoice,
    /// When a frame counts as written.
    pub durability: Durability,
    /// Files that were read for the job beside those that it names, such as the lattice file: no frame is written over them.
    pub inputs: Vec<PathBuf>,
}

/// What warps plates.
#[derive(Debug)]
pub enum PlateWarp<'a> {
    /// The layers of a shot, solved at every frame.
    Shot(&'a PreparedShot),
    /// Lattices that were solved before.
    Lattices {
        /// All their layers of the screen.
        file: LatticeFile,
        /// Scales how far they move.
        strength: f64,
        /// The part of the plate that they move; `None`: the whole picture.
        matte: Option<Matte>,
    },
    /// STMaps: a picture, or a sequence with a counter.
    Maps(PathBuf),
}

impl PlateWarp<'_> {
    /// Name and matte of a layer, by its place in the shot or file.
    pub(super) fn layer(&self, index: usize) -> (&str, Option<&Matte>) {
        match self {
            Self::Shot(prepared) => {
                let layer = &prepared.shot.layers[index];
                (&layer.name, layer.matte.as_ref())
            }
            Self::Lattices { file, matte, .. } => (&file.layers[index].name, matte.as_ref()),
            Self::Maps(_) => ("", None),
        }
    }
}

/// There, or back again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarpDirection {
    /// As the pins say.
    #[default]
    Forward,
    /// The warp is undone, where it is one-to-one.
    Inverse,
}

/// What a warp tells while it runs.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum WarpEvent {
    /// Warping begins.
    Started {
        /// Frames to warp.
        frames: usize,
        /// Frames kept from an earlier run.
        kept: usize,
    },
    /// Something the user should know about the job as a whole.
    Note {
        /// In words.
        text: String,
    },
    /// A frame is there, but not as this run would write it: it is made again. One event for each, before `started`.
    FrameRedone(Redone),
    /// A frame is on disk.
    FrameDone(WarpReport),
    /// A frame could not be made; the others go on.
    FrameFailed {
        /// Which.
        frame: i32,
        /// Why.
        error: String,
    },
    /// All frames were tried.
    Finished(WarpSummary),
}

/// What became of a plate.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WarpReport {
    /// Frame number.
    pub frame: i32,
    /// The file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Milliseconds spent in reading and decoding.
    pub read_ms: f64,
    /// Milliseconds spent in solving and warping.
    pub warp_ms: f64,
    /// Milliseconds spent in encoding and writing.
    pub write_ms: f64,
    /// What resampled colour: `CPU`, or the name of a device.
    pub device: String,
    /// Pixels that a layer left and nothing covers; filled ones are counted, too.
    pub hole_pixels: usize,
    /// Pixels where a layer lies over itself; its front is seen, and the warp cannot be undone there. STMaps do not tell.
    pub folded_pixels: usize,
    /// Samples of colour that were no number or infinite.
    pub contained_samples: usize,
    /// What every channel was taken for; only where it differs from the frame before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<ChannelReport>,
    /// Where the mattes come from of layers that name none: a Cryptomatte of the plate, or the scene; only where it differs
    /// from the frame before.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub mattes: String,
    /// What the user should know about this frame.
    pub warnings: Vec<String>,
}

/// What became of a sequence of plates.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WarpSummary {
    /// Frames written.
    pub warped: usize,
    /// Frames kept from an earlier run.
    pub kept: usize,
    /// Frames that were there and were made again.
    pub redone: usize,
    /// Frames that failed.
    pub failed: usize,
    /// The user stopped it.
    pub is_cancelled: bool,
    /// Wall time, seconds.
    pub wall_secs: f64,
    /// Milliseconds the reader was busy over all frames.
    pub read_ms: f64,
    /// Milliseconds spent in solving and warping.
    pub warp_ms: f64,
    /// Milliseconds the writer was busy.
    pub write_ms: f64,
}
