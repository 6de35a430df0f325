//! Lays out the composites of a plate: the coverage, output window and map of every layer.
//!
//! In: the channels of a plate, and its moving layers or one map for all. Out: [`Composite`]s, ready to be drawn.

use super::channel_table::ChannelTable;
use super::composite::{Composite, MIN_VISIBLE, WarpedLayer};
use super::matte::{MatteCoverage, MatteRegion, matte_coverage};
use super::moving_layer::MovingLayer;
use super::warp_map::nearest_source;
use super::{Matte, PlateError, WarpMap};
use crate::space::{FrameSize, PixelRect};
use crate::spelling::pluralised;
use rayon::prelude::*;
use std::sync::Arc;

/// Returns the composites of a plate, one per view and data window, without layers.
pub(super) fn composites<'a>(table: &'a ChannelTable) -> Vec<Composite<'a>> {
    let mut composites: Vec<Composite> = Vec::new();
    for entry in &table.entries {
        let (view, source) = (entry.name.view.as_deref(), table.window(entry.index));
        match composites.iter_mut().find(|composite| composite.view == view && composite.source == source) {
            Some(composite) => composite.entries.push(entry),
            None => composites.push(Composite {
                view,
                entries: vec![entry],
                source,
                window: source,
                layers: Vec::new(),
                holdout: None,
                overlap: None,
            }),
        }
    }
    composites
}

/// Assigns every moving layer the coverage of its matte, and the remainder to the background.
pub(super) fn assign_coverage(
    composite: &mut Composite,
    table: &ChannelTable,
    moving_layers: &[MovingLayer],
) -> Result<(), PlateError> {
    let region = MatteRegion { view: composite.view, window: composite.source };
    let mut mattes = vec![MatteCoverage::default()];
    for moving_layer in moving_layers.iter().skip(1) {
        let matte = moving_layer.matte.expect("only the background has no matte");
        mattes.push(matte_coverage(table, (moving_layer.name, matte), region)?);
    }
    let is_all = |layer: &MovingLayer| layer.matte.is_some_and(Matte::is_all);
    let taken = mattes.iter().zip(moving_layers).skip(1).filter(|(_, layer)| !is_all(layer));
    composite.holdout = holdout(taken.map(|(matte, _)| matte));
    composite.overlap = overlap(&mattes, moving_layers, composite.source);
    let is_all_moved = moving_layers.iter().any(is_all);
    mattes[0].coverage = match &composite.holdout {
        _ if is_all_moved => Some(vec![0.0; composite.source.area()]),
        Some(holdout) => Some(holdout.iter().map(|held_out| 1.0 - held_out).collect()),
        None => None,
    };
    let source = composite.source;
    let layer = |(moving_layer, matte): (usize, MatteCoverage)| {
        let covered = matte.coverage.as_ref().filter(|_| moving_layer > 0);
        let reach = covered.map_or(source, |coverage| bounds(coverage, source).grown(1).intersection(source));
        let group = group_of(moving_layers, moving_layer);
        WarpedLayer { moving_layer, group, matte, reach, window: source, map: None, visibility: None }
    };
    composite.layers = mattes.into_iter().enumerate().map(layer).collect();
    Ok(())
}

/// Returns the index of the first part of the same layer.
fn group_of(moving_layers: &[MovingLayer], index: usize) -> Option<usize> {
    let is_part = |layer: &MovingLayer| matches!(layer.matte, Some(Matte::Part { .. }));
    let own = moving_layers.get(index).filter(|layer| is_part(layer))?;
    moving_layers.iter().position(|layer| is_part(layer) && layer.name == own.name)
}

/// Returns the data window under a map: all pixels that show some of the source. A plate that fills its frame keeps its window.
pub(super) fn window_under(composite: &Composite, map: &WarpMap) -> PixelRect {
    let source_window = composite.source;
    if source_window.union(map.frame.window()) == source_window {
        return source_window.intersection(map.window);
    }
    let seen: Vec<f32> = (0..map.window.area())
        .into_par_iter()
        .map(|index| {
            let source = nearest_source(map.window.pixel_at(index), map.offsets[index]);
            f32::from(u8::from(source.is_some_and(|source| source_window.sample_index(source).is_some())))
        })
        .collect();
    let seen = bounds(&seen, map.window);
    // One pixel more on every side for the support of the filter.
    let seen = if seen.area() == 0 { seen } else { seen.grown(1) };
    seen.intersection(map.frame.window().union(source_window))
}

/// Computes the windows of the layers, and from them the data windows of the result. A plate that fills its frame keeps
/// its window; other windows may grow up to the frame.
pub(super) fn assign_windows(composites: &mut [Composite], frame: FrameSize, moving_layers: &[MovingLayer]) {
    for composite in composites.iter_mut() {
        for layer in &mut composite.layers {
            let covered = match &layer.matte.coverage {
                Some(coverage) if layer.moving_layer > 0 => bounds(coverage, composite.source),
                _ => composite.source,
            };
            layer.window = moving_layers[layer.moving_layer].now.warped_window(frame, covered);
        }
        let all = composite.layers.iter().map(|layer| layer.window).reduce(PixelRect::union).unwrap_or_default();
        let most = composite.source.union(frame.window());
        composite.window = if most == composite.source { composite.source } else { all.intersection(most) };
    }
    settle_windows(composites);
}

/// Unites the windows of views that share a part, and makes each at least one pixel large.
pub(super) fn settle_windows(composites: &mut [Composite]) {
    let windows: Vec<_> = composites.iter().map(|composite| (composite.source, composite.window)).collect();
    for composite in composites {
        let same = windows.iter().filter(|(source, _)| *source == composite.source);
        let window = same.map(|(_, window)| *window).fold(PixelRect::default(), PixelRect::union);
        let pixel = PixelRect { width: 1, height: 1, ..composite.source };
        composite.window = if window.area() == 0 { pixel } else { window };
        let window = composite.window;
        for layer in &mut composite.layers {
            // The background is sampled at every pixel, so it covers the whole window.
            layer.window = if layer.moving_layer == 0 { window } else { layer.window.intersection(window) };
        }
    }
}

/// Assigns every layer its map, computed once per moving layer and cropped for each composite.
pub(super) fn assign_maps(composites: &mut [Composite], frame: FrameSize, moving_layers: &[MovingLayer]) {
    for (index, moving_layer) in moving_layers.iter().enumerate() {
        let wanted = composites.iter().flat_map(|composite| &composite.layers);
        let wanted = wanted.filter(|layer| layer.moving_layer == index);
        let window = wanted.map(|layer| layer.window).reduce(PixelRect::union).unwrap_or_default();
        if moving_layer.now.max_displacement() == 0.0 || window.area() == 0 {
            continue;
        }
        let mut maps = WarpMap::backward_preimages(&moving_layer.now, frame, window).into_iter();
        assign_map(composites, index, &Arc::new(maps.next().expect("one surface is always in front")));
        maps.for_each(|folded| insert_folds(composites, index, &folded));
    }
}

/// Inserts the hidden surfaces of a moving layer where it folds.
fn insert_folds(composites: &mut [Composite], moving_layer: usize, map: &WarpMap) {
    let seen: Vec<f32> = map.offsets.iter().map(|offset| f32::from(u8::from(!offset[0].is_nan()))).collect();
    let folded = bounds(&seen, map.window);
    for composite in composites {
        let layers = &mut composite.layers;
        let Some(index) = layers.iter().position(|layer| layer.moving_layer == moving_layer) else { continue };
        let window = folded.intersection(layers[index].window);
        if window.area() > 0 {
            let map = Some(Arc::new(map.cropped(window)));
            let layer = WarpedLayer { window, map, ..layers[index].clone() };
            layers.insert(index, layer);
        }
    }
}

/// Assigns all layers of a moving layer their crop of a map.
pub(super) fn assign_map(composites: &mut [Composite], moving_layer: usize, map: &Arc<WarpMap>) {
    let mut parts: Vec<Arc<WarpMap>> = vec![Arc::clone(map)];
    let layers = composites.iter_mut().flat_map(|composite| &mut composite.layers);
    for layer in layers.filter(|layer| layer.moving_layer == moving_layer) {
        let known = parts.iter().find(|known| known.window == layer.window).cloned();
        let part = known.unwrap_or_else(|| {
            parts.push(Arc::new(map.cropped(layer.window)));
            Arc::clone(&parts[parts.len() - 1])
        });
        layer.map = Some(part);
    }
}

/// Returns the summed coverage of the matted layers, clamped to 1: the mattes of one picture divide its pixels among them.
fn holdout<'a>(mattes: impl Iterator<Item = &'a MatteCoverage>) -> Option<Vec<f32>> {
    let mut coverages = mattes.filter_map(|matte| matte.coverage.as_ref());
    let mut sum = coverages.next()?.clone();
    for coverage in coverages {
        sum.iter_mut().zip(coverage).for_each(|(sum, coverage)| *sum = (*sum + coverage).min(1.0));
    }
    Some(sum)
}

/// Reports how many pixels the mattes of several layers cover.
fn overlap(mattes: &[MatteCoverage], moving_layers: &[MovingLayer], window: PixelRect) -> Option<String> {
    let coverage = |layer: usize, pixel: usize| mattes[layer].coverage.as_ref().map_or(1.0, |coverage| coverage[pixel]);
    let layers = 1..mattes.len();
    if layers.len() < 2 {
        return None;
    }
    let sum = |pixel: usize| layers.clone().map(|layer| coverage(layer, pixel)).sum::<f32>();
    let pixels: Vec<usize> =
        (0..window.area()).into_par_iter().filter(|&pixel| sum(pixel) > 1.0 + MIN_VISIBLE).collect();
    let overlaps = |&layer: &usize| pixels.iter().any(|&pixel| coverage(layer, pixel) > MIN_VISIBLE);
    let names = layers.clone().filter(overlaps).map(|layer| format!("\"{}\"", moving_layers[layer].name));
    let names: Vec<String> = names.collect();
    (!pixels.is_empty()).then(|| {
        format!(
            "the mattes of the layers {} overlap: {} more than once; let each pixel belong to one layer",
            names.join(" and "),
            pluralised(pixels.len(), "pixel moves", "pixels move")
        )
    })
}

/// Returns the smallest window that contains every pixel with coverage.
fn bounds(coverage: &[f32], window: PixelRect) -> PixelRect {
    let width = window.width as usize;
    let rows = coverage.chunks_exact(width.max(1)).enumerate();
    let mut found: Option<[usize; 4]> = None;
    for (y, row) in rows {
        let Some(left) = row.iter().position(|&coverage| coverage > 0.0) else { continue };
        let right = row.iter().rposition(|&coverage| coverage > 0.0).unwrap_or(left);
        let [x0, y0, x1, _] = found.unwrap_or([left, y, right, y]);
        found = Some([x0.min(left), y0, x1.max(right), y]);
    }
    let Some([x0, y0, x1, y1]) = found else { return PixelRect { width: 0, height: 0, ..window } };
    PixelRect {
        x: window.x + x0 as i32,
        y: window.y + y0 as i32,
        width: (x1 - x0 + 1) as u32,
        height: (y1 - y0 + 1) as u32,
    }
}
