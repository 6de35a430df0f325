//! Stage 7b: warps finished frames of any renderer as pictures, each channel according to its semantic.
//!
//! In: a [`Plate`](crate::image::Plate) and solved screen lattices. Out: the warped plate. Lattices become a field, the field a
//! map; colour is filtered through it, and what cannot be blended (ids, depth, motion) is sampled.

mod channel_table;
mod color_layers;
mod compose;
mod composite;
mod composite_layout;
mod compositor;
mod coverage;
mod cryptomatte;
mod default_matte;
mod disjoint_over;
mod edge_split;
mod extrapolation;
mod field;
mod filter;
mod flow;
mod front;
mod hole_filling;
mod id_labels;
mod job;
mod map_blocks;
mod map_doubt;
mod map_folds;
mod map_mesh;
mod map_parts;
mod map_patch;
mod map_solve;
mod map_window;
mod matte;
mod motion;
mod moving_layer;
mod normals;
mod pixel_field;
mod ramp;
mod report;
mod resampler;
#[cfg(any(test, feature = "editor"))]
mod scaled_matte;
mod scaling;
mod semantics;
mod settings;
mod stmap;
mod surface_field;
mod surface_map;
mod swirl;
mod uniform_regions;
mod vectors;
mod visibility;
mod visible_samples;
mod warp_map;
mod warper;
mod whole;

pub(crate) use color_layers::{ColorLayer, color_layers};
pub use coverage::Coverage;
pub(crate) use coverage::OPAQUE_COVERAGE;
pub(crate) use default_matte::{coverage_of, mattes_of_names};
pub(crate) use disjoint_over::{over, transmittance};
pub use field::Field;
#[cfg(test)]
pub(crate) use filter::footprint_taps;
pub(crate) use filter::{Extent, lanczos_table, resample_part};
pub use filter::{Planes, resample_into, resampled};
pub use front::Front;
pub(crate) use hole_filling::check_fill;
pub(crate) use id_labels::{channel_labels, chosen_labels, cryptomatte_labels};
pub use job::{LayerJob, PlateJob};
pub(crate) use map_parts::SharedParts;
pub(crate) use report::SemanticReason;
pub use report::{ChannelReport, PlateError, PlateReport};
pub(crate) use resampler::Resampler;
#[cfg(any(test, feature = "editor"))]
pub(crate) use scaled_matte::scaled_matte;
pub(crate) use scaling::scaled;
pub use settings::{Filter, Holes, Matte, MotionEncoding, MotionUnit, NormalMode, Semantic, WarpSettings};
pub(crate) use stmap::check_stmap;
pub use stmap::{map_of_stmap, stmap_of};
pub(crate) use surface_map::SurfacePicture;
pub use warp_map::WarpMap;
pub(crate) use warper::Warper;
#[cfg(any(test, feature = "cli"))]
pub(crate) use warper::channel_semantics;
pub use warper::warp_plate;
pub(crate) use warper::{check_plate, has_cryptomattes, has_motion};
#[cfg(test)]
pub(crate) use warper::{remap_plate, undo_plate};
pub(crate) use whole::WholePin;
pub use whole::WholeWarp;
