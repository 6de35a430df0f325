//! The warp of one picture at one moment, from plain parameters: what every host of the engine shares (the OpenFX plugin,
//! an editor).
//!
//! In: [`Controls`], a [`Shape`], the size of the frame. Out: a [`Warp`]: where every point goes, what to draw over the
//! picture, how good it is. All functions may be called from any number of threads, and give the same bits on all.
//! What was computed is kept for the whole process by content, so hosts may make their instances anew for every frame.

mod base;
mod cache;
mod controls;
mod error;
mod handles;
mod key;
mod shape;
mod solve;
mod warp;

pub use crate::lattice::Basis;
pub use controls::{Controls, Moved, Pin};
pub use error::LiveError;
pub use handles::{Choosing, Picker, Pull};
pub use shape::{Coverage, OwnPins, Shape, ShotShape};
pub use solve::warp;
pub use warp::{GridLine, PinPlace, Warp};
