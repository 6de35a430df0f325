//! A factor that is 1 inside a box and falls smoothly to 0 at its border, to fix what it multiplies there.
//!
//! In: the box, and the width of the falloff at each side. Out: the factor and its gradient; C2 everywhere.

use crate::space::ScreenBox;
use glam::DVec2;

/// Product over the four sides of the smoothstep 6t⁵ − 15t⁴ + 10t³, t = distance from the side / width of the falloff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    bounds: ScreenBox,
    /// `[axis][lower, upper side]`, positive.
    widths: [[f64; 2]; 2],
}

impl Ramp {
    pub(super) fn new(bounds: ScreenBox, widths: [[f64; 2]; 2]) -> Self {
        Self { bounds, widths }
    }

    /// Returns the factor and its gradient; exactly 0 on the border and outside.
    pub(super) fn at(&self, point: DVec2) -> (f64, DVec2) {
        let [x, y] = [0, 1].map(|axis| self.along(axis, point[axis]));
        (x[0] * y[0], DVec2::new(x[1] * y[0], x[0] * y[1]))
    }

    /// Whether a box is small compared with the falloffs that it touches.
    pub(super) fn is_smooth_within(&self, lo: DVec2, hi: DVec2) -> bool {
        (0..2).all(|axis| {
            let extent = hi[axis] - lo[axis];
            let [lower, upper] = self.widths[axis];
            let is_off_lower = lo[axis] >= self.bounds.min.0[axis] + lower;
            let is_off_upper = hi[axis] <= self.bounds.max.0[axis] - upper;
            (is_off_lower || extent <= 0.25 * lower) && (is_off_upper || extent <= 0.25 * upper)
        })
    }

    /// Returns positions along an axis between which the factor changes little.
    pub(super) fn places(&self, axis: usize) -> Vec<f64> {
        let (lo, hi) = (self.bounds.min.0[axis], self.bounds.max.0[axis]);
        let [lower, upper] = self.widths[axis];
        let part = |k: u32| f64::from(k) / f64::from(PIECES);
        let falls = (0..=PIECES).flat_map(|k| [lo + lower * part(k), hi - upper * part(k)]);
        falls.filter(|place| (lo..=hi).contains(place)).collect()
    }

    /// Returns the factor and its derivative along one axis.
    fn along(&self, axis: usize, place: f64) -> [f64; 2] {
        let [lower, upper] = self.widths[axis];
        let [a, da] = smootherstep((place - self.bounds.min.0[axis]) / lower);
        let [b, db] = smootherstep((self.bounds.max.0[axis] - place) / upper);
        [a * b, da / lower * b - a * db / upper]
    }
}

/// Intervals of a falloff between neighbouring [`Ramp::places`].
const PIECES: u32 = 8;

/// Returns the value and derivative of the quintic step from 0 to 1, whose second derivative is continuous.
fn smootherstep(t: f64) -> [f64; 2] {
    let t = t.clamp(0.0, 1.0);
    [t * t * t * (t * (t * 6.0 - 15.0) + 10.0), 30.0 * t * t * (t - 1.0) * (t - 1.0)]
}
