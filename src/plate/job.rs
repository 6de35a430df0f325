//! What a plate's warp needs beside the plate: plain data, made by the pipeline for every frame.

use super::{Field, Matte, WarpSettings};
use crate::image::Plate;

/// What a plate's warp needs beside the plate.
#[derive(Clone, Debug)]
pub struct PlateJob<'a> {
    /// In the shot's order: later ones lie in front. Layers without a matte bend everything that lies below them too.
    pub layers: Vec<LayerJob>,
    /// Filter, semantics, motion.
    pub settings: &'a WarpSettings,
    /// What is seen where a layer moved away: channels of the same names, over the same display window.
    pub fill: Option<&'a Plate>,
}

/// One layer of a plate at one frame.
#[derive(Clone, Debug)]
pub struct LayerJob {
    /// Its name in the shot, for messages.
    pub name: String,
    /// Where it goes.
    pub field: Field,
    /// Where it goes in the frame before; `None`: as in this one. Backward motion needs it.
    pub previous: Option<Field>,
    /// Where it goes in the next frame; `None`: as in this one. Forward motion needs it.
    pub next: Option<Field>,
    /// The part of the plate that it moves; `None`: the whole picture.
    pub matte: Option<Matte>,
}
