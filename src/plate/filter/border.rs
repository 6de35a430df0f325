//! Border handling: what filters see outside of the picture.
//!
//! In: the windows of the picture and of the display. Out: for each side whether the picture continues there, and how
//! much of an output pixel it covers.
//!
//! A side inside the display window is a crop: samples beyond it are 0. At a side on (or beyond: overscan) the
//! display's edge the scene continues: filters repeat the last sample, so that a border at rest does not darken, and
//! the cut is drawn as an edge one pixel soft. A border counts as resting within [`RESTING`].

use crate::space::PixelRect;

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

    /// Returns how much of a pixel centred at `sample + fraction` lies inside the sides where the picture continues, 0 to 1:
    /// exactly 1 up to [`RESTING`] beyond the last sample, from there on continuous.
    #[inline(always)]
    pub(super) fn coverage(self, sample: f32, fraction: f32) -> f32 {
        let before = if self.goes_on[0] { sample + 1.0 + fraction } else { 1.0 };
        let after = if self.goes_on[1] { self.count as f32 - sample - fraction } else { 1.0 };
        let inside = before.min(after).clamp(0.0, 1.0);
        inside.max((2.0 * inside - (1.0 - 2.0 * RESTING)).min(1.0))
    }
}
