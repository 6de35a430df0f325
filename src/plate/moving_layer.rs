//! The layers of a plate that move as units: the background and the layers with mattes.
//!
//! In: a [`PlateJob`]. Out: one [`MovingLayer`] each, with its fields at three frames, and fold warnings.

use super::pixel_field::Direction;
use super::{Field, Front, LayerJob, Matte, PlateJob};
use crate::space::FrameWindow;
use crate::spelling::pluralised;

/// A unit of motion: the background outside of all mattes, or a layer with its matte.
#[derive(Clone, Debug)]
pub(super) struct MovingLayer<'a> {
    /// Name for messages.
    pub(super) name: &'a str,
    /// Matte of what it moves; `None`: everything outside of the other mattes.
    pub(super) matte: Option<&'a Matte>,
    /// What stands in front of it.
    pub(super) front: Option<&'a Front>,
    /// Name and field of each layer that bends it.
    pub(super) bent_by: Vec<(&'a str, &'a Field)>,
    /// Forward to apply its fields; backward to undo a warp.
    pub(super) direction: Direction,
    /// Field of this frame.
    pub(super) now: Field,
    /// Field of the previous frame.
    pub(super) previous: Field,
    /// Field of the next frame.
    pub(super) next: Field,
}

impl<'a> MovingLayer<'a> {
    /// Returns the background, followed by the layers with mattes in the shot's order. Layers without a matte bend all of them.
    pub(super) fn all_of(job: &'a PlateJob) -> Vec<Self> {
        let whole: Vec<_> = job.layers.iter().filter(|layer| layer.matte.is_none()).collect();
        let matted = job.layers.iter().filter(|layer| layer.matte.is_some());
        let chain = |first: Option<&Field>, field_of: &dyn Fn(&LayerJob) -> Field| {
            Field::chain(first.cloned().into_iter().chain(whole.iter().map(|layer| field_of(layer))).collect())
        };
        let now = |layer: &LayerJob| layer.field.clone();
        let previous = |layer: &LayerJob| layer.previous.clone().unwrap_or_else(|| layer.field.clone());
        let next = |layer: &LayerJob| layer.next.clone().unwrap_or_else(|| layer.field.clone());
        let of = |layer: Option<&'a LayerJob>| Self {
            bent_by: layer.into_iter().chain(whole.iter().copied()).map(|layer| (&*layer.name, &layer.field)).collect(),
            name: layer.map_or("", |layer| layer.name.as_str()),
            matte: layer.and_then(|layer| layer.matte.as_ref()),
            front: layer.and_then(|layer| layer.front.as_deref()),
            direction: Direction::Forward,
            now: chain(layer.map(now).as_ref(), &now),
            previous: chain(layer.map(previous).as_ref(), &previous),
            next: chain(layer.map(next).as_ref(), &next),
        };
        std::iter::once(of(None)).chain(matted.map(|layer| of(Some(layer)))).collect()
    }
}

impl MovingLayer<'_> {
    /// Describes a fold, the layers that cause it, and the remedy.
    pub(super) fn fold_warning(&self, pixels: usize, FrameWindow { frame, window }: FrameWindow) -> String {
        let folding: Vec<&str> = match &self.bent_by[..] {
            [(only, _)] => vec![only],
            layers => layers.iter().filter(|(_, field)| field.folds_in(frame, window)).map(|(name, _)| *name).collect(),
        };
        let folding = if folding.is_empty() { self.bent_by.iter().map(|(name, _)| *name).collect() } else { folding };
        let names: Vec<String> = folding.iter().map(|name| format!("\"{name}\"")).collect();
        let subject = match &names[..] {
            [only] => format!("the warp of layer {only} folds"),
            names => format!("the warps of the layers {} fold", names.join(" and ")),
        };
        let pixels = pluralised(pixels, "pixel", "pixels");
        let remedy = match (self.direction, self.matte) {
            (Direction::Backward, _) => "which cannot be undone there",
            (Direction::Forward, Some(_)) => "move its pins less, or hold the folded region with more pins",
            (Direction::Forward, None) => {
                "move its pins less, hold the folded region with more pins, or give the layer a matte of what it moves"
            }
        };
        format!("{subject}: the picture overlaps itself in {pixels}; {remedy}")
    }
}
