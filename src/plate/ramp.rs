//! A factor that is 1 within a box and falls to 0 at its border, smoothly, so that what it multiplies rests there.
//!
//! In: the box, how wide the fall is at each side. Out: the factor and its gradient; C2 everywhere.

use crate::space::ScreenBox;
use glam::DVec2;

/// Product over the four sides of the smoothstep 6t⁵ − 15t⁴ + 10t³ of the distance from the side by the side's width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    bounds: ScreenBox,
    /// `[axis][lower, upper side]`, above 0.
    widths: [[f64; 2]; 2],
}

impl Ramp {
    pub(super) fn new(bounds: ScreenBox, widths: [[f64; 2]; 2]) -> Self {
        Self { bounds, widths }
    }

    /// The factor and its gradient; exactly 0 from the border outwards.
    pub(super) fn at(&self, point: DVec2) -> (f64, DVec2) {
        let [x, y] = [0, 1].map(|axis| self.along(axis, point[axis]));
        (x[0] * y[0], DVec2::new(x[1] * y[0], x[0] * y[1]))
    }

    /// Whether a box is small beside the falls that it touches.
    pub(super) fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        (0..2).all(|axis| {
            let extent = hi[axis] - lo[axis];
            let [lower, upper] = self.widths[axis];
            let is_off_lower = lo[axis] >= self.bounds.min.0[axis] + lower;
            let is_off_upper = hi[axis] <= self.bounds.max.0[axis] - upper;
            (is_off_lower || extent <= 0.25 * lower) && (is_off_upper || extent <= 0.25 * upper)
        })
    }

    /// Places along an axis between which the factor changes little.
    pub(super) fn places(&self, axis: usize) -> Vec<f64> {
        let (lo, hi) = (self.bounds.min.0[axis], self.bounds.max.0[axis]);
        let [lower, upper] = self.widths[axis];
        let part = |k: u32| f64::from(k) / f64::from(PIECES);
        let falls = (0..=PIECES).flat_map(|k| [lo + lower * part(k), hi - upper * part(k)]);
        falls.filter(|place| (lo..=hi).contains(place)).collect()
    }

    /// Factor and derivative along one axis.
    fn along(&self, axis: usize, place: f64) -> [f64; 2] {
        let [lower, upper] = self.widths[axis];
        let [a, da] = smoothstep((place - self.bounds.min.0[axis]) / lower);
        let [b, db] = smoothstep((self.bounds.max.0[axis] - place) / upper);
        [a * b, da / lower * b - a * db / upper]
    }
}

/// Pieces of a fall between neighbouring [`Ramp::places`].
const PIECES: u32 = 8;

/// Value and derivative.
fn smoothstep(t: f64) -> [f64; 2] {
    let t = t.clamp(0.0, 1.0);
    [t * t * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * t * t * (t - 1.0) * (t - 1.0)]
}
