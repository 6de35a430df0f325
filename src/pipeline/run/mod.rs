//! Runs the stages over a range of frames: what to render, the output files, resuming, events and reports of a run.
//!
//! In: a [`PreparedShot`](crate::pipeline::PreparedShot) and [`RenderOptions`](crate::pipeline::RenderOptions). Out: files and events.

pub(super) mod contents;
pub(super) mod events;
pub(super) mod frame_record;
pub(super) mod options;
pub(super) mod output;
pub(super) mod pause;
pub(super) mod render_plan;
pub(super) mod renderer;
pub(super) mod resume;
pub(super) mod run_lock;
#[cfg(feature = "cli")]
pub(super) mod sequence_report;
pub(super) mod write;
