//! Resamples pictures through a map.
//!
//! In: a [`WarpMap`], planes of samples, a [`Filter`]. Out: as many planes over the map's window, identical for any
//! number of threads; or the weights of one pixel's footprint. docs/PLATES.md, "Filters", describes the treatment of
//! borders and of samples that are not finite.

mod area;
mod block;
mod border;
mod footprint;
mod kernel;
mod nearest;
mod positions;
mod profile;
mod simd;
mod taps;
mod tile;

#[cfg(test)]
mod tests;

pub(crate) use border::Extent;
pub(super) use nearest::{NOWHERE, copy_samples, nearest_in_row};
pub(crate) use profile::lanczos_table;
pub(super) use taps::footprint_bounds;
pub(crate) use taps::footprint_taps;

use super::{Filter, WarpMap};
use crate::space::PixelRect;
use rayon::prelude::*;
use tile::{Scratch, Tiles};

/// Rows per parallel task.
pub(super) const BAND: usize = 32;

/// Samples per task of the search for non-finite samples.
const CHECKED: usize = 1 << 14;

/// Planes of samples over a common window.
#[derive(Clone, Debug)]
pub struct Planes<'a> {
    /// Window of the planes, in image space.
    pub window: PixelRect,
    /// Each with `window.area()` samples, rows from the top.
    pub planes: Vec<&'a [f32]>,
}

/// Counts of samples that are not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct NotFinite {
    /// NaN samples, which filters treat as missing.
    pub(crate) nan: usize,
    /// Infinite samples, which filters replace by the greatest finite half float, 65504.
    pub(crate) infinite: usize,
}

impl Planes<'_> {
    /// Counts the samples that a filter replaces, for the report.
    #[must_use]
    pub(crate) fn not_finite(&self) -> NotFinite {
        let rows = self.planes.par_iter().flat_map(|plane| plane.par_chunks(CHECKED));
        rows.filter(|samples| !all_finite(samples)).map(NotFinite::of).reduce(NotFinite::default, NotFinite::plus)
    }
}

impl NotFinite {
    fn of(samples: &[f32]) -> Self {
        let count = |test: fn(f32) -> bool| samples.iter().filter(|sample| test(**sample)).count();
        Self { nan: count(f32::is_nan), infinite: count(f32::is_infinite) }
    }

    fn plus(self, other: Self) -> Self {
        Self { nan: self.nan + other.nan, infinite: self.infinite + other.infinite }
    }
}

/// Whether all samples are finite. Multiplying by 0 yields 0 or NaN, so the sum needs no branch per sample.
fn all_finite(samples: &[f32]) -> bool {
    let mut sums = [0.0; 16];
    let (chunks, rest) = samples.as_chunks::<16>();
    for chunk in chunks {
        sums.iter_mut().zip(chunk).for_each(|(sum, sample)| *sum += 0.0 * sample);
    }
    sums.iter().sum::<f32>() == 0.0 && rest.iter().all(|sample| sample.is_finite())
}

/// Resamples planes through a map. Returns one plane per input plane, each with `map.window.area()` samples; 0 where the map is NaN.
///
/// All planes of a call share their weights. Where nothing moves, samples are copied bit-exactly. [`Filter::Nearest`]
/// always copies bit-exactly, so it is suitable for ids.
///
/// # Panics
/// If the length of a plane or of the map differs from the area of its window.
///
/// ```
/// use pinwarp::plate::{Filter, Planes, WarpMap, resampled};
/// use pinwarp::space::{FrameSize, PixelRect};
/// let window = PixelRect { x: 0, y: 0, width: 4, height: 1 };
/// let mut map = WarpMap::identity(FrameSize::new(4, 1), window);
/// map.offsets.fill([1.0, 0.0]);
/// let source = Planes { window, planes: vec![&[1.0, 2.0, 3.0, 4.0]] };
/// assert_eq!(resampled(&map, &source, Filter::Cubic), [[2.0, 3.0, 4.0, 0.0]]);
/// ```
#[must_use]
pub fn resampled(map: &WarpMap, source: &Planes, filter: Filter) -> Vec<Vec<f32>> {
    let mut planes = vec![vec![0.0; map.window.area()]; source.planes.len()];
    resample_into(map, source, filter, &mut planes);
    planes
}

/// As [`resampled`], writing every sample of existing planes.
///
/// # Panics
/// As [`resampled`], and if the number or the size of the planes does not match the result.
pub fn resample_into(map: &WarpMap, source: &Planes, filter: Filter, planes: &mut [Vec<f32>]) {
    resample_part(map, map.window, source, filter, planes);
}

/// As [`resample_into`], for a window within the map's. The pixels are identical, since footprints use the map around the window.
///
/// # Panics
/// As [`resample_into`], and if the window is not within the map's.
pub(crate) fn resample_part(map: &WarpMap, part: PixelRect, source: &Planes, filter: Filter, planes: &mut [Vec<f32>]) {
    assert_eq!(map.offsets.len(), map.window.area(), "an offset a pixel");
    assert_eq!(map.window.intersection(part), part, "a part of the map");
    assert_eq!(planes.len(), source.planes.len(), "a result a plane");
    assert!(source.planes.iter().all(|plane| plane.len() == source.window.area()), "a sample a pixel");
    assert!(planes.iter().all(|plane| plane.len() == part.area()), "a sample a pixel of the result");
    if part.area() == 0 || source.window.area() == 0 {
        return planes.iter_mut().for_each(|plane| plane.fill(0.0));
    }
    if planes.is_empty() {
        return;
    }
    let tiles = Tiles::new(map, source, filter);
    let mut bands = bands(planes, BAND * part.width as usize);
    let work = |scratch: &mut Scratch, (index, band): (usize, &mut Vec<&mut [f32]>)| {
        let (above, height) = (index * BAND, band[0].len() / part.width as usize);
        tiles.write_band(PixelRect { y: part.y + above as i32, height: height as u32, ..part }, band, scratch);
    };
    bands.par_iter_mut().enumerate().for_each_init(Scratch::default, work);
}

/// Splits planes into bands of `length` samples; each band holds a slice of every plane.
pub(super) fn bands(planes: &mut [Vec<f32>], length: usize) -> Vec<Vec<&mut [f32]>> {
    let mut bands: Vec<Vec<&mut [f32]>> = Vec::new();
    for plane in planes {
        for (index, part) in plane.chunks_mut(length).enumerate() {
            if bands.len() <= index {
                bands.push(Vec::new());
            }
            bands[index].push(part);
        }
    }
    bands
}
