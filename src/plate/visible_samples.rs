//! Selects the one source sample that each output pixel shows, for data that must not be blended.
//!
//! In: a composite with maps, alpha. Out: one [`VisibleSample`] per pixel; copies of samples.
//!
//! As for colour, the front layer wins, so depth and ids belong to the visible surface.

use super::WarpMap;
use super::composite::{Composite, WarpedLayer};
use super::filter::{BAND, NOWHERE, bands, copy_samples, nearest_in_row};
use super::warp_map::HALF;
use rayon::prelude::*;

/// Width of a tile, in columns.
const TILE: usize = 64;

/// The source of a pixel's data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum VisibleSample {
    /// A sample of a layer.
    Sample {
        /// Index into the composite's layers.
        layer: u16,
        /// Index into the source window.
        index: u32,
    },
    /// Uncovered: a layer moved away.
    Hole,
    /// Outside the picture.
    Nothing,
}

impl VisibleSample {
    /// Converts an index for a composite of one layer.
    fn of_only_layer(index: u32) -> Self {
        if index == NOWHERE { Self::Nothing } else { Self::Sample { layer: 0, index } }
    }

    /// Returns the index into the source window; [`NOWHERE`] if no sample is visible.
    fn index(&self) -> u32 {
        if let Self::Sample { index, .. } = *self { index } else { NOWHERE }
    }
}

/// A layer's contribution to one pixel.
struct Candidate {
    sample: VisibleSample,
    /// Fraction of the source pixel that belongs to the layer.
    coverage: f32,
    /// Coverage times alpha.
    opacity: f32,
}

/// Returns the visible sample of every pixel of a composite. `alpha`: #pixels of the source.
pub(super) fn visible_samples(composite: &Composite, alpha: Option<&[f32]>) -> Vec<VisibleSample> {
    let window = composite.window;
    let width = window.width as usize;
    let mut visible = vec![VisibleSample::Nothing; window.area()];
    let only_map = only_map(composite);
    visible.par_chunks_mut(width).enumerate().for_each_init(Vec::new, |indices, (row, visible)| {
        let y = window.y + row as i32;
        if let Some(map) = only_map {
            indices.resize(width, NOWHERE);
            nearest_in_row(map, [0, row], composite.source, indices);
            visible.iter_mut().zip(indices).for_each(|(seen, &mut index)| *seen = VisibleSample::of_only_layer(index));
        } else {
            visible.iter_mut().zip(window.x..).for_each(|(seen, x)| *seen = visible_at(composite, [x, y], alpha));
        }
    });
    visible
}

/// Returns the map if a single layer moves the whole picture and covers the whole composite.
fn only_map<'a>(composite: &'a Composite) -> Option<&'a WarpMap> {
    match &composite.layers[..] {
        [only] if only.matte.coverage.is_none() && only.window == composite.window => only.map.as_deref(),
        _ => None,
    }
}

fn visible_at(composite: &Composite, at: [i32; 2], alpha: Option<&[f32]>) -> VisibleSample {
    if let [only] = &composite.layers[..] {
        return candidate(composite, (0, only), at, None).map_or(VisibleSample::Nothing, |candidate| candidate.sample);
    }
    let mut sum = 0.0;
    let (mut best, mut background): (Option<Candidate>, Option<VisibleSample>) = (None, None);
    // The accumulated opacity of the parts of one layer, and the front sample of the part with the highest.
    let mut parts: Option<(usize, f32, f32, VisibleSample)> = None;
    // Front to back.
    for (index, layer) in composite.layers.iter().enumerate().rev() {
        let Some(candidate) = candidate(composite, (index, layer), at, alpha) else { continue };
        if candidate.opacity >= HALF {
            return candidate.sample;
        }
        if let Some(group) = layer.group {
            parts = Some(match parts {
                Some((own, all, most, seen)) if own == group && candidate.opacity <= most => {
                    (own, all + candidate.opacity, most, seen)
                }
                Some((own, all, _, _)) if own == group => {
                    (own, all + candidate.opacity, candidate.opacity, candidate.sample)
                }
                _ => (group, candidate.opacity, candidate.opacity, candidate.sample),
            });
            if let Some((.., seen)) = parts.filter(|(_, all, ..)| *all >= HALF) {
                return seen;
            }
        }
        // Alpha does not matter for the background: its data are valid where it is transparent.
        if layer.moving_layer == 0 && candidate.coverage >= HALF {
            background = background.or(Some(candidate.sample));
        }
        sum += candidate.coverage;
        if best.as_ref().is_none_or(|best| candidate.coverage > best.coverage) {
            best = Some(candidate);
        }
    }
    match best {
        _ if let Some(background) = background => background,
        Some(best) if sum >= HALF => best.sample,
        _ if composite.is_held_out_at(at) || composite.background().visibility_at(at) < HALF => VisibleSample::Hole,
        _ => VisibleSample::Nothing,
    }
}

fn candidate(
    composite: &Composite,
    (index, layer): (usize, &WarpedLayer),
    at: [i32; 2],
    alpha: Option<&[f32]>,
) -> Option<Candidate> {
    let source = composite.source_of(layer, at)?;
    let coverage = layer.matte.coverage.as_ref().map_or(1.0, |coverage| coverage[source]) * layer.visibility_at(at);
    let opacity = coverage * alpha.map_or(1.0, |alpha| alpha[source]);
    (coverage > 0.0).then_some(Candidate {
        sample: VisibleSample::Sample { layer: index as u16, index: source as u32 },
        coverage,
        opacity,
    })
}

/// Copies the visible samples of several planes, each given with a value for empty pixels. Works plane by plane on
/// tiles, which stay in the cache and the TLB.
pub(super) fn copied(visible: &[VisibleSample], width: usize, sources: &[(&[f32], f32)], copies: &mut [Vec<f32>]) {
    if visible.is_empty() || copies.is_empty() {
        return;
    }
    let bands = bands(copies, BAND * width);
    bands.into_par_iter().zip(visible.par_chunks(BAND * width)).for_each_init(
        Vec::new,
        |indices, (mut band, visible)| {
            for column in (0..width).step_by(TILE) {
                let columns = column..width.min(column + TILE);
                indices.clear();
                for row in visible.chunks_exact(width) {
                    indices.extend(row[columns.clone()].iter().map(VisibleSample::index));
                }
                for (&(source, empty), copy) in sources.iter().zip(&mut band) {
                    for (row, indices) in copy.chunks_exact_mut(width).zip(indices.chunks_exact(columns.len())) {
                        copy_samples(source, indices, empty, &mut row[columns.clone()]);
                    }
                }
            }
        },
    );
}
