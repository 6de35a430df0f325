//! The warp of one picture at one moment, from plain parameters: what every host of the engine shares (the OpenFX plugin,
//! an editor).
//!
//! In: [`Controls`], a [`ShapeSource`], the size of the frame. Out: a [`Warp`]: where every point goes, what to draw over the
//! picture, how good it is; pixels ([`render`]), regions, STMaps ([`stmap`]). All functions may be called from any number of threads, and give the same bits on all.
//! What was computed is kept for the whole process by content (`process_cache.rs` says what and why), so hosts may make
//! their instances anew for every frame.

mod alpha_region;
mod base_scene;
mod buffer_pool;
mod cache;
mod composite;
mod controls;
mod driven_layer;
mod error;
mod host_frame;
mod key;
mod load_scene;
mod map_tiles;
mod mix;
mod notices;
mod outputs;
mod owned;
mod picker;
mod picture;
mod prepared_solver;
mod process_cache;
mod read;
mod regions;
mod render;
mod render_job;
mod shape_source;
mod solve;
mod stmap;
mod viewer;
mod warp;
mod write;

pub use crate::lattice::Basis;
pub use crate::solve::Guard;
/// Asked, by the thread that called, whether a result is still wanted; true: it is not.
pub type Stop<'a> = dyn Fn() -> bool + Sync + 'a;

/// Results are always wanted.
const NEVER: &Stop<'static> = &|| false;

pub use alpha_region::destination_of_any_alpha;
pub use buffer_pool::{recycle_planes, take_planes};
pub use controls::{Controls, Moved, Pin, PinRegion};
pub use error::LiveError;
pub use host_frame::HostFrame;
pub use mix::Mix;
pub use notices::{Notice, Wording};
pub use outputs::OutputGuard;
pub use owned::OwnedPicture;
pub use picker::{PenResult, Picker, SelectMode};
pub use picture::{Alpha, Picture};
pub use read::{PinTrack, ShotFile, TrackKey, read_shot};
pub use render::{Piece, render, render_mean, render_pieces};
pub use render_job::Render;
pub use shape_source::{Coverage, OwnPins, ShapeSource, ShotShape};
pub use solve::{last_of_alpha, warp, warp_until};
pub use stmap::{StMap, StMapFile, check_stmap_path, save_stmap, stmap};
pub use viewer::{LatticeStyle, PinMark, Stroke, Viewer};
pub use warp::{GridLine, PinPlace, Warning, Warp};
pub use write::{NewShot, Subject, WriteShot, write_shot};

/// Lets go of all that is kept and can be computed again, for hosts that are short of memory. What is
/// asked for later has the same bits, and takes as long as the first time.
pub fn purge() {
    process_cache::CACHE.purge();
    buffer_pool::purge();
}
