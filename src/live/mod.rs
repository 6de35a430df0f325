//! Warps one picture at one time from plain parameters; the engine's interface for hosts (the OpenFX plugin, an editor).
//!
//! In: [`Controls`], a [`ShapeSource`], the size of the frame. Out: a [`Warp`] with its overlay and quality report; pixels ([`render_pieces`]),
//! regions, STMaps. All functions are thread-safe and deterministic. Results are cached by content for the whole process (see
//! `process_cache.rs`), so hosts may recreate their instances for every frame.

#[cfg(any(test, feature = "ofx"))]
mod alpha_region;
mod base_scene;
mod buffer_pool;
mod cache;
mod composite;
mod controls;
mod driven_layer;
mod error;
#[cfg(any(test, feature = "ofx"))]
mod host_frame;
mod key;
#[cfg(any(test, feature = "ofx"))]
mod layer_places;
mod load_scene;
mod map_tiles;
mod mix;
#[cfg(any(test, feature = "ofx"))]
mod notices;
#[cfg(any(test, feature = "ofx"))]
mod outputs;
#[cfg(feature = "ofx")]
mod owned;
#[cfg(any(test, feature = "ofx"))]
mod picker;
mod picture;
mod prepared_solver;
mod process_cache;
#[cfg(any(test, feature = "ofx"))]
mod read;
mod regions;
mod render;
mod render_job;
mod shape_source;
mod solve;
#[cfg(any(test, feature = "ofx"))]
mod stmap;
#[cfg(feature = "ofx")]
mod viewer;
mod warp;
#[cfg(any(test, feature = "ofx"))]
mod write;

#[cfg(any(test, feature = "ofx"))]
pub(crate) use crate::lattice::Basis;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use crate::solve::Guard;
/// Asked on the calling thread whether to cancel; `true`: cancel.
pub(crate) type Stop<'a> = dyn Fn() -> bool + Sync + 'a;

/// Never cancels.
const NEVER: &Stop<'static> = &|| false;

#[cfg(any(test, feature = "ofx"))]
pub(crate) use alpha_region::destination_of_any_alpha;
pub(crate) use buffer_pool::{recycle_planes, take_planes};
pub use controls::{Controls, Moved, Pin, PinRegion};
pub use error::LiveError;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use host_frame::HostFrame;
pub use mix::Mix;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use notices::Wording;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use outputs::OutputGuard;
#[cfg(feature = "ofx")]
pub(crate) use owned::OwnedPicture;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use picker::{PenResult, Picker, SelectMode};
pub use picture::{Alpha, Picture};
#[cfg(test)]
pub(crate) use read::TrackKey;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use read::{PinTrack, read_shot};
#[cfg(test)]
pub(crate) use render::render;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use render::render_mean;
pub use render::{Piece, render_pieces};
pub use render_job::Render;
pub use shape_source::{Coverage, OwnPins, ShapeSource, ShotShape};
#[cfg(any(test, feature = "ofx"))]
pub(crate) use solve::last_of_alpha;
pub use solve::warp;
#[cfg(any(test, feature = "ofx", feature = "python"))]
pub(crate) use solve::warp_until;
#[cfg(feature = "ofx")]
pub(crate) use stmap::check_stmap_path;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use stmap::{StMapFile, save_stmap, stmap};
#[cfg(feature = "ofx")]
pub(crate) use viewer::{LatticeStyle, Viewer};
#[cfg(any(test, feature = "ofx"))]
pub(crate) use warp::GridLine;
#[cfg(test)]
pub(crate) use warp::Warning;
pub use warp::Warp;
#[cfg(any(test, feature = "ofx"))]
pub(crate) use write::{NewShot, Subject, WriteShot, write_shot};

/// Frees everything that is cached and can be recomputed, for hosts that are short of memory. Later results are
/// bit-identical, and take as long as the first time.
#[cfg(any(test, feature = "ofx"))]
pub(crate) fn purge() {
    process_cache::CACHE.purge();
    buffer_pool::purge();
}
