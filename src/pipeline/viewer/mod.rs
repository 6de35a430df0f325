//! Serves editors and viewers: new and edited shots, picked points, marks of pins and lattices, single frames.
//!
//! In: a shot in memory. Out: what a window shows of it.

pub(super) mod brush_point;
mod folded_model_cells;
mod folded_outlines;
#[cfg(feature = "editor")]
pub(super) mod held_points;
pub(super) mod layer_marks;
#[cfg(feature = "editor")]
pub(super) mod layer_offers;
#[cfg(feature = "editor")]
pub(super) mod layer_shift;
pub(super) mod new_shot;
pub(super) mod open_shot;
pub(super) mod picked_point;
pub(super) mod problem_shot;
mod scene_lines;
pub(super) mod stiff_triangles;
pub(super) mod still;
#[cfg(feature = "editor")]
pub(super) mod warped_still;
