//! The inputs of a plate's warp besides the plate itself: plain data that the pipeline provides for every frame.

use super::{Field, Front, Matte, WarpSettings};
use crate::image::Plate;
use std::sync::Arc;

/// The inputs of a plate's warp besides the plate itself.
#[derive(Clone, Debug)]
pub struct PlateJob<'a> {
    /// Layers in the shot's order, from back to front. Layers without a matte also bend everything below them.
    pub layers: Vec<LayerJob>,
    /// Filter, channel semantics and motion settings.
    pub settings: &'a WarpSettings,
    /// Clean plate for uncovered regions, with the same channel names and display window.
    pub fill: Option<&'a Plate>,
}

/// One layer of a plate at one frame.
#[derive(Clone, Debug)]
pub struct LayerJob {
    /// Name in the shot, for messages.
    pub name: String,
    /// Warp of this frame.
    pub field: Field,
    /// Warp of the previous frame; `None`: the same as `field`. Needed for backward motion.
    pub previous: Option<Field>,
    /// Warp of the next frame; `None`: the same as `field`. Needed for forward motion.
    pub next: Option<Field>,
    /// Matte that selects the part of the plate to move; `None`: the whole picture.
    pub matte: Option<Matte>,
    /// What stands in front of the layer; `None`: nothing but the layers after it. Counts for layers with a matte.
    pub front: Option<Arc<Front>>,
}
