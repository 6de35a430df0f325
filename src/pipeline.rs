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

mod prepare;

mod evaluate;
mod trajectories;

mod draw;

mod branches;
mod pictures;
mod plates;
mod run;

mod interchange;
mod viewer;

mod error;

pub(crate) use branches::{BranchPart, Exposure, fields_of, parts_of_file};
pub(crate) use draw::jerk::JerkMeter;
pub(crate) use draw::passes::{PassPlan, plan_passes};
pub use draw::report::report;
pub(crate) use draw::report::warnings_of_layer;
pub use error::PipelineError;
pub(crate) use evaluate::screen_layer::{LayerSolver, LayerTask};
pub use evaluate::time_sample::{LayerState, TimeSample, WorldSolution};
pub(crate) use evaluate::time_sample::{PinState, ScenePin};
pub(crate) use evaluate::topology::branching_key;
pub(crate) use interchange::bake::BakeTimes;
pub use interchange::lattice_tracks::lattices;
pub(crate) use interchange::layer_problem::layer_problem;
pub(crate) use interchange::registration::layer_shape;
pub use interchange::registration::{Registration, picture_shape, register};
pub(crate) use plates::Silhouette;
pub use plates::{PlateWarp, SurfaceMaps, WarpDirection, WarpEvent, WarpJob, WarpReport, WarpSummary, warp_frames};
pub use prepare::anchors::PinAnchor;
pub(crate) use prepare::anchors::RestPoint;
pub(crate) use prepare::branch_lattices::lattices_of_file;
pub use prepare::layer_assignment::LayerAssignment;
pub use prepare::prepared_shot::PreparedShot;
#[cfg(feature = "cli")]
pub(crate) use run::contents::digest_with;
pub use run::events::{Event, FrameReport, Redone, Summary};
pub(crate) use run::events::{Jerk, LayerNote, LayerReport};
pub use run::options::Existing;
pub use run::options::RenderOptions;
pub(crate) use run::output::input_files;
pub use run::render::render;
#[cfg(test)]
pub(crate) use run::render::render_on;
#[cfg(feature = "cli")]
pub(crate) use run::resume::{Todo, refuse_existing};
#[cfg(feature = "cli")]
pub(crate) use run::sequence_report::{LayerPeaks, Peak, SequenceReport};
#[cfg(feature = "cli")]
pub(crate) use trajectories::solve_ahead::solve_before_frames;
pub(crate) use trajectories::solve_ahead::{BakeEvent, BakeSummary, BakedLayer, solve_ahead};
pub(crate) use trajectories::trajectory_files::Keeping;
pub(crate) use viewer::brush_point::{BrushPoint, PaintedPlace};
pub(crate) use viewer::layer_marks::{LayerMarks, PinMark};
pub(crate) use viewer::layer_marks::{layer_marks, resting_marks};
pub(crate) use viewer::new_shot::{NewShot, new_shot, path_between};
pub(crate) use viewer::open_shot::{OpenShot, Rework};
pub(crate) use viewer::picked_point::PickedPoint;
pub(crate) use viewer::problem_shot::{ProblemShot, problem_shot};
pub(crate) use viewer::stiff_triangles::StiffTriangle;
pub(crate) use viewer::still::Device;
#[cfg(feature = "editor")]
pub(crate) use viewer::warped_still::WarpedStill;
