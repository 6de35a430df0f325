//! Layers composited with disjoint over: how much each lets through, what stays uncovered, and colour.
//!
//! In: a composite with maps, an alpha. Out: [`Occlusion`]: the transmittance of each layer, and holes; planes of colour.
//!
//! Layers of one picture meet at its soft edges: where a pixel belongs to one of them by 0.7, the rest has 0.3 of it.
//! So the first thing a layer covers is the hole it left (Porter and Duff, "Compositing Digital Images", 1984, call such
//! coverage disjoint), and only what exceeds the hole hides what lies below. A layer that stays gives the picture back.

use super::Planes;
use super::composite::{Composite, WarpedLayer};
use super::resampler::Resampling;
use rayon::prelude::*;
use std::borrow::Cow;

/// Pixels that a task takes.
pub(super) const BATCH: usize = 1 << 14;

/// Coverage above this is whole: weights of a filter sum to 1 but for rounding.
const WHOLE: f32 = 1.0 - 1e-5;

/// Planes that are weighted and filtered together.
const GROUP: usize = 8;

/// What layers hide of each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Occlusion {
    /// A layer each: #pixels of the layer's window, the factor for everything below it; empty for the lowest.
    pub(super) transmittance: Vec<Vec<f32>>,
    /// #pixels of the composite: how much of a pixel nothing covers though something was there; `None`: no layer left.
    pub(super) holes: Option<Vec<f32>>,
}

/// What a layer shows of itself: #pixels of its window each, 0 to 1.
struct Shown {
    /// Where it lands.
    coverage: Vec<f32>,
    /// Coverage times alpha.
    opacity: Vec<f32>,
}

/// Occlusion in a composite. `alpha`: #pixels of the source, the coverage of its colour; `None`: it is 1.
pub(super) fn occlusion(composite: &Composite, alpha: Option<&[f32]>, by: Resampling) -> Occlusion {
    let Some(holdout) = &composite.holdout else {
        return occlusion_without_holdout(composite, alpha, by);
    };
    let held_out = resampled(composite, composite.background(), &[Cow::Borrowed(holdout)], by).swap_remove(0);
    let mut filled: Vec<f32> = held_out.par_iter().map(|held_out| 1.0 - held_out.clamp(0.0, 1.0)).collect();
    let mut factors = vec![Vec::new()];
    for (index, layer) in composite.background_folds().iter().enumerate() {
        let Shown { mut coverage, opacity } = shown(composite, layer, alpha, by);
        each_pixel(composite, layer, &mut filled, &mut coverage, |_, filled, coverage| {
            *filled = (*filled + *coverage).min(1.0);
        });
        factors.extend((index > 0).then(|| transmitted(opacity)));
    }
    if factors.len() <= composite.background_folds().len() {
        factors.push(transmitted(shown(composite, composite.background(), alpha, by).opacity));
    }
    factors.extend(composite.matted_layers().iter().map(|layer| {
        let Shown { coverage, opacity } = shown(composite, layer, alpha, by);
        let mut factors = vec![1.0; layer.window.area()];
        each_pixel(composite, layer, &mut filled, &mut factors, |at, filled, factor| {
            *factor = transmittance(*filled, coverage[at], opacity[at]);
            *filled = (*filled + coverage[at]).min(1.0);
        });
        factors
    }));
    let holes = filled.iter().map(|filled| 1.0 - filled).collect();
    Occlusion { transmittance: factors, holes: Some(holes) }
}

fn occlusion_without_holdout(composite: &Composite, alpha: Option<&[f32]>, by: Resampling) -> Occlusion {
    let above = composite.layers.iter().skip(1);
    let factors = above.map(|layer| transmitted(shown(composite, layer, alpha, by).opacity));
    Occlusion { transmittance: std::iter::once(Vec::new()).chain(factors).collect(), holes: None }
}

fn shown(composite: &Composite, layer: &WarpedLayer, alpha: Option<&[f32]>, by: Resampling) -> Shown {
    let ones;
    let coverage = match &layer.matte.coverage {
        Some(coverage) => coverage,
        None => {
            ones = vec![1.0; composite.source.area()];
            &ones
        }
    };
    let mut planes = vec![Cow::Borrowed(&coverage[..])];
    planes.extend(alpha.map(|alpha| Cow::Owned(weighted(alpha, coverage))));
    let mut seen = resampled(composite, layer, &planes, by);
    seen.iter_mut().for_each(|plane| plane.iter_mut().for_each(|sample| *sample = sample.clamp(0.0, 1.0)));
    let opacity = if alpha.is_some() { seen.swap_remove(1) } else { seen[0].clone() };
    Shown { coverage: seen.swap_remove(0), opacity }
}

/// Planes of colour, composited: #pixels of the composite's window each.
pub(super) fn colors(
    composite: &Composite,
    planes: &[Cow<[f32]>],
    occlusion: &Occlusion,
    by: Resampling,
) -> Vec<Vec<f32>> {
    let groups = planes.chunks(GROUP);
    groups.flat_map(|group| color_group(composite, group, occlusion, by)).collect()
}

fn color_group(composite: &Composite, planes: &[Cow<[f32]>], occlusion: &Occlusion, by: Resampling) -> Vec<Vec<f32>> {
    let mut result: Option<Vec<Vec<f32>>> = None;
    for (layer, transmittance) in composite.layers.iter().zip(&occlusion.transmittance) {
        let covered: Vec<Cow<[f32]>> = match &layer.matte.coverage {
            Some(coverage) => planes.iter().map(|plane| Cow::Owned(weighted(plane, coverage))).collect(),
            None => planes.iter().map(|plane| Cow::Borrowed(&plane[..])).collect(),
        };
        let seen = resampled(composite, layer, &covered, by);
        match &mut result {
            None if layer.window == composite.window => result = Some(seen),
            None => {
                let spread = |plane: &Vec<f32>| layer.window.over(plane, composite.window, 0.0);
                result = Some(seen.iter().map(spread).collect());
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
    result.unwrap_or_default()
}

/// Planes of the source in a layer's window.
fn resampled(composite: &Composite, layer: &WarpedLayer, planes: &[Cow<[f32]>], by: Resampling) -> Vec<Vec<f32>> {
    let source = Planes { window: composite.source, planes: planes.iter().map(|plane| &plane[..]).collect() };
    match &layer.map {
        Some(map) => by.seen(map, &source),
        None => planes.iter().map(|plane| composite.source.over(plane, layer.window, 0.0)).collect(),
    }
}

/// Visits a plane of the composite and one of a layer's window pixel by pixel: index in the layer's window, both values.
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

/// What opacity lets through; rounding of what is opaque lets nothing through.
fn transmitted(mut opacity: Vec<f32>) -> Vec<f32> {
    let left = |opacity: f32| if opacity > WHOLE { 0.0 } else { 1.0 - opacity };
    opacity.par_iter_mut().with_min_len(BATCH).for_each(|opacity| *opacity = left(*opacity));
    opacity
}

/// What a layer with that coverage and opacity lets through of a pixel of which `filled` is taken below it.
pub(crate) fn transmittance(filled: f32, coverage: f32, opacity: f32) -> f32 {
    let overlap = filled + coverage - 1.0;
    if overlap <= 0.0 || filled <= 0.0 || coverage <= 0.0 {
        return 1.0;
    }
    (1.0 - overlap / filled * (opacity / coverage)).clamp(0.0, 1.0)
}

/// A sample over another. What cannot be seen does not count, not even NaN.
pub(crate) fn over(above: f32, below: f32, transmittance: f32) -> f32 {
    if transmittance == 0.0 { above } else { above + below * transmittance }
}

/// Samples times coverage. What is not covered does not count, not even NaN.
fn weighted(samples: &[f32], coverage: &[f32]) -> Vec<f32> {
    let product = |(&sample, &coverage): (&f32, &f32)| if coverage == 0.0 { 0.0 } else { sample * coverage };
    samples.par_iter().zip(coverage).with_min_len(BATCH).map(product).collect()
}
