//! What a render reports on the way.
//!
//! In: frames as they are made. Out: events, reports and a summary, as they are printed with `--json`.

use crate::solve::SolveReport;
use serde::{Deserialize, Serialize, Serializer};
use std::path::{Path, PathBuf};

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

/// A frame that is there and is made again.
#[derive(Clone, Debug, Serialize)]
pub struct Redone {
    /// Its number.
    pub frame: i32,
    /// The file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Why, in words.
    pub reason: String,
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

/// |x(f) − 3 x(f−1) + 3 x(f−2) − x(f−3)|, the greatest of all points, pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Jerk {
    /// Of the displacement that the warp makes.
    pub warp_px: f64,
    /// Of what it follows: the model's points on the screen before the warp, and what the keys ask of pins and handles.
    pub input_px: f64,
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

/// A path as text; bytes that are not Unicode are replaced, so that JSON can hold it.
pub(super) fn lossy<S: Serializer>(path: &Path, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&path.to_string_lossy())
}
