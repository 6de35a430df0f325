//! Separates layers from the background in pixels that show both, by the clean plate that shows the background alone.
//!
//! In: a composite with mattes, a clean plate. Out: [`EdgeSplit`]: composites and samples in which every pixel with a
//! matte is layer and background apart. An edge of P = c F + (1 − c) B gives c F to the layers and nothing to the rest,
//! so that B alone stays where a layer leaves, and F alone travels.

use super::channel_table::{ChannelEntry, ChannelIndex};
use super::composite::{Composite, MIN_VISIBLE, WarpedLayer};
use super::compositor::PlateCompositor;
use super::disjoint_over::{Occlusion, occlusion};
use super::matte::MatteCoverage;
use rayon::prelude::*;

/// Coverage from which on a pixel shows layers only. Mattes are not filtered, so their rounding is less than that which
/// [`OPAQUE_COVERAGE`](super::coverage::OPAQUE_COVERAGE) allows for.
const OPAQUE_MATTE: f32 = 1.0 - 1e-6;

/// A composite whose mattes no longer hold any background.
pub(super) struct EdgeSplit<'a> {
    /// The layers with their shares of the separated light.
    pub(super) shares: Composite<'a>,
    /// How the layers, with their coverage of the pixels, occlude each other.
    pub(super) occlusion: Occlusion,
    /// #pixels of the source: coverage by all layers with mattes; `None`: a pixel without a matte.
    covered: Vec<Option<f32>>,
}

/// The samples of a channel.
pub(super) struct SplitSamples {
    /// #pixels of the source: the light of the layers where there are any, else the plate.
    pub(super) plate: Vec<f32>,
    /// #pixels of the clean plate's window: the background, never brighter than the plate allows.
    pub(super) behind: Vec<f32>,
}

impl<'a> EdgeSplit<'a> {
    /// Creates the split; `None` without mattes or a background of the same renderer. `alpha`: the channel, and its samples over the source.
    pub(super) fn of(
        compositor: &PlateCompositor,
        composite: &Composite<'a>,
        alpha: Option<(ChannelIndex, &[f32])>,
    ) -> Option<Self> {
        let all = matte_sum(composite)?;
        let behind = compositor.filling.as_ref()?.plate();
        // What this program draws has other light than the plates of other programs.
        if behind.is_own_render() && !compositor.table.plate.is_own_render() {
            return None;
        }
        let covered: Vec<Option<f32>> = all
            .par_iter()
            .enumerate()
            .map(|(pixel, &all)| {
                (all > MIN_VISIBLE).then(|| all.min(1.0) * alpha.map_or(1.0, |(_, alpha)| alpha[pixel]))
            })
            .map(|covered| covered.map(|covered| covered.clamp(0.0, 1.0)))
            .collect();
        let with = |factor: &(dyn Fn(usize) -> f32 + Sync)| parted(composite, &covered, factor);
        let shares = with(&|pixel| 1.0 / all[pixel].max(MIN_VISIBLE));
        let coverage = with(&|pixel| covered[pixel].unwrap_or(0.0) / all[pixel].max(MIN_VISIBLE));
        let mut split = Self { shares, occlusion: Occlusion::default(), covered };
        let opacity = match alpha {
            Some((index, _)) => {
                let entry = composite.entries.iter().find(|entry| entry.index == index)?;
                let mut opacity = split.samples(compositor, entry)?.plate;
                opacity.par_iter_mut().zip(&split.covered).for_each(|(opacity, covered)| {
                    if let Some(covered) = covered {
                        *opacity = if *covered > 0.0 { *opacity / covered } else { 0.0 };
                    }
                });
                Some(opacity)
            }
            None => None,
        };
        split.occlusion = occlusion(&coverage, opacity.as_deref(), compositor.by(compositor.settings.filter));
        Some(split)
    }

    /// Returns the separated samples of a channel; `None` if the clean plate does not have it.
    pub(super) fn samples(&self, compositor: &PlateCompositor, entry: &ChannelEntry) -> Option<SplitSamples> {
        let filling = compositor.filling.as_ref()?;
        let (behind, window) = filling.samples(filling.find(entry)?.index);
        let (mut plate, mut behind) = (compositor.table.channel(entry.index).samples.clone(), behind.to_vec());
        let source = self.shares.source;
        for (pixel, covered) in self.covered.iter().enumerate() {
            let Some(covered) = covered.filter(|covered| *covered < OPAQUE_MATTE) else { continue };
            let Some(place) = window.sample_index(source.pixel_at(pixel)) else { continue };
            let (sample, rest) = (&mut plate[pixel], 1.0 - covered);
            if behind[place].is_finite() && sample.is_finite() {
                // A clean plate that is brighter than what the plate shows would leave less than no light.
                behind[place] = behind[place].min(*sample / rest);
                *sample -= rest * behind[place];
            }
        }
        Some(SplitSamples { plate, behind })
    }
}

/// Returns the sum of all mattes; `None` if there are none, or if one moves all that has alpha.
fn matte_sum(composite: &Composite) -> Option<Vec<f32>> {
    composite.holdout.as_ref()?;
    let mut sum = vec![0.0_f32; composite.source.area()];
    let mut seen = None;
    for layer in composite.matted_layers() {
        let coverage = layer.matte.coverage.as_ref()?;
        // Folds are further pictures of the same layer.
        if seen.replace(layer.moving_layer) != Some(layer.moving_layer) {
            sum.par_iter_mut().zip(coverage).for_each(|(sum, coverage)| *sum += coverage);
        }
    }
    Some(sum)
}

/// Returns a composite in which pixels with a matte belong to their layers alone: the mattes times a factor.
fn parted<'a>(
    composite: &Composite<'a>,
    covered: &[Option<f32>],
    factor: &(dyn Fn(usize) -> f32 + Sync),
) -> Composite<'a> {
    let of_layer = |layer: &WarpedLayer| {
        let part = |(pixel, covered): (usize, &Option<f32>)| {
            let own = layer.matte.coverage.as_ref().map_or(1.0, |coverage| coverage[pixel]);
            match (layer.moving_layer, covered) {
                (0, covered) => f32::from(u8::from(covered.is_none())),
                (_, Some(_)) => own * factor(pixel),
                (_, None) => 0.0,
            }
        };
        let coverage = covered.par_iter().enumerate().map(part).collect();
        let matte = MatteCoverage { coverage: Some(coverage), ..MatteCoverage::default() };
        WarpedLayer { matte, map: layer.map.clone(), visibility: layer.visibility.clone(), ..*layer }
    };
    Composite {
        view: composite.view,
        entries: Vec::new(),
        source: composite.source,
        window: composite.window,
        layers: composite.layers.iter().map(of_layer).collect(),
        holdout: Some(covered.par_iter().map(|covered| f32::from(u8::from(covered.is_some()))).collect()),
        overlap: None,
    }
}
