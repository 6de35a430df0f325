//! What a render is asked to do.
//!
//! In: what a front end asks for. Out: [`RenderOptions`].

use crate::image::Durability;
pub use crate::image::Existing;
use crate::raster::DeviceChoice;
use std::path::PathBuf;

/// How a shot is rendered.
#[derive(Clone, Debug, Default)]
pub struct RenderOptions {
    /// Frames in the order wanted; empty: the shot's own range.
    pub frames: Vec<i32>,
    /// What draws.
    pub device: DeviceChoice,
    /// What happens to frames that are already there.
    pub existing: Existing,
    /// An sRGB PNG is written beside every frame.
    pub has_preview: bool,
    /// The preview carries lattice, pins, targets and folded cells.
    pub has_overlay: bool,
    /// When a frame counts as written.
    pub durability: Durability,
    /// Files that the shot was made from beside those that it names: no frame is written over them.
    pub inputs: Vec<PathBuf>,
}
