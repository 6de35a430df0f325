//! Stage 7b: finished frames of any renderer, warped as pictures: every channel by its meaning.
//!
//! In: a [`Plate`](crate::image::Plate) and solved lattices of the screen. Out: the warped plate.
//!
//! ```text
//! Lattice ─field─▶ Field ─map─▶ WarpMap ─┬─ filter (colour) ──────────────────┐
//!                        Matte ─weight───┴─ cryptomatte, nearest, motion … ───┴─▶ Plate
//! ```

mod alike;
mod around;
mod canvas;
mod color_layers;
mod contents;
mod coverage;
mod cryptomatte;
mod default_matte;
mod draw;
mod field;
mod fill;
mod filter;
mod flow;
mod map;
mod map_blocks;
mod map_folds;
mod map_mesh;
mod map_parts;
mod map_patch;
mod map_view;
mod map_window;
mod matte;
mod meaning;
mod motion;
mod nearest;
mod normals;
mod over;
mod ramp;
mod report;
mod resampler;
mod rules;
mod stmap;
mod swirl;
mod vectors;
mod warp;
mod whole;

pub use color_layers::{ColorLayer, color_layers};
pub use coverage::Coverage;
pub use default_matte::{coverage_of, mattes_of_names};
pub use field::Field;
pub(crate) use filter::{Extent, lanczos_table};
pub use filter::{NotFinite, Planes, footprint_taps, resample_into, resample_part, resampled};
pub use map::WarpMap;
pub(crate) use over::{laid, left_below};
pub use report::{ChannelReport, MeaningReason, PlateError, PlateReport};
pub use resampler::Resampler;
pub use rules::{Filter, Holes, Matte, Meaning, MotionRule, MotionScale, NormalRule, WarpRules};
pub use stmap::{check_stmap, map_of_stmap, stmap_of};
pub use warp::{
    LayerJob, PlateJob, Warper, channel_meanings, check_plate, has_cryptomattes, has_motion, remap_plate, undo_plate,
    warp_plate,
};
pub use whole::{WholePin, WholeWarp};
