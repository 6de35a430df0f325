//! Resampling: the samples of a picture, seen through a map.
//!
//! In: a [`WarpMap`], planes of samples, a [`Filter`]. Out: as many planes of the map's window, the same on any number
//! of threads; or the weights of one pixel's footprint. What happens at borders and to samples that are no numbers:
//! docs/PLATES.md, "Filters".

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
pub use taps::footprint_taps;

use super::{Filter, WarpMap};
use crate::space::PixelRect;
use rayon::prelude::*;
use tile::{Scratch, Tiles};

/// Rows that a task takes.
pub(super) const BAND: usize = 32;

/// Samples that are looked through at once for those that are not finite.
const CHECKED: usize = 1 << 14;

/// Samples of equal windows.
#[derive(Clone, Debug)]
pub struct Planes<'a> {
    /// Where they lie, in image space.
    pub window: PixelRect,
    /// Each with `window.area()` samples, rows from the top.
    pub planes: Vec<&'a [f32]>,
}

/// Samples that are no finite numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NotFinite {
    /// Not a number: a filter takes them for absent.
    pub nan: usize,
    /// Infinite: a filter takes them for the greatest finite half, 65504.
    pub infinite: usize,
}

impl Planes<'_> {
    /// Counts the samples that a filter contains, for the report.
    #[must_use]
    pub fn not_finite(&self) -> NotFinite {
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

/// A product with 0 is 0 or NaN: the sum needs no branch a sample.
fn all_finite(samples: &[f32]) -> bool {
    let mut sums = [0.0; 16];
    let (chunks, rest) = samples.as_chunks::<16>();
    for chunk in chunks {
        sums.iter_mut().zip(chunk).for_each(|(sum, sample)| *sum += 0.0 * sample);
    }
    sums.iter().sum::<f32>() == 0.0 && rest.iter().all(|sample| sample.is_finite())
}

/// The planes as seen through the map: one an input plane, each `map.window.area()` samples; 0 where the map holds NaN.
///
/// All planes of a call share their weights. Where the map moves nothing, samples keep their bits. [`Filter::Nearest`]
/// copies bits everywhere, so it may be used for ids.
///
/// # Panics
/// Where a plane or the map does not have as many elements as its window has pixels.
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

/// As [`resampled`], into planes that are already there: every sample is written.
///
/// # Panics
/// As [`resampled`], and where the planes are not as many or as large as the result.
pub fn resample_into(map: &WarpMap, source: &Planes, filter: Filter, planes: &mut [Vec<f32>]) {
    resample_part(map, map.window, source, filter, planes);
}

/// As [`resample_into`], but only a window within the map's: the same pixels, as footprints look at the map around it.
///
/// # Panics
/// As [`resample_into`], and where the part is not within the map.
pub fn resample_part(map: &WarpMap, part: PixelRect, source: &Planes, filter: Filter, planes: &mut [Vec<f32>]) {
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

/// Cuts planes into bands of `length` samples: the bands, and in each the part of every plane.
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
