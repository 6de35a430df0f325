//! Serves editors and viewers: new and edited shots, picked points, marks of pins and lattices, single frames.
//!
//! In: a shot in memory. Out: what a window shows of it.

#[cfg(any(test, feature = "editor"))]
pub(super) mod brush_point;
#[cfg(any(test, feature = "editor"))]
pub(super) mod draft;
mod folded_model_cells;
mod folded_outlines;
#[cfg(feature = "editor")]
pub(super) mod held_points;
#[cfg(any(test, feature = "editor"))]
pub(super) mod layer_marks;
#[cfg(feature = "editor")]
pub(super) mod layer_offers;
#[cfg(feature = "editor")]
pub(super) mod layer_shift;
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(super) mod new_shot;
#[cfg(any(test, feature = "editor"))]
pub(super) mod open_shot;
#[cfg(any(test, feature = "cli", feature = "editor"))]
pub(super) mod picked_point;
#[cfg(any(test, feature = "editor"))]
pub(super) mod problem_shot;
#[cfg(any(test, feature = "editor"))]
mod scene_lines;
#[cfg(any(test, feature = "editor"))]
pub(super) mod stiff_triangles;
#[cfg(any(test, feature = "editor", feature = "python"))]
pub(super) mod still;
#[cfg(feature = "editor")]
pub(super) mod warped_still;
