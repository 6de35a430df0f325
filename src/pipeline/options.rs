//! What a render is asked to do, and what it tells while it does.

use super::Jerk;
use crate::raster::DeviceChoice;
use crate::solve::SolveReport;
use serde::Serialize;
use std::path::PathBuf;

/// How a shot is rendered.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Frames in the order wanted; empty: the shot's own range.
    pub frames: Vec<i32>,
    /// What draws.
    pub device: DeviceChoice,
    /// What happens to frames that are already there.
    pub existing: Existing,
    /// An sRGB PNG is written beside every frame.
    pub has_preview: bool,
    /// The preview carries lattice, pins, targets and folded cells.
    pub has_overlay: bool,
}

/// What happens to frames that are already there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Nothing is rendered.
    #[default]
    Refuse,
    /// They are replaced.
    Overwrite,
    /// Complete ones are kept, broken and missing ones are rendered.
    Resume,
}

/// What a render tells while it runs.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// Rendering begins.
    Started {
        /// What draws.
        device: String,
        /// Frames to render.
        frames: usize,
        /// Frames kept from an earlier run.
        kept: usize,
    },
    /// Something the user should know about the shot as a whole.
    Note {
        /// In words.
        text: String,
    },
    /// A frame is on disk.
    FrameDone(FrameReport),
    /// A frame could not be made; the others go on.
    FrameFailed {
        /// Which.
        frame: i32,
        /// Why.
        error: String,
    },
    /// All frames were tried.
    Finished(Summary),
}

/// What became of a frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: i32,
    /// The file.
    pub path: PathBuf,
    /// Milliseconds spent in posing, solving and building geometry.
    pub geometry_ms: f64,
    /// Milliseconds spent in drawing.
    pub raster_ms: f64,
    /// Milliseconds spent in encoding and writing.
    pub write_ms: f64,
    /// One a layer.
    pub layers: Vec<LayerReport>,
    /// What the user should know about this frame.
    pub warnings: Vec<String>,
}

/// The solve of one layer in one frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct LayerReport {
    /// Layer name.
    pub layer: String,
    /// Greatest distance of a pin from its target, pixels.
    pub pin_error_px: f64,
    /// The same in scene space, metres; world layers only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pin_error_metres: Option<f64>,
    /// How unevenly it moves, of layers on the screen; `None` in the first three frames of a run, and after gaps.
    pub jerk: Option<Jerk>,
    /// The solver's own report. `angular`, `area` and `least_det` are NaN (in JSON null) where they are not measured: in
    /// lattices from a file, and while the last pin of a layer fades out.
    pub solve: SolveReport,
}

/// What became of a render.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Frames written.
    pub rendered: usize,
    /// Frames kept from an earlier run.
    pub kept: usize,
    /// Frames that failed.
    pub failed: usize,
    /// The user stopped it.
    pub is_cancelled: bool,
    /// Wall time, seconds.
    pub wall_secs: f64,
    /// Milliseconds a stage was busy over all frames.
    pub geometry_ms: f64,
    /// Milliseconds the raster was busy.
    pub raster_ms: f64,
    /// Milliseconds the writer was busy.
    pub write_ms: f64,
}
