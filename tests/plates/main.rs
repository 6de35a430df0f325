//! Finished frames through the whole way: real files of other programs, the geometry path against the plate path, many
//! frames in little memory.

#[path = "../support/assets.rs"]
mod assets;

mod agreement;
mod real;
mod steady;
