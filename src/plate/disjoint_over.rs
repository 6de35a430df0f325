//! Composites layers with disjoint over: the transmittance of each layer, the remaining holes, and colour.
//!
//! In: a composite with maps, an alpha. Out: [`Occlusion`] (the transmittance of each layer, and holes), and planes of colour.
//! Method: disjoint coverage in Porter and Duff, "Compositing Digital Images", 1984.

use super::Planes;
use super::composite::{Composite, WarpedLayer};
use super::coverage::OPAQUE_COVERAGE;
use super::resampler::Resampling;
use super::visibility::dim;
use rayon::prelude::*;
use std::borrow::Cow;
use std::ops::Range;

/// Pixels per parallel task.
pub(super) const BATCH: usize = 1 << 14;

/// Number of planes that are weighted and filtered together.
const GROUP: usize = 8;

/// How the layers of a composite occlude each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Occlusion {
    /// Per layer, #pixels of its window: the factor for everything below it (for a part, for the parts below it). Empty
    /// for the lowest layer.
    pub(super) transmittance: Vec<Vec<f32>>,
    /// Runs of layers that occlude as one, from back to front.
    pub(super) runs: Vec<Run>,
    /// #pixels of the composite: the fraction that was covered before and is uncovered now; `None`: no layer moved away.
    pub(super) holes: Option<Vec<f32>>,
}

impl Occlusion {
    /// Whether a layer is made of parts.
    pub(super) fn has_parts(&self) -> bool {
        self.runs.iter().any(|run| run.transmittance.is_some())
    }
}

/// One layer, or the parts of one layer.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Range of layer indices.
    pub(super) layers: Range<usize>,
    /// For parts, the factor for everything below them, #pixels of the composite; `None`: the run is a single layer,
    /// whose own factor applies.
    pub(super) transmittance: Option<Vec<f32>>,
}

/// The visible amount of a layer: #pixels of its window each, 0 to 1.
struct Shown {
    /// Warped coverage.
    coverage: Vec<f32>,
    /// Coverage times alpha.
    opacity: Vec<f32>,
}

/// Computes the occlusion in a composite. `alpha`: #pixels of the source, the alpha of its colour; `None`: opaque.
///
/// Layers cut from one picture meet at its soft edges: where one has 0.7 of a pixel, the rest has 0.3. A layer therefore covers first
/// the hole that it left, and only the excess hides what is below. A layer that does not move thus reproduces the picture.
pub(super) fn occlusion(composite: &Composite, alpha: Option<&[f32]>, by: Resampling) -> Occlusion {
    let mut filled = composite.holdout.as_ref().map(|holdout| not_held_out(composite, holdout, by));
    let mut transmittance = background(composite, (alpha, by), filled.as_mut());
    let matted = composite.runs_from(transmittance.len());
    let alone = |index: usize| Run { layers: index..index + 1, transmittance: None };
    let mut runs: Vec<Run> = (0..transmittance.len()).map(alone).collect();
    for layers in matted {
        if composite.layers[layers.start].group.is_some() {
            let (factors, of_all) = parts(composite, layers.clone(), (alpha, by));
            transmittance.extend(factors);
            let factor = over_all(of_all, filled.as_mut());
            runs.push(Run { layers, transmittance: Some(factor) });
        } else {
            let layer = &composite.layers[layers.start];
            let shown = shown(composite, layer, alpha, by);
            transmittance.push(match &mut filled {
                None => transmitted(shown.opacity),
                Some(filled) => over_filled(composite, layer, &shown, filled),
            });
            runs.push(Run { layers, transmittance: None });
        }
    }
    let holes = filled.map(|filled| filled.iter().map(|filled| 1.0 - filled).collect());
    Occlusion { transmittance, runs, holes }
}

/// Computes the factors of the background and its folds, and sets `filled` to their coverage.
fn background(
    composite: &Composite,
    (alpha, by): (Option<&[f32]>, Resampling),
    filled: Option<&mut Vec<f32>>,
) -> Vec<Vec<f32>> {
    let folds = composite.background_folds();
    if let Some(filled) = filled {
        for layer in folds {
            let mut coverage = shown(composite, layer, alpha, by).coverage;
            each_pixel(composite, layer, filled, &mut coverage, |_, filled, coverage| {
                *filled = (*filled + *coverage).min(1.0);
            });
        }
    }
    let above = composite.layers[..=folds.len()].iter().skip(1);
    let factors = above.map(|layer| transmitted(shown(composite, layer, alpha, by).opacity));
    std::iter::once(Vec::new()).chain(factors).collect()
}

/// Computes the factor of a layer over the coverage below it, and adds the layer's coverage to `filled`.
fn over_filled(composite: &Composite, layer: &WarpedLayer, shown: &Shown, filled: &mut [f32]) -> Vec<f32> {
    let Shown { coverage, opacity } = shown;
    let mut factors = vec![1.0; layer.window.area()];
    each_pixel(composite, layer, filled, &mut factors, |at, filled, factor| {
        *factor = transmittance(*filled, coverage[at], opacity[at]);
        *filled = (*filled + coverage[at]).min(1.0);
    });
    factors
}

/// Computes the factors of the parts among each other, and their combined coverage and opacity: #pixels of the composite.
fn parts(
    composite: &Composite,
    layers: Range<usize>,
    (alpha, by): (Option<&[f32]>, Resampling),
) -> (Vec<Vec<f32>>, Shown) {
    let empty = || vec![0.0; composite.window.area()];
    let mut all = Shown { coverage: empty(), opacity: empty() };
    let mut factor = |layer: &WarpedLayer| {
        let mut own = shown(composite, layer, alpha, by);
        let factors = over_filled(composite, layer, &own, &mut all.coverage);
        each_pixel(composite, layer, &mut all.opacity, &mut own.opacity, |at, all, own| {
            *all = *all * factors[at] + *own;
        });
        factors
    };
    (composite.layers[layers].iter().map(&mut factor).collect(), all)
}

/// Computes the combined factor of all parts.
fn over_all(Shown { coverage, opacity }: Shown, filled: Option<&mut Vec<f32>>) -> Vec<f32> {
    let Some(filled) = filled else { return transmitted(opacity) };
    let pixels = filled.par_iter_mut().zip(coverage).zip(opacity).with_min_len(BATCH);
    let factor = |((filled, coverage), opacity): ((&mut f32, f32), f32)| {
        let factor = transmittance(*filled, coverage, opacity);
        *filled = (*filled + coverage).min(1.0);
        factor
    };
    pixels.map(factor).collect()
}

/// Computes the fraction of every pixel that the background covers before layers are composited over it.
fn not_held_out(composite: &Composite, holdout: &[f32], by: Resampling) -> Vec<f32> {
    let source = Planes { window: composite.source, planes: vec![holdout] };
    let background = composite.background();
    let held_out = resampled(background, &source, by).swap_remove(0);
    let mut left: Vec<f32> = held_out.par_iter().map(|held_out| 1.0 - held_out.clamp(0.0, 1.0)).collect();
    background.visibility.iter().for_each(|visibility| dim(&mut left, visibility));
    left
}

fn shown(composite: &Composite, layer: &WarpedLayer, alpha: Option<&[f32]>, by: Resampling) -> Shown {
    let coverage = match &layer.matte.coverage {
        Some(coverage) => layer.reached(composite, coverage),
        None => Cow::Owned(vec![1.0; layer.reach.area()]),
    };
    let mut planes = vec![Cow::Borrowed(&coverage[..])];
    planes.extend(alpha.map(|alpha| Cow::Owned(weighted(&layer.reached(composite, alpha), &coverage))));
    let source = Planes { window: layer.reach, planes: planes.iter().map(|plane| &plane[..]).collect() };
    let mut seen = resampled(layer, &source, by);
    seen.iter_mut().for_each(|plane| plane.iter_mut().for_each(|sample| *sample = sample.clamp(0.0, 1.0)));
    dim_all(layer, &mut seen);
    let opacity = if alpha.is_some() { seen.swap_remove(1) } else { seen[0].clone() };
    Shown { coverage: seen.swap_remove(0), opacity }
}

/// Composites planes of colour: #pixels of the composite's window each.
pub(super) fn colors(
    composite: &Composite,
    planes: &[Cow<[f32]>],
    occlusion: &Occlusion,
    by: Resampling,
) -> Vec<Vec<f32>> {
    let groups = planes.chunks(GROUP);
    groups.flat_map(|planes| ColorGroup { composite, planes, occlusion, by }.composited()).collect()
}

/// Planes of colour that are composited together.
struct ColorGroup<'a> {
    composite: &'a Composite<'a>,
    planes: &'a [Cow<'a, [f32]>],
    occlusion: &'a Occlusion,
    by: Resampling<'a>,
}

impl ColorGroup<'_> {
    fn composited(&self) -> Vec<Vec<f32>> {
        let Self { composite, planes, occlusion, .. } = *self;
        let mut result: Option<Vec<Vec<f32>>> = None;
        for Run { layers, transmittance: of_all } in &occlusion.runs {
            let Some(of_all) = of_all else {
                self.lay(layers.start, &mut result);
                continue;
            };
            let mut own = Some(vec![vec![0.0; composite.window.area()]; planes.len()]);
            layers.clone().for_each(|index| self.lay(index, &mut own));
            let Some(result) = &mut result else {
                result = own;
                continue;
            };
            for (below, above) in result.iter_mut().zip(own.into_iter().flatten()) {
                let pixels = below.par_iter_mut().zip(above).zip(of_all).with_min_len(BATCH);
                pixels.for_each(|((below, above), transmittance)| *below = over(above, *below, *transmittance));
            }
        }
        result.unwrap_or_default()
    }

    /// Composites a layer over the accumulated planes.
    fn lay(&self, index: usize, result: &mut Option<Vec<Vec<f32>>>) {
        let Self { composite, planes, occlusion, by } = *self;
        let (layer, transmittance) = (&composite.layers[index], &occlusion.transmittance[index]);
        let reached = planes.iter().map(|plane| layer.reached(composite, plane));
        let covered: Vec<Cow<[f32]>> = match &layer.matte.coverage {
            Some(coverage) => {
                let coverage = layer.reached(composite, coverage);
                reached.map(|plane| Cow::Owned(weighted(&plane, &coverage))).collect()
            }
            None => reached.collect(),
        };
        let source = Planes { window: layer.reach, planes: covered.iter().map(|plane| &plane[..]).collect() };
        let mut seen = resampled(layer, &source, by);
        dim_all(layer, &mut seen);
        match result {
            None if layer.window == composite.window => *result = Some(seen),
            None => {
                let spread = |plane: &Vec<f32>| layer.window.resized_samples(plane, composite.window, 0.0);
                *result = Some(seen.iter().map(spread).collect());
            }
            Some(result) => {
                for (plane, mut seen) in result.iter_mut().zip(seen) {
                    each_pixel(composite, layer, plane, &mut seen, |at, below, above| {
                        *below = over(*above, *below, transmittance[at]);
                    });
                }
            }
        }
    }
}

/// Dims what something of the scene covers.
fn dim_all(layer: &WarpedLayer, planes: &mut [Vec<f32>]) {
    if let Some(visibility) = &layer.visibility {
        planes.iter_mut().for_each(|plane| dim(plane, visibility));
    }
}

/// Resamples planes of the source over a layer's window.
fn resampled(layer: &WarpedLayer, source: &Planes, by: Resampling) -> Vec<Vec<f32>> {
    match &layer.map {
        Some(map) => by.seen(map, source),
        None => source.planes.iter().map(|plane| source.window.resized_samples(plane, layer.window, 0.0)).collect(),
    }
}

/// Visits the pixels of a layer's window together with those of the composite, passing the index in the layer's window and both values.
fn each_pixel(
    composite: &Composite,
    layer: &WarpedLayer,
    plane: &mut [f32],
    own: &mut [f32],
    visit: impl Fn(usize, &mut f32, &mut f32) + Sync,
) {
    let (width, own_width) = (composite.window.width as usize, layer.window.width as usize);
    if layer.window.area() == 0 {
        return;
    }
    let top = (layer.window.y - composite.window.y) as usize * width;
    let left = (layer.window.x - composite.window.x) as usize;
    let rows = plane[top..].par_chunks_mut(width).zip(own.par_chunks_mut(own_width)).enumerate();
    rows.for_each(|(y, (row, own))| {
        for (x, (below, above)) in row[left..].iter_mut().zip(own).enumerate() {
            visit(y * own_width + x, below, above);
        }
    });
}

/// Returns 1 − opacity, and exactly 0 where the opacity is 1 up to rounding.
fn transmitted(mut opacity: Vec<f32>) -> Vec<f32> {
    let left = |opacity: f32| if opacity > OPAQUE_COVERAGE { 0.0 } else { 1.0 - opacity };
    opacity.par_iter_mut().with_min_len(BATCH).for_each(|opacity| *opacity = left(*opacity));
    opacity
}

/// Returns the transmittance of a layer with this coverage and opacity over a pixel of which `filled` is already covered.
pub(crate) fn transmittance(filled: f32, coverage: f32, opacity: f32) -> f32 {
    let overlap = filled + coverage - 1.0;
    if overlap <= 0.0 || filled <= 0.0 || coverage <= 0.0 {
        return 1.0;
    }
    (1.0 - overlap / filled * (opacity / coverage)).clamp(0.0, 1.0)
}

/// Composites a sample over another. A hidden sample is ignored, even if it is NaN.
pub(crate) fn over(above: f32, below: f32, transmittance: f32) -> f32 {
    if transmittance == 0.0 { above } else { above + below * transmittance }
}

/// Multiplies samples by coverage. An uncovered sample is ignored, even if it is NaN.
fn weighted(samples: &[f32], coverage: &[f32]) -> Vec<f32> {
    let product = |(&sample, &coverage): (&f32, &f32)| if coverage == 0.0 { 0.0 } else { sample * coverage };
    samples.par_iter().zip(coverage).with_min_len(BATCH).map(product).collect()
}
