//! The warp of one picture at one moment, from plain parameters: what every host of the engine shares (the OpenFX plugin,
//! an editor).
//!
//! In: [`Controls`], a [`Shape`], the size of the frame. Out: a [`Warp`]: where every point goes, what to draw over the
//! picture, how good it is; pixels ([`render`]), regions, STMaps ([`stmap`]). All functions may be called from any number of threads, and give the same bits on all.
//! What was computed is kept for the whole process by content, so hosts may make their instances anew for every frame.

mod base;
mod cache;
mod canvas;
mod composite;
mod controls;
mod error;
mod handles;
mod key;
mod owned;
mod pages;
mod picture;
mod read;
mod regions;
mod render;
mod shape;
mod sketch;
mod solve;
mod spare;
mod stmap;
mod warp;
mod write;

pub use crate::lattice::Basis;
pub use canvas::Canvas;
pub use controls::{Controls, Moved, Pin};
pub use error::LiveError;
pub use handles::{Choosing, Picker, Pull};
pub use owned::OwnedPicture;
pub use picture::{Alpha, Picture};
pub use read::{PinTrack, ShotFile, TrackKey, read_shot};
pub use render::{Piece, Render, render, render_pieces};
pub use shape::{Coverage, OwnPins, Shape, ShotShape};
pub use sketch::{Dot, Stroke, View};
pub use solve::{last_of_alpha, warp};
pub use spare::{keep_planes, spare_planes};
pub use stmap::{StMap, StMapFile, check_stmap_path, save_stmap, stmap};
pub use warp::{GridLine, PinPlace, Warp};
pub use write::{NewShot, Subject, WriteShot, write_shot};

/// Lets go of all that is kept and can be computed again, for hosts that are short of memory. What is
/// asked for later has the same bits, and takes as long as the first time.
pub fn purge() {
    pages::purge();
    regions::purge();
    solve::purge();
    shape::purge();
    spare::purge();
}
