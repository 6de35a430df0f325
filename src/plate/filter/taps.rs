//! The source samples in the footprint of one output pixel, for data that may be weighted but not extrapolated.
//!
//! In: a map and a pixel. Out: source samples and non-negative weights, from a tent filter as wide as the pixel's footprint.

use super::border::{Extent, coverage};
use super::footprint::Footprint;
use crate::plate::WarpMap;
use crate::space::PixelRect;

/// Collects the samples in the footprint of an output pixel: (index into the source window, weight).
///
/// Weights are positive. They sum to 1 inside the picture, and to less if part of the pixel lies outside; there are no taps where the map
/// is NaN or points outside the picture, and a single tap of weight 1 where nothing moves. Clears `taps` first.
pub(crate) fn footprint_taps(map: &WarpMap, pixel: usize, source_window: PixelRect, taps: &mut Vec<(usize, f32)>) {
    taps.clear();
    if source_window.area() == 0 {
        return;
    }
    let width = map.window.width as usize;
    let (column, row) = (pixel % width, pixel / width);
    let extents = Extent::of_window(source_window, map.frame.window());
    let offset = map.offsets[pixel];
    let start = [
        i64::from(map.window.x) + column as i64 - i64::from(source_window.x),
        i64::from(map.window.y) + row as i64 - i64::from(source_window.y),
    ];
    let Some(positions) = positions(offset, start, extents) else { return };
    let footprint = Footprint::at(map, column, row);
    let place = (positions.map(|(sample, _)| sample as f32), positions.map(|(_, fraction)| fraction));
    let inside = coverage(&extents, place, map, [column, row]);
    let sum = gather(&positions, &footprint, extents, source_window.width as usize, taps);
    // Far beyond a side that continues, every tap is the last sample, with coverage 0.
    taps.retain_mut(|(_, weight)| {
        *weight *= inside / sum;
        *weight > 0.0
    });
}

/// Returns the first and the last sample (column and row of the source window) of the rectangle around a pixel's
/// footprint; `None` where the map is undefined.
pub(crate) fn footprint_bounds(map: &WarpMap, pixel: usize, source: PixelRect) -> Option<[[i32; 2]; 2]> {
    let width = map.window.width as usize;
    let (column, row) = (pixel % width, pixel / width);
    let extents = Extent::of_window(source, map.frame.window());
    let start = [
        i64::from(map.window.x) + column as i64 - i64::from(source.x),
        i64::from(map.window.y) + row as i64 - i64::from(source.y),
    ];
    let positions = positions(map.offsets[pixel], start, extents)?;
    let footprint = Footprint::at(map, column, row);
    let end = |axis: usize, side: f32| positions[axis].1 + side * footprint.half_extent[axis];
    let low = [0, 1].map(|axis| positions[axis].0 + end(axis, -1.0).ceil() as i32);
    let high = [0, 1].map(|axis| positions[axis].0 + end(axis, 1.0).floor() as i32);
    Some([low, high])
}

/// Returns the sample and fraction on both axes; `None` if the position is not near the picture.
fn positions(offset: [f32; 2], start: [i64; 2], extents: [Extent; 2]) -> Option<[(i32, f32); 2]> {
    let position = |axis: usize| {
        let whole = offset[axis].floor();
        let sample = start[axis] as f32 + whole;
        let near = sample > -1e6 && sample < extents[axis].count as f32 + 1e6;
        near.then(|| (sample as i32, offset[axis] - whole))
    };
    Some([position(0)?, position(1)?])
}

/// Adds taps with tent weights; returns the sum of all weights, including those outside the picture.
fn gather(
    positions: &[(i32, f32); 2],
    footprint: &Footprint,
    extents: [Extent; 2],
    width: usize,
    taps: &mut Vec<(usize, f32)>,
) -> f32 {
    let [xx, xy, yy] = footprint.filter_from_source;
    let range = |axis: usize| {
        let fraction = positions[axis].1;
        (fraction - footprint.half_extent[axis]).ceil() as i32..=(fraction + footprint.half_extent[axis]).floor() as i32
    };
    let mut sum = 0.0;
    for y in range(1) {
        let dy = y as f32 - positions[1].1;
        for x in range(0) {
            let dx = x as f32 - positions[0].1;
            let tent = |t: f32| (1.0 - t.abs()).max(0.0);
            let weight = tent(xx * dx + xy * dy) * tent(xy * dx + yy * dy);
            sum += weight;
            let sample = extents[0].sample(positions[0].0 + x).zip(extents[1].sample(positions[1].0 + y));
            if let Some((x, y)) = sample.filter(|_| weight > 0.0) {
                add(taps, y * width + x, weight);
            }
        }
    }
    sum
}

/// A repeated border yields the same sample more than once.
fn add(taps: &mut Vec<(usize, f32)>, index: usize, weight: f32) {
    match taps.last_mut() {
        Some(last) if last.0 == index => last.1 += weight,
        _ => taps.push((index, weight)),
    }
}
