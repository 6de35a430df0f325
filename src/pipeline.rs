//! Runs all stages for a shot over a range of frames: concurrent threads, progress events, cancellation, and errors per frame.
//!
//! In: a [`crate::shot::Shot`] and [`RenderOptions`]. Out: files, [`Event`]s during the run, and a [`Summary`].
//!
//! ```text
//! once per shot   Shot ─prepare─▶ PreparedShot: scene, layer assignment, pin anchors, camera, clip
//! once per time   PreparedShot ─evaluate─▶ TimeSample: pose ─▶ world layers ─▶ projection ─▶ screen layers
//! once per layer  shape, pins ─factor─▶ Solver ─solve─▶ lattice         (the same for screen and world layers)
//! once per frame  TimeSamples ─geometry thread─▶ passes ─draw─▶ Frame ─write─▶ files
//! ```
//!
//! Frame N depends on the shot and on N alone: the caches that frames share hold only values that recomputation would
//! reproduce bit for bit.

// Run once per shot.
mod anchors;
mod auto_dims;
mod branch_lattices;
mod cameras;
mod layer_assignment;
mod lighting;
mod mattes;
mod mesh_resolution;
mod missing_files;
mod prepare;
mod prepared_shot;
mod rest_links;
mod rest_mesh;
mod selection;
mod stiffness;
mod transfer;
mod transferred_branches;
mod visibility;

// Run once per time.
mod evaluate;
mod followed_box;
mod frame_cache;
mod lattice_box;
mod layer_pins;
mod layer_solve;
mod layer_timeline;
mod moved_meshes;
mod part_order;
mod part_triangle_ranges;
mod screen_layer;
mod screen_shape;
mod time_sample;
mod timed_layer;
mod timed_world;
mod topology;
mod trajectories;
mod trajectory_files;
mod trajectory_key;
mod watched_points;
mod watched_trajectory;
mod whole_layer;
mod world_layer;
mod world_timeline;

// Run once per frame.
mod draw;
mod geometry_thread;
mod jerk;
mod overlay;
mod overlay_branches;
mod overlay_legend;
mod passes;
mod report;
mod shared_cells;
mod write;

// Run over a range of frames: of a scene, of pictures, of plates.
mod branches;
mod contents;
mod error;
mod events;
mod frame_record;
mod options;
mod output;
mod pictures;
mod plates;
mod render;
mod resume;
mod run_lock;
#[cfg(feature = "cli")]
mod sequence_report;
mod solve_ahead;

// Used by editors.
mod layer_marks;
mod new_shot;
mod open_shot;
mod picked_point;
mod still;

// Used by exports and other programs.
mod bake;
mod lattice_objects;
mod lattice_tracks;
mod layer_problem;
mod registration;

pub use anchors::{PinAnchor, RestPoint};
pub use bake::BakeTimes;
pub(crate) use branch_lattices::lattices_of_file;
pub(crate) use branches::{BranchPart, Exposure, fields_of, parts_of_file};
#[cfg(feature = "cli")]
pub(crate) use contents::digest_with;
pub use error::PipelineError;
pub use events::{Event, FrameReport, Jerk, LayerReport, Redone, Summary};
pub use jerk::JerkMeter;
pub use lattice_tracks::lattices;
pub use layer_assignment::LayerAssignment;
pub use layer_marks::{LayerMarks, PinMark, layer_marks, resting_marks};
pub use layer_problem::{LayerProblem, layer_problem};
pub use new_shot::{NewShot, new_shot, path_between};
pub use open_shot::{OpenShot, Rework};
pub use options::{Existing, RenderOptions};
pub(crate) use output::input_files;
pub use passes::{PassPlan, plan_passes};
pub use picked_point::PickedPoint;
pub use plates::{PlateWarp, Silhouette, WarpDirection, WarpEvent, WarpJob, WarpReport, WarpSummary, warp_frames};
pub use prepared_shot::PreparedShot;
pub use registration::{Registration, layer_shape, picture_shape, register};
pub use render::{render, render_on};
pub use report::report;
#[cfg(feature = "cli")]
pub(crate) use resume::{Todo, refuse_existing};
pub use screen_layer::{LayerSolver, LayerTask};
pub use selection::{LayerShare, SharedPart};
#[cfg(feature = "cli")]
pub(crate) use sequence_report::{LayerPeaks, Peak, SequenceReport};
pub use solve_ahead::{BakeEvent, BakeSummary, BakedLayer, solve_ahead};
pub use still::{Device, IsCancelled};
pub use time_sample::{LayerState, PinState, ScenePin, TimeSample, WorldSolution};
pub use trajectory_files::Keeping;
