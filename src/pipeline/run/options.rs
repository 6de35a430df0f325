//! The options of a render.
//!
//! In: the choices of a front end. Out: [`RenderOptions`].

use super::pause::Pause;
use crate::image::Durability;
pub use crate::image::Existing;
use crate::raster::DeviceChoice;
use std::path::PathBuf;

/// The options with which a shot is rendered.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Frames in the order requested; empty: the shot's own range.
    pub frames: Vec<i32>,
    /// The device that draws.
    pub device: DeviceChoice,
    /// How to treat existing frames.
    pub existing: Existing,
    /// Whether to write an sRGB PNG beside every frame.
    pub has_preview: bool,
    /// Whether the preview shows lattice, pins, targets and folded cells.
    pub has_overlay: bool,
    /// The point at which a frame counts as written.
    pub durability: Durability,
    /// Files that the shot was made from, beyond those that it names; no frame may overwrite them.
    pub inputs: Vec<PathBuf>,
    /// Where the render waits while something else needs the processor.
    pub pause: Pause,
}
