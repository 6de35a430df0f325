//! Warps the ranks of a Cryptomatte: coverage is gathered per id, and ids are never blended.
//!
//! In: a composite with maps, the ranks of the source, the transmittance of each layer. Out: ranks.
//!
//! The visible coverage of an id is the sum of weight · matte · coverage over the samples in the pixel's footprint;
//! layers are composited as colour is (Friedman and Jones, "Fully automatic ID mattes", SIGGRAPH 2015 posters). These
//! weights are a tent, which is never negative; colour has a sharper filter. The coverages of a pixel are therefore scaled
//! by the ratio of its alpha, as filtered with the colour, to the alpha gathered with these weights: their sum keeps to
//! the alpha beside it.

use super::composite::{Composite, WarpedLayer};
use super::disjoint_over::{Occlusion, Run};
use super::filter::{BAND, bands, footprint_bounds, footprint_taps};
use super::resampler::ResampleContext;
use super::uniform_regions::UniformRegions;
use crate::image::cryptomatte::{IdCoverage, MatteId};
use rayon::prelude::*;
use std::borrow::Cow;

/// Greatest difference of two alphas that rounding explains.
const ALPHA_ROUNDING: f32 = 1e-5;

/// One rank of the source: ids and coverages, #pixels each.
pub(super) type Rank<'a> = [&'a [f32]; 2];

/// The ranks of a Cryptomatte.
pub(super) struct CryptomatteRanks<'a> {
    /// Name of the Cryptomatte, which identifies mattes selected from it.
    pub(super) name: &'a str,
    pub(super) ranks: Vec<Rank<'a>>,
    /// Ranks of the fill plate, over the composite's window; empty if no plate fills holes.
    pub(super) filling: Vec<[Vec<f32>; 2]>,
    pub(super) alpha: &'a RankAlpha<'a>,
}

/// The alpha that the coverages of a Cryptomatte add up to.
pub(super) struct RankAlpha<'a> {
    /// #pixels of the source; `None`: opaque.
    pub(super) source: Option<Cow<'a, [f32]>>,
    /// #pixels of the composite: that of the fill plate; `None`: opaque.
    pub(super) filling: Option<Vec<f32>>,
    /// #pixels of the composite: the result, filtered and composited like colour.
    pub(super) composed: Cow<'a, [f32]>,
}

/// The inputs from which the ranks of a pixel are gathered.
struct RankSource<'a> {
    composite: &'a Composite<'a>,
    matte: &'a CryptomatteRanks<'a>,
    occlusion: &'a Occlusion,
    uniform: &'a UniformRegions,
}

/// Per-thread scratch memory, reused for every pixel.
#[derive(Default)]
struct Scratch {
    taps: Vec<(usize, f32)>,
    coverage: IdCoverage,
    /// Alpha with the weights of the coverages.
    alpha: f32,
    ranks: Vec<f32>,
}

/// Returns the warped ranks: ids and coverages, #pixels of the composite each.
pub(super) fn gathered_ranks(
    composite: &Composite,
    matte: &CryptomatteRanks,
    occlusion: &Occlusion,
    context: &ResampleContext,
) -> Vec<[Vec<f32>; 2]> {
    let width = composite.window.width as usize;
    let mut planes: Vec<_> = (0..2 * matte.ranks.len()).map(|_| context.plane(composite.window.area())).collect();
    let uniform = uniform_regions(composite, matte);
    let work = |scratch: &mut Scratch, (band, planes): (usize, &mut Vec<&mut [f32]>)| {
        for place in 0..planes[0].len() {
            let (x, y) = (place % width, band * BAND + place / width);
            let at = [composite.window.x + x as i32, composite.window.y + y as i32];
            gather(&RankSource { composite, matte, occlusion, uniform: &uniform }, at, scratch);
            planes.iter_mut().zip(&scratch.ranks).for_each(|(plane, rank)| plane[place] = *rank);
        }
    };
    bands(&mut planes, BAND * width).par_iter_mut().enumerate().for_each_init(Scratch::default, work);
    let mut planes = planes.into_iter();
    std::iter::from_fn(|| planes.next().zip(planes.next()).map(<[Vec<f32>; 2]>::from)).collect()
}

/// Finds the regions where neighbouring samples have the same ranks and the same mattes in all layers.
fn uniform_regions(composite: &Composite, matte: &CryptomatteRanks) -> UniformRegions {
    let mattes = composite.layers.iter().filter_map(|layer| layer.matte.coverage.as_deref());
    let planes = matte.ranks.as_flattened().iter().copied().chain(mattes).chain(matte.alpha.source.as_deref());
    UniformRegions::of(composite.source, &planes.collect::<Vec<_>>())
}

/// Gathers the ranks of one pixel into `scratch`.
fn gather(from: &RankSource, at: [i32; 2], scratch: &mut Scratch) {
    let RankSource { composite, matte, occlusion, .. } = *from;
    scratch.ranks.clear();
    scratch.ranks.resize(2 * matte.ranks.len(), 0.0);
    scratch.coverage.clear();
    scratch.alpha = 0.0;
    let own = composite.window.sample_index(at).expect("pixels of the composite lie in its window");
    let mut visible = 1.0;
    for Run { layers, transmittance: of_all } in occlusion.runs.iter().rev() {
        let of_parts = of_all.as_ref().map(|factors| visible * factors[own]);
        for index in layers.clone().rev() {
            let (layer, transmittance) = (&composite.layers[index], &occlusion.transmittance[index]);
            let Some(place) = layer.window.sample_index(at) else { continue };
            from.find_taps(layer, place, at, &mut scratch.taps);
            if let [(index, 1.0)] = scratch.taps[..]
                && composite.layers.len() == 1
            {
                matte.copy(index, &mut scratch.ranks);
                matte.fit_to_alpha(own, matte.alpha.of_source(index), &mut scratch.ranks);
                return;
            }
            let Scratch { taps, coverage, alpha, .. } = &mut *scratch;
            for &(index, weight) in &*taps {
                let weight = weight * visible * layer.visibility_at(at);
                *alpha += weight * matte.alpha_at(layer, index);
                from.add(layer, index, weight, coverage);
            }
            visible *= transmittance.get(place).copied().unwrap_or(0.0);
            if visible <= 0.0 {
                break;
            }
        }
        visible = of_parts.unwrap_or(visible);
        if visible <= 0.0 {
            break;
        }
    }
    if let Some(holes) = &occlusion.holes {
        matte.fill(own, holes[own], scratch);
    }
    scratch.coverage.write(&mut scratch.ranks);
    matte.fit_to_alpha(own, scratch.alpha, &mut scratch.ranks);
    limit(&mut scratch.ranks);
}

impl RankSource<'_> {
    /// Finds the samples in the footprint of a layer's pixel. If all of them are equal, one stands for all: weights that
    /// sum to 0.9999999 would leave noise in every matte.
    fn find_taps(&self, layer: &WarpedLayer, place: usize, at: [i32; 2], taps: &mut Vec<(usize, f32)>) {
        let source = self.composite.source;
        match &layer.map {
            Some(map) => {
                let one = footprint_bounds(map, place, source).and_then(|ends| self.uniform.representative(ends));
                match one {
                    Some(sample) => {
                        taps.clear();
                        taps.push((sample, 1.0));
                    }
                    None => footprint_taps(map, place, source, taps),
                }
            }
            None => {
                taps.clear();
                taps.extend(source.sample_index(at).map(|index| (index, 1.0)));
            }
        }
    }

    /// Adds the ranks of a sample, scaled by the layer's matte.
    fn add(&self, layer: &WarpedLayer, index: usize, weight: f32, coverage: &mut IdCoverage) {
        let of_layer = layer.matte.coverage.as_ref().map_or(1.0, |coverage| coverage[index]);
        for [ids, coverages] in &self.matte.ranks {
            let id = MatteId::from_sample(ids[index]);
            let share = layer.matte.share.as_ref().map_or(1.0, |share| share[index]);
            let part = self.matte.part_by_id(self.composite, layer, id).map_or(of_layer, |part| part * share);
            coverage.add(id, coverages[index] * weight * part);
        }
    }
}

impl CryptomatteRanks<'_> {
    fn copy(&self, index: usize, ranks: &mut [f32]) {
        for (rank, source) in ranks.chunks_exact_mut(2).zip(&self.ranks) {
            rank.copy_from_slice(&source.map(|channel| channel[index]));
        }
    }

    /// Scales the coverages of a pixel by the ratio of its composed alpha to `gathered`, its alpha with the weights of the coverages.
    /// Where both are the same up to rounding, as in pixels that do not move, they keep their bits.
    fn fit_to_alpha(&self, own: usize, gathered: f32, ranks: &mut [f32]) {
        let composed = self.alpha.composed[own].clamp(0.0, 1.0);
        let scale = composed / gathered;
        if (composed - gathered).abs() > ALPHA_ROUNDING && scale.is_finite() {
            ranks.iter_mut().skip(1).step_by(2).for_each(|coverage| *coverage *= scale);
        }
    }

    /// Returns the alpha of a sample, scaled by the layer's matte.
    fn alpha_at(&self, layer: &WarpedLayer, index: usize) -> f32 {
        let of_layer = layer.matte.coverage.as_ref().map_or(1.0, |coverage| coverage[index]);
        self.alpha.of_source(index) * of_layer
    }

    /// Returns 1 or 0 depending on whether a layer, including all of its parts, contains an id. Only known if its matte
    /// is selected from this Cryptomatte.
    fn part_by_id(&self, composite: &Composite, layer: &WarpedLayer, id: MatteId) -> Option<f32> {
        let holds = |layer: &WarpedLayer| {
            let (name, ids) = layer.matte.selection.as_ref()?;
            (name == self.name).then(|| ids.contains(&id))
        };
        if layer.moving_layer > 0 {
            return holds(layer).map(|holds| f32::from(u8::from(holds)));
        }
        let matted: Option<Vec<bool>> = composite.matted_layers().iter().map(holds).collect();
        matted.filter(|matted| !matted.is_empty()).map(|matted| f32::from(u8::from(!matted.contains(&true))))
    }

    fn fill(&self, place: usize, hole: f32, Scratch { coverage, alpha, .. }: &mut Scratch) {
        if hole <= 0.0 || self.filling.is_empty() {
            return;
        }
        *alpha += hole * self.alpha.filling.as_ref().map_or(1.0, |filling| filling[place]);
        for [ids, coverages] in &self.filling {
            coverage.add(MatteId::from_sample(ids[place]), coverages[place] * hole);
        }
    }
}

impl RankAlpha<'_> {
    /// Returns the alpha of a sample of the source.
    fn of_source(&self, index: usize) -> f32 {
        self.source.as_ref().map_or(1.0, |alpha| alpha[index])
    }
}

/// Limits the sum of coverages to 1, which rounding of the weights may exceed.
fn limit(ranks: &mut [f32]) {
    let sum: f32 = ranks.iter().skip(1).step_by(2).sum();
    if sum > 1.0 {
        ranks.iter_mut().skip(1).step_by(2).for_each(|coverage| *coverage /= sum);
    }
}
