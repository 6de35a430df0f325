//! Finished frames through the whole way: real files of other programs, and the geometry path against the plate path.

#[path = "../support/assets.rs"]
mod assets;

mod agreement;
mod branches;
mod real;
mod shared;
