//! Progress events and reports of a render.
//!
//! In: frames as they are completed. Out: events, reports and a summary, as printed with `--json`.

use crate::solve::SolveReport;
use serde::{Deserialize, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// An event of a running render.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// Rendering starts.
    Started {
        /// The device that draws.
        device: String,
        /// Number of frames to render.
        frames: usize,
        /// Number of frames kept from an earlier run.
        kept: usize,
    },
    /// A note about the shot as a whole.
    Note {
        /// The note.
        text: String,
    },
    /// An existing frame differs from what this run would write and is rendered again; sent once per frame before `started`.
    FrameRedone(Redone),
    /// A frame has been written.
    FrameDone(FrameReport),
    /// A frame failed; the run continues with the others.
    FrameFailed {
        /// The frame.
        frame: i32,
        /// The cause.
        error: String,
    },
    /// All frames have been attempted.
    Finished(Summary),
}

/// An existing frame that is rendered again.
#[derive(Clone, Debug, Serialize)]
pub struct Redone {
    /// Frame number.
    pub frame: i32,
    /// Path of the file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// The reason.
    pub reason: String,
}

/// Report of one frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FrameReport {
    /// Frame number.
    pub frame: i32,
    /// Path of the file.
    #[serde(serialize_with = "lossy")]
    pub path: PathBuf,
    /// Time spent posing, solving and building geometry, milliseconds.
    pub geometry_ms: f64,
    /// Time spent drawing, milliseconds.
    pub raster_ms: f64,
    /// Time spent encoding and writing, milliseconds.
    pub write_ms: f64,
    /// One report per layer.
    pub(crate) layers: Vec<LayerReport>,
    /// Warnings about this frame.
    pub warnings: Vec<String>,
    /// First and last frames over which sudden jumps are spread, of jumps that are spread over this frame, too; a warning tells of
    /// each.
    #[serde(skip)]
    pub(crate) spreads: Vec<[f64; 2]>,
    /// What the user may want to know about layers in this frame; once per layer is enough.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<LayerNote>,
}

/// A note about a layer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct LayerNote {
    /// Layer name.
    pub layer: String,
    /// The note.
    pub text: String,
}

/// Report of the solve of one layer in one frame.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct LayerReport {
    /// Layer name.
    pub layer: String,
    /// Largest distance of a pin from its target, pixels.
    pub pin_error_px: f64,
    /// The same in scene space, metres; world layers only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pin_error_metres: Option<f64>,
    /// Unevenness of the layer's motion; `None` for world layers, branching lattices, and the first three frames of a shot.
    pub jerk: Option<Jerk>,
    /// The solver's report. `angular`, `area` and `min_det` are NaN (null in JSON) if they are not measured: for
    /// lattices from a file, and while the last pin of a layer fades out.
    pub solve: SolveReport,
}

/// Third difference over four frames, |x(f) − 3 x(f−1) + 3 x(f−2) − x(f−3)|, maximum over all points, pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Jerk {
    /// Jerk of the displacement by the warp.
    pub warp_px: f64,
    /// Jerk of the warp's input: the points of the model on the screen before the warp, and the offsets that the keys
    /// prescribe for pins and handles.
    pub input_px: f64,
}

/// Summary of a render.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Number of frames written.
    pub rendered: usize,
    /// Number of frames kept from an earlier run.
    pub kept: usize,
    /// Number of existing frames that were rendered again.
    pub redone: usize,
    /// Number of frames that failed.
    pub failed: usize,
    /// Whether the user stopped the render.
    pub is_cancelled: bool,
    /// Wall time, seconds.
    pub wall_secs: f64,
    /// Time spent posing, solving and building geometry over all frames, milliseconds.
    pub geometry_ms: f64,
    /// Time for which the raster was busy, milliseconds.
    pub raster_ms: f64,
    /// Time for which the writer was busy, milliseconds.
    pub write_ms: f64,
}

/// Serialises a path as text; bytes that are not Unicode are replaced, so that it is valid JSON.
pub(in crate::pipeline) fn lossy<S: Serializer>(path: &Path, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&path.to_string_lossy())
}
