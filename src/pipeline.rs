//! Runs the stages over a frame range: overlap, progress, cancel, per-frame errors.
//!
//! In: a [`crate::shot::Shot`] and [`RenderOptions`]. Out: files, [`Event`]s on the way, a [`Summary`].
//! Frame N is a function of the shot and N alone; what is kept between frames is only what would be computed again.

mod anchors;
mod bake;
mod cameras;
mod claims;
mod coarse;
mod contents;
mod draw;
mod error;
mod events;
mod fit;
mod follow;
mod jerk;
mod lattice_objects;
mod layer_pins;
mod lighting;
mod mattes;
mod missing;
mod moment;
mod options;
mod output;
mod overlay;
mod overlay_legend;
mod passes;
mod pictures;
mod plates;
mod posed;
mod produce;
mod render;
mod report;
mod resume;
mod run_lock;
mod screen_layer;
mod setup;
mod stiffness;
mod strokes;
mod trajectories;
mod transfer;
mod visibility;
mod whole_layer;
mod world;
mod write;

pub use anchors::{Pinned, Rest};
pub use bake::BakeTimes;
#[cfg(feature = "cli")]
pub(crate) use contents::digest_with;
pub use error::PipelineError;
pub use events::{Event, FrameReport, Jerk, LayerReport, Redone, Summary};
pub use fit::{Registration, picture_shape, register};
pub use jerk::JerkMeter;
pub use moment::{LayerState, Moment, PinState};
pub use options::{Existing, RenderOptions};
pub use passes::{PassPlan, plan_passes};
pub use plates::{PlateWarp, Silhouette, WarpDirection, WarpEvent, WarpJob, WarpReport, WarpSummary, warp_frames};
pub use posed::PosedLayer;
pub use render::{render, render_on};
pub use report::report;
#[cfg(feature = "cli")]
pub(crate) use resume::{Todo, refuse_existing};
pub use screen_layer::{LayerTask, Prepared};
pub use setup::Setup;
pub use transfer::lattices;
pub use world::{ScenePin, WorldSolution};
