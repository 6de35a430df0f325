//! The scenes of this repository that are made by code.
//!
//! Out: the bytes of each .glb and .png file, the same in every run. `cargo run --example make_scenes` writes them.

mod cat;
mod drawing;
mod fields;
pub(crate) mod figures;
mod flag;
pub(crate) mod gingerman;
mod glb;
mod gnome;
pub(crate) mod hare;
mod meadow;
mod nets;
mod outline;
mod paint;
mod patch;
mod puppet;
mod rig;
pub(crate) mod teapot;
mod teapot_data;
mod walker;

use image::ImageError;

/// Path below `scenes/` and contents of every file made by code.
///
/// # Errors
/// If a texture cannot be encoded.
pub(crate) fn files() -> Result<Vec<(&'static str, Vec<u8>)>, ImageError> {
    Ok(vec![
        ("teapot/teapot.glb", teapot::scene()?),
        ("gingerman/gingerman.glb", gingerman::scene()?),
        ("walker/walker.glb", walker::scene()?),
        ("hare/hare.glb", hare::scene()),
        ("flag/flag.png", flag::cloth()?),
        ("flag/pole.png", flag::pole()?),
        ("cat/cat.png", cat::picture()?),
        ("puppet/puppet.png", puppet::picture()?),
    ])
}
