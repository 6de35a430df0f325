//! Border handling: what filters see outside of the picture.
//!
//! In: the windows of the picture and of the display. Out: for each side whether the picture continues there, and how
//! much of an output pixel it covers.

use crate::plate::WarpMap;
use crate::space::PixelRect;

/// Least width of an output pixel in the picture, in samples, that counts where the warp magnifies.
const NARROWEST: f32 = 1.0 / 64.0;

/// Distance in pixels of the result over which a border counts as resting where the warp magnifies without limit: two differences do not
/// tell the width of a pixel exactly where it changes.
const UNSURE: f32 = 0.125;

/// Distance in pixels over which a border may be pulled into the picture and still counts as resting. The centres of the
/// last pixels lie beside it and move a little even where it is held, and maps are not exact.
const RESTING: f32 = 1.0 / 512.0;

/// The picture along one axis, in samples from its first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Number of samples.
    pub(crate) count: i32,
    /// Whether the picture continues before the first and after the last sample.
    pub(crate) goes_on: [bool; 2],
}

impl Extent {
    /// Returns the extents of both axes of a picture.
    pub(crate) fn of_window(window: PixelRect, display: PixelRect) -> [Self; 2] {
        let axis = |start: i32, count: u32, edge: i32, edges: u32| {
            let end = i64::from(start) + i64::from(count);
            let goes_on = [start <= edge, end >= i64::from(edge) + i64::from(edges)];
            Self { count: count as i32, goes_on }
        };
        [
            axis(window.x, window.width, display.x, display.width),
            axis(window.y, window.height, display.y, display.height),
        ]
    }

    /// Returns the sample at a position; `None` outside the picture.
    pub(super) fn sample(self, place: i32) -> Option<usize> {
        let held = (place < 0 && self.goes_on[0]) || (place >= self.count && self.goes_on[1]);
        let place = if held { place.clamp(0, self.count - 1) } else { place };
        (0..self.count).contains(&place).then_some(place as usize)
    }

    /// Returns how far a position lies beyond the last sample on a side where the picture continues, at most 1; 0 elsewhere.
    #[inline(always)]
    fn excess(self, sample: f32, fraction: f32) -> f32 {
        let before = if self.goes_on[0] { -sample - fraction } else { 0.0 };
        let after = if self.goes_on[1] { sample + fraction - (self.count - 1) as f32 } else { 0.0 };
        before.max(after).clamp(0.0, 1.0)
    }
}

/// Returns how much of an output pixel, at (column, row) of the map and `sample + fraction` of the picture, lies inside the sides
/// where the picture continues, 0 to 1: exactly 1 where the border counts as resting, from there on continuous.
///
/// A side inside the display window is a crop: samples beyond it are 0. At a side on (or beyond: overscan) the display's edge the
/// scene continues: filters repeat the last sample, so that a border at rest does not darken, and the cut is drawn as an edge one
/// pixel soft. Where the warp magnifies, that is a pixel of the result: a border that rests beside what is stretched does not darken
/// either. A border counts as resting within [`RESTING`].
#[inline(always)]
pub(super) fn coverage(
    extents: &[Extent; 2],
    (sample, fraction): ([f32; 2], [f32; 2]),
    map: &WarpMap,
    pixel: [usize; 2],
) -> f32 {
    let along = |axis: usize| {
        let excess = extents[axis].excess(sample[axis], fraction[axis]);
        if excess == 0.0 {
            return 1.0;
        }
        // The centre of the pixel is 1/2 - excess samples inside the border.
        let width = pixel_width(map, axis, pixel);
        let inside = ((0.5 - excess) / width + 0.5).clamp(0.0, 1.0);
        let resting = RESTING + UNSURE * (1.0 - width);
        inside.max((2.0 * inside - (1.0 - 2.0 * resting)).min(1.0))
    };
    along(0) * along(1)
}

/// Returns the width of an output pixel along an axis of the picture, in samples, at most 1.
fn pixel_width(map: &WarpMap, axis: usize, pixel: [usize; 2]) -> f32 {
    let size = [map.window.width as usize, map.window.height as usize];
    let index = pixel[1] * size[0] + pixel[0];
    let slope = |output: usize| {
        let stride = [1, size[0]][output];
        let own = if axis == output { 1.0 } else { 0.0 };
        let step = |from: usize| map.offsets[from + stride][axis] - map.offsets[from][axis] + own;
        let before = (pixel[output] >= 2).then(|| least_slope(step(index - stride), step(index - 2 * stride)));
        let after = (pixel[output] + 2 < size[output]).then(|| least_slope(step(index), step(index + stride)));
        // f32::min ignores NaN.
        before.into_iter().chain(after).fold(1.0_f32, f32::min)
    };
    slope(0).hypot(slope(1)).clamp(NARROWEST, 1.0)
}

/// Returns the width of a pixel's half that faces the border, twice, from the steps to the next two pixels away from the border: the first
/// step, or what both extrapolate to the middle of that half, three quarters of a pixel before the first step's middle; the lesser.
fn least_slope(near: f32, next: f32) -> f32 {
    near.abs().min((1.75 * near - 0.75 * next).abs())
}
