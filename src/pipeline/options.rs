//! What a render is asked to do, and what it reports on the way.
//!
//! In: what a front end asks for. Out: events, reports and a summary, as they are printed with `--json`.

use super::{Jerk, Redone};
use crate::image::Durability;
pub use crate::image::Existing;
use crate::raster::DeviceChoice;
use crate::solve::SolveReport;
use serde::{Serialize, Serializer};
use std::path::{Path, PathBuf};

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
    /// When a frame counts as written.
    pub durability: Durability,
}

/// A path as text; bytes that are not Unicode are replaced, so that JSON can hold it.
pub(super) fn lossy<S: Serializer>(path: &Path, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&path.to_string_lossy())
}

/// What a render reports while it runs.
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
    /// A frame is there, but not as this run would write it: it is made again. One event for each, before `started`.
    FrameRedone(Redone),
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
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Milliseconds spent in posing, solving and building geometry.
    pub geometry_ms: f64,
    /// Milliseconds spent in drawing.
    pub raster_ms: f64,
    /// Milliseconds spent in encoding and writing.
    pub write_ms: f64,
    /// One for each layer.
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
    /// How unevenly it moves, of layers on the screen; `None` in the first three frames of a shot.
    pub jerk: Option<Jerk>,
    /// The solver's own report. `angular`, `area` and `min_det` are NaN (in JSON null) where they are not measured: in
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
    /// Frames that were there and were made again.
    pub redone: usize,
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
