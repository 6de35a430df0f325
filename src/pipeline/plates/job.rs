//! The options, events and reports of a warp of finished frames.

use crate::export::LatticeFile;
use crate::image::Durability;
use crate::pipeline::run::events::lossy;
use crate::pipeline::{Existing, LayerNote, PreparedShot, Redone};
use crate::plate::{ChannelReport, Matte, WarpSettings};
use crate::raster::DeviceChoice;
use serde::Serialize;
use std::path::PathBuf;

/// A warp of finished frames: plates, warp and destination.
#[derive(Debug)]
pub struct WarpJob<'a> {
    /// The plates: a path with a frame counter, or one picture for all frames. EXR, PNG or JPEG files.
    pub plate: PathBuf,
    /// The output: EXR files, or PNG files if the plate is PNG or JPEG.
    pub output: PathBuf,
    /// The source of the warp.
    pub warp: PlateWarp<'a>,
    /// Filter, channel semantics, motion, holes.
    pub settings: WarpSettings,
    /// Whether the warp is applied or undone.
    pub direction: WarpDirection,
    /// Names of the layers that warp; empty: all.
    pub layers: Vec<String>,
    /// Frames in the order requested; empty: the shot's range, or else the frames found on disk.
    pub frames: Vec<i32>,
    /// How to treat existing frames.
    pub existing: Existing,
    /// The device that resamples colour and renders the scene to fill holes.
    pub device: DeviceChoice,
    /// The point at which a frame counts as written.
    pub durability: Durability,
    /// Files read for the job beyond those that it names, such as the lattice file; no frame may overwrite them.
    pub inputs: Vec<PathBuf>,
}

/// The source of a warp.
#[derive(Debug)]
pub enum PlateWarp<'a> {
    /// The layers of a shot, solved at every frame.
    Shot(&'a PreparedShot),
    /// Lattices that were solved before.
    Lattices {
        /// The file, whose screen layers are all used.
        file: LatticeFile,
        /// Factor on the displacements.
        strength: f64,
        /// The part of the plate that is moved; `None`: the whole picture.
        matte: Option<Matte>,
    },
    /// STMaps: a single picture, or a sequence with a frame counter.
    Maps(PathBuf),
}

impl PlateWarp<'_> {
    /// Returns name and matte of a layer, by its index in the shot or file.
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

/// The direction of a warp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarpDirection {
    /// The warp is applied.
    #[default]
    Forward,
    /// The warp is undone, where it is one-to-one.
    Inverse,
}

/// An event of a running warp.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum WarpEvent {
    /// Warping starts.
    Started {
        /// Number of frames to warp.
        frames: usize,
        /// Number of frames kept from an earlier run.
        kept: usize,
    },
    /// A note about the job as a whole.
    Note {
        /// The note.
        text: String,
    },
    /// An existing frame differs from what this run would write and is warped again; sent once per frame before `started`.
    FrameRedone(Redone),
    /// A frame has been written.
    FrameDone(WarpReport),
    /// A frame failed; the run continues with the others.
    FrameFailed {
        /// The frame.
        frame: i32,
        /// The cause.
        error: String,
    },
    /// All frames have been attempted.
    Finished(WarpSummary),
}

/// Report of one warped plate.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WarpReport {
    /// Frame number.
    pub frame: i32,
    /// Path of the file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Time spent reading and decoding, milliseconds.
    pub read_ms: f64,
    /// Time spent solving and warping, milliseconds.
    pub warp_ms: f64,
    /// Time spent encoding and writing, milliseconds.
    pub write_ms: f64,
    /// The device that resampled colour: `CPU`, or its name.
    pub device: String,
    /// Number of pixels that a layer uncovered and neither another layer nor a fill covers.
    pub hole_pixels: usize,
    /// Number of pixels that a layer uncovered and that were filled.
    pub filled_pixels: usize,
    /// Number of pixels where a layer overlaps itself; its front is shown, and the warp cannot be undone there. Not
    /// determined for STMaps.
    pub folded_pixels: usize,
    /// Number of colour samples that were NaN or infinite.
    pub contained_samples: usize,
    /// The semantic assigned to every channel; empty if unchanged since the previous frame.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<ChannelReport>,
    /// Source of the mattes of layers that name none: a Cryptomatte of the plate, or the scene; empty if unchanged
    /// since the previous frame.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub mattes: String,
    /// Warnings about this frame.
    pub warnings: Vec<String>,
    /// What the user may want to know about layers in this frame; once per layer is enough.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<LayerNote>,
}

/// Summary of a warped sequence.
#[derive(Clone, Debug, Default, Serialize)]
pub struct WarpSummary {
    /// Number of frames written.
    pub warped: usize,
    /// Number of frames kept from an earlier run.
    pub kept: usize,
    /// Number of existing frames that were warped again.
    pub redone: usize,
    /// Number of frames that failed.
    pub failed: usize,
    /// Whether the user stopped the warp.
    pub is_cancelled: bool,
    /// Wall time, seconds.
    pub wall_secs: f64,
    /// Time for which the reader was busy over all frames, milliseconds.
    pub read_ms: f64,
    /// Time spent solving and warping, milliseconds.
    pub warp_ms: f64,
    /// Time for which the writer was busy, milliseconds.
    pub write_ms: f64,
}
