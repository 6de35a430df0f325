//! The warped layers of one view over one data window, ordered from back to front.
//!
//! In: the layout computed by [`composite_layout`](super::composite_layout). Out: [`Composite`], with per-pixel queries.

use super::WarpMap;
use super::channel_table::ChannelEntry;
use super::matte::MatteCoverage;
use super::pixel_field::PixelField;
use super::warp_map::nearest_source;
use crate::space::PixelRect;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// Smallest coverage that counts as a hole or as overlap of mattes: half an 8-bit step.
pub(super) const MIN_VISIBLE: f32 = 0.5 / 255.0;

/// A warped layer: its matte, its map and its window.
#[derive(Clone, Debug)]
pub(super) struct WarpedLayer {
    /// Index into the moving layers; 0 is the background.
    pub(super) moving_layer: usize,
    /// Group of parts that were split from one layer. They are consecutive and occlude what is behind them as a single
    /// layer. `None`: not a part.
    pub(super) group: Option<usize>,
    /// The part of the source that the layer moves.
    pub(super) matte: MatteCoverage,
    /// The source pixels with coverage, and a border of one pixel.
    pub(super) reach: PixelRect,
    /// The output pixels that the layer may cover.
    pub(super) window: PixelRect,
    /// Source offsets of the pixels in `window`; `None`: identity.
    pub(super) map: Option<Arc<WarpMap>>,
    /// #pixels of `window`: the fraction that nothing of the scene covers; `None`: all.
    pub(super) visibility: Option<Arc<Vec<f32>>>,
}

/// The channels of one view over one data window. Windows are relative to the upper left corner of the display window.
#[derive(Debug)]
pub(super) struct Composite<'a> {
    pub(super) view: Option<&'a str>,
    pub(super) entries: Vec<&'a ChannelEntry>,
    /// Data window of the source plate.
    pub(super) source: PixelRect,
    /// Data window of the result.
    pub(super) window: PixelRect,
    /// Layers from back to front.
    pub(super) layers: Vec<WarpedLayer>,
    /// Coverage that matted layers remove from the background: #pixels of the source; `None`: none.
    pub(super) holdout: Option<Vec<f32>>,
    /// Message about pixels that the mattes of several layers cover.
    pub(super) overlap: Option<String>,
}

impl WarpedLayer {
    /// Crops a source plane to the layer's reach.
    pub(super) fn reached<'a>(&self, composite: &Composite, plane: &'a [f32]) -> Cow<'a, [f32]> {
        if self.reach == composite.source {
            return Cow::Borrowed(plane);
        }
        Cow::Owned(composite.source.resized_samples(plane, self.reach, 0.0))
    }

    /// Returns how much of the layer is visible at a pixel.
    pub(super) fn visibility_at(&self, pixel: [i32; 2]) -> f32 {
        let known = self.visibility.as_ref().zip(self.window.sample_index(pixel));
        known.map_or(1.0, |(visibility, index)| visibility[index])
    }

    /// Whether the layer has something visible at a sample of the source. `alpha`: #pixels of the source; `None`: opaque.
    fn covers(&self, source: usize, alpha: Option<&[f32]>) -> bool {
        let of = |plane: Option<&[f32]>| plane.map_or(1.0, |plane| plane[source]);
        of(self.matte.coverage.as_deref()) * of(alpha) > MIN_VISIBLE
    }
}

impl Composite<'_> {
    /// Returns the front surface of the background, which is as large as the window.
    pub(super) fn background(&self) -> &WarpedLayer {
        &self.layers[self.background_folds().len()]
    }

    /// Returns the hidden surfaces of the background where it folds, from back to front.
    pub(super) fn background_folds(&self) -> &[WarpedLayer] {
        let count = self.layers.iter().take_while(|layer| layer.moving_layer == 0).count();
        &self.layers[..count.saturating_sub(1)]
    }

    /// Returns the layers that have a matte, from back to front.
    pub(super) fn matted_layers(&self) -> &[WarpedLayer] {
        &self.layers[self.background_folds().len() + 1..]
    }

    /// Groups the layers from index `first` on into runs that occlude as one: the parts of a layer together, other layers individually.
    pub(super) fn runs_from(&self, first: usize) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for index in first..self.layers.len() {
            let group = self.layers[index].group;
            match runs.last_mut() {
                Some(run) if group.is_some() && self.layers[run.start].group == group => run.end = index + 1,
                _ => runs.push(index..index + 1),
            }
        }
        runs
    }

    /// Returns the source pixels that a moving layer covers.
    pub(super) fn reach(&self, moving_layer: usize) -> PixelRect {
        let own = self.layers.iter().filter(|layer| layer.moving_layer == moving_layer);
        own.map(|layer| layer.reach).reduce(PixelRect::union).unwrap_or_default()
    }

    /// Returns the index of the source sample nearest to the source position of a layer's pixel.
    pub(super) fn source_of(&self, layer: &WarpedLayer, [x, y]: [i32; 2]) -> Option<usize> {
        let own = layer.window.sample_index([x, y])?;
        let offset = layer.map.as_ref().map_or([0.0; 2], |map| map.offsets[own]);
        self.source.sample_index(nearest_source([x, y], offset)?)
    }

    /// Returns the source pixel that the background shows at a pixel, given by its index in the window.
    pub(super) fn background_source(&self, at: usize) -> Option<[i32; 2]> {
        let offset = self.background().map.as_ref().map_or([0.0; 2], |map| map.offsets[at]);
        nearest_source(self.window.pixel_at(at), offset)
    }

    /// Whether the holdout removes some of the background shown at a pixel.
    pub(super) fn is_held_out_at(&self, at: [i32; 2]) -> bool {
        let held_out = self.holdout.as_ref().zip(self.source_of(self.background(), at));
        held_out.is_some_and(|(holdout, index)| holdout[index] > 0.0)
    }

    /// Returns the pixels, as indices into the window, where a moving layer folds over itself and is visible. What a matte or a part
    /// leaves out is moved too, but overlaps nothing: two surfaces must be visible, or one that is flipped. On a branch it must be one
    /// that is flipped, since its parts may pass in front of each other. `alpha`: #pixels of the source.
    pub(super) fn folded_pixels(
        &self,
        (moving_layer, has_matte): (usize, bool),
        field: PixelField,
        alpha: Option<&[f32]>,
    ) -> BTreeSet<usize> {
        let surfaces: Vec<&WarpedLayer> =
            self.layers.iter().filter(|layer| layer.moving_layer == moving_layer).collect();
        let folded_of = |layer: &WarpedLayer| -> Vec<[i32; 2]> {
            let folded = layer.map.iter().flat_map(|map| map.folded_pixels.iter().map(|&index| index as usize));
            folded.map(|index| layer.window.pixel_at(index)).collect()
        };
        let folded: Vec<(&WarpedLayer, Vec<[i32; 2]>)> =
            surfaces.iter().map(|&layer| (layer, folded_of(layer))).collect();
        if folded.iter().all(|(_, pixels)| pixels.is_empty()) {
            return BTreeSet::new();
        }
        let is_whole = !has_matte && surfaces.iter().all(|layer| layer.group.is_none());
        let flipped = match surfaces.first() {
            Some(layer) if !is_whole => self.flipped_targets(field, layer, alpha),
            _ => BTreeSet::new(),
        };
        let seen = |pixel: [i32; 2]| surfaces.iter().filter(|own| self.is_visible(own, pixel, alpha)).count();
        let of_layer = |(layer, pixels): (&WarpedLayer, Vec<[i32; 2]>)| -> Vec<usize> {
            let shown = pixels.into_iter().filter(|&pixel| self.is_visible(layer, pixel, alpha));
            let indexed = shown.filter_map(|pixel| Some((pixel, self.window.sample_index(pixel)?)));
            let may_overlap = field.field.is_of_branch();
            let counts =
                indexed.filter(|(pixel, at)| is_whole || flipped.contains(at) || !may_overlap && seen(*pixel) >= 2);
            counts.map(|(_, at)| at).collect()
        };
        folded.into_iter().flat_map(of_layer).collect()
    }

    /// Returns the pixels, as indices into the window, on and around which visible pixels of a layer land flipped.
    fn flipped_targets(&self, field: PixelField, layer: &WarpedLayer, alpha: Option<&[f32]>) -> BTreeSet<usize> {
        let pixels = field.flipped_targets(self.source, |source| layer.covers(source, alpha));
        pixels.into_iter().filter_map(|pixel| self.window.sample_index(pixel)).collect()
    }

    /// Whether a layer is visible at a pixel.
    fn is_visible(&self, layer: &WarpedLayer, pixel: [i32; 2], alpha: Option<&[f32]>) -> bool {
        self.source_of(layer, pixel).is_some_and(|source| layer.covers(source, alpha))
    }
}
