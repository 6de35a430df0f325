//! Ranks of a Cryptomatte after a warp: coverage is gathered an id at a time, ids are never mixed.
//!
//! In: a composite with maps, ranks of the source, the transmittance of each layer. Out: ranks.
//!
//! What is seen of an id is the sum, over the samples below the pixel's footprint, of weight · matte · coverage,
//! layer over layer as colour (Friedman and Jones, "Fully automatic ID mattes", SIGGRAPH 2015 posters).

use super::composite::{Composite, WarpedLayer};
use super::disjoint_over::{Occlusion, Run};
use super::filter::{BAND, bands, footprint_bounds, footprint_taps};
use super::resampler::ResampleContext;
use super::uniform_regions::UniformRegions;
use crate::image::cryptomatte::{Coverage, MatteId};
use rayon::prelude::*;

/// One rank of the source: ids and coverage, #pixels each.
pub(super) type Rank<'a> = [&'a [f32]; 2];

/// What of a Cryptomatte's ranks each pixel holds.
pub(super) struct CryptomatteRanks<'a> {
    /// Its name, by which mattes that are selected from it are known.
    pub(super) name: &'a str,
    pub(super) ranks: Vec<Rank<'a>>,
    /// Ranks of what fills holes, over the composite's window; empty where nothing does.
    pub(super) filling: Vec<[Vec<f32>; 2]>,
}

/// What the pixels of a composite are gathered from.
struct RankSource<'a> {
    matte: &'a CryptomatteRanks<'a>,
    occlusion: &'a Occlusion,
    uniform: &'a UniformRegions,
}

/// Memory that a thread uses again for every pixel.
#[derive(Default)]
struct Scratch {
    taps: Vec<(usize, f32)>,
    coverage: Coverage,
    ranks: Vec<f32>,
}

/// Ranks after the warp: for each id and coverage, #pixels of the composite.
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
            gather(composite, &RankSource { matte, occlusion, uniform: &uniform }, at, scratch);
            planes.iter_mut().zip(&scratch.ranks).for_each(|(plane, rank)| plane[place] = *rank);
        }
    };
    bands(&mut planes, BAND * width).par_iter_mut().enumerate().for_each_init(Scratch::default, work);
    let mut planes = planes.into_iter();
    std::iter::from_fn(|| planes.next().zip(planes.next()).map(<[Vec<f32>; 2]>::from)).collect()
}

/// Where ranks and the mattes of all layers are the same in neighbouring samples.
fn uniform_regions(composite: &Composite, matte: &CryptomatteRanks) -> UniformRegions {
    let mattes = composite.layers.iter().filter_map(|layer| layer.matte.coverage.as_deref());
    UniformRegions::of(composite.source, &matte.ranks.as_flattened().iter().copied().chain(mattes).collect::<Vec<_>>())
}

/// Leaves the ranks of one pixel in `scratch`.
fn gather(composite: &Composite, from: &RankSource, at: [i32; 2], scratch: &mut Scratch) {
    let RankSource { matte, occlusion, .. } = *from;
    scratch.ranks.clear();
    scratch.ranks.resize(2 * matte.ranks.len(), 0.0);
    scratch.coverage.clear();
    let own = composite.window.place_of(at).expect("pixels of the composite lie in its window");
    let mut visible = 1.0;
    for Run { layers, transmittance: of_all } in occlusion.runs.iter().rev() {
        let of_parts = of_all.as_ref().map(|factors| visible * factors[own]);
        for index in layers.clone().rev() {
            let (layer, transmittance) = (&composite.layers[index], &occlusion.transmittance[index]);
            let Some(place) = layer.window.place_of(at) else { continue };
            find_taps(composite, (from.uniform, layer), (place, at), &mut scratch.taps);
            if let [(index, 1.0)] = scratch.taps[..]
                && composite.layers.len() == 1
            {
                matte.copy(index, &mut scratch.ranks);
                return;
            }
            for &(index, weight) in &scratch.taps {
                matte.add(composite, layer, (index, weight * visible), &mut scratch.coverage);
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
        matte.fill(own, holes[own], &mut scratch.coverage);
    }
    scratch.coverage.write(&mut scratch.ranks);
    limit(&mut scratch.ranks);
}

/// Samples below a pixel of a layer. Where all hold the same, one of them stands for all: weights that sum to 0.9999999
/// would leave noise in every matte.
fn find_taps(
    composite: &Composite,
    (uniform, layer): (&UniformRegions, &WarpedLayer),
    (place, at): (usize, [i32; 2]),
    taps: &mut Vec<(usize, f32)>,
) {
    match &layer.map {
        Some(map) => {
            let one = footprint_bounds(map, place, composite.source).and_then(|ends| uniform.representative(ends));
            match one {
                Some(sample) => {
                    taps.clear();
                    taps.push((sample, 1.0));
                }
                None => footprint_taps(map, place, composite.source, taps),
            }
        }
        None => {
            taps.clear();
            taps.extend(composite.source.place_of(at).map(|index| (index, 1.0)));
        }
    }
}

impl CryptomatteRanks<'_> {
    fn copy(&self, index: usize, ranks: &mut [f32]) {
        for (rank, source) in ranks.chunks_exact_mut(2).zip(&self.ranks) {
            rank.copy_from_slice(&source.map(|channel| channel[index]));
        }
    }

    /// Adds the ranks of a sample, as far as they belong to a layer.
    fn add(&self, composite: &Composite, layer: &WarpedLayer, (index, weight): (usize, f32), coverage: &mut Coverage) {
        let of_layer = layer.matte.coverage.as_ref().map_or(1.0, |coverage| coverage[index]);
        for [ids, coverages] in &self.ranks {
            let id = MatteId::from_sample(ids[index]);
            let share = layer.matte.share.as_ref().map_or(1.0, |share| share[index]);
            let part = self.part_by_id(composite, layer, id).map_or(of_layer, |part| part * share);
            coverage.add(id, coverages[index] * weight * part);
        }
    }

    /// Whether a layer, with all of its parts, has an id, 1 or 0: known where its matte is selected from this very Cryptomatte.
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

    fn fill(&self, place: usize, hole: f32, coverage: &mut Coverage) {
        if hole <= 0.0 {
            return;
        }
        for [ids, coverages] in &self.filling {
            coverage.add(MatteId::from_sample(ids[place]), coverages[place] * hole);
        }
    }
}

/// Keeps the sum of coverage at 1 or below: weights are rounded.
fn limit(ranks: &mut [f32]) {
    let sum: f32 = ranks.iter().skip(1).step_by(2).sum();
    if sum > 1.0 {
        ranks.iter_mut().skip(1).step_by(2).for_each(|coverage| *coverage /= sum);
    }
}
