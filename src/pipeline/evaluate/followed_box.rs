//! Boxes that follow their contents, on the screen and in the scene.
//!
//! In: bounds in a frame and its neighbours. Out: a box that depends on the shot and the frame alone. The cached bounds
//! are those that recomputation would yield.

use crate::space::{RotatedBox, ScreenBox, ScreenPoint};
use glam::DVec2;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Lower and upper corner.
pub(in crate::pipeline) type Bounds<const D: usize> = [[f64; D]; 2];

/// The axes of a layer's box on the screen: an origin and an angle, those of the node that the box turns with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::pipeline) struct BoxAxes {
    /// Origin of the axes.
    pub(in crate::pipeline) origin: DVec2,
    /// Angle of the axes in radians, counter-clockwise.
    pub(in crate::pipeline) angle: f64,
}

impl BoxAxes {
    /// Returns the box with these bounds along the axes.
    pub(in crate::pipeline) fn rotated_box(self, [lo, hi]: Bounds<2>) -> RotatedBox {
        let [lo, hi] = [lo, hi].map(DVec2::from);
        // Without rotation the corners keep their bits.
        if self == Self::default() {
            return ScreenBox::new(ScreenPoint(lo), ScreenPoint(hi)).into();
        }
        let (center, half) = (self.origin + DVec2::from_angle(self.angle).rotate((lo + hi) * 0.5), (hi - lo) * 0.5);
        let upright = ScreenBox::new(ScreenPoint(center - half), ScreenPoint(center + half));
        RotatedBox { upright, angle: self.angle }
    }
}

/// Padding of a followed box on each side, relative to its size.
const PADDING: f64 = 0.1;

/// Number of frames on either side over which a followed box is smoothed.
const FOLLOW_FRAMES: i32 = 3;

/// The neighbouring frames, with tent weights, over which the box at a (fractional) frame is smoothed.
#[derive(Clone, Copy, Debug)]
pub(in crate::pipeline) struct SmoothingWindow {
    frame: f64,
}

impl SmoothingWindow {
    /// Creates the window around a frame.
    pub(in crate::pipeline) const fn new(frame: f64) -> Self {
        Self { frame }
    }

    /// Returns the whole frames whose bounds contribute.
    pub(in crate::pipeline) fn frames(self) -> std::ops::RangeInclusive<i32> {
        let (low, high) = (self.frame.floor() as i32, self.frame.ceil() as i32);
        low.saturating_sub(FOLLOW_FRAMES)..=high.saturating_add(FOLLOW_FRAMES)
    }

    /// Returns those of [`Self::frames`] with no cut between them and the frame. A fractional frame is one with the whole frame before it.
    pub(in crate::pipeline) fn frames_without_cut(
        self,
        is_cut_after: impl Fn(i32) -> bool,
    ) -> std::ops::RangeInclusive<i32> {
        let (mut first, mut last) = (self.frame.floor() as i32, self.frame.floor() as i32);
        let (low, high) = self.frames().into_inner();
        while first > low && !is_cut_after(first - 1) {
            first -= 1;
        }
        while last < high && !is_cut_after(last) {
            last += 1;
        }
        first..=last
    }

    /// Returns the smoothed box: centre and size are tent-weighted means over the neighbours' bounds, padded, and then
    /// extended where needed to contain `now`, the bounds of the frame itself. `None` if neither the frame nor a
    /// neighbour shows anything.
    pub(in crate::pipeline) fn smooth<const D: usize>(
        self,
        neighbours: &[(i32, Option<Bounds<D>>)],
        now: Option<Bounds<D>>,
    ) -> Option<Bounds<D>> {
        let half_width = f64::from(FOLLOW_FRAMES + 1);
        let mut total = 0.0;
        let (mut center, mut size) = ([0.0; D], [0.0; D]);
        for &(frame, bounds) in neighbours {
            let weight = (1.0 - (f64::from(frame) - self.frame).abs() / half_width).max(0.0);
            let Some([lo, hi]) = bounds else { continue };
            total += weight;
            for axis in 0..D {
                center[axis] += (lo[axis] + hi[axis]) * 0.5 * weight;
                size[axis] += (hi[axis] - lo[axis]) * weight;
            }
        }
        let mean = (total > 0.0).then(|| {
            let half = size.map(|size| size / total * (0.5 + PADDING));
            let corner = |side: f64| std::array::from_fn(|axis| center[axis] / total + side * half[axis]);
            [corner(-1.0), corner(1.0)]
        });
        [mean, now].into_iter().flatten().reduce(union)
    }
}

/// Returns the smallest box that contains both boxes.
pub(in crate::pipeline) fn union<const D: usize>([a, b]: Bounds<D>, [c, d]: Bounds<D>) -> Bounds<D> {
    [std::array::from_fn(|axis| a[axis].min(c[axis])), std::array::from_fn(|axis| b[axis].max(d[axis]))]
}

/// Extends the box on both sides along axes where it is shorter than `least`.
pub(in crate::pipeline) fn thickened<const D: usize>([lo, hi]: Bounds<D>, least: f64) -> Bounds<D> {
    let lacking: [f64; D] = std::array::from_fn(|axis| (least - (hi[axis] - lo[axis])).max(0.0) * 0.5);
    [std::array::from_fn(|axis| lo[axis] - lacking[axis]), std::array::from_fn(|axis| hi[axis] + lacking[axis])]
}

/// Bounds of all layers at whole frames, each computed once.
#[derive(Debug)]
pub(in crate::pipeline) struct BoundsCache<const D: usize>(Mutex<HashMap<i32, Vec<Option<Bounds<D>>>>>);

impl<const D: usize> Default for BoundsCache<D> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<const D: usize> BoundsCache<D> {
    /// Returns the bounds of a layer at a frame; `all` computes those of every layer on a cache miss.
    pub(in crate::pipeline) fn at(
        &self,
        layer: usize,
        frame: i32,
        all: impl FnOnce() -> Vec<Option<Bounds<D>>>,
    ) -> Option<Bounds<D>> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(all) = known().get(&frame) {
            return all[layer];
        }
        let all = all();
        let bounds = all[layer];
        known().insert(frame, all);
        bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box_at(x: f64) -> Bounds<2> {
        [[x, 0.0], [x + 1.0, 1.0]]
    }

    #[test]
    fn a_followed_box_is_padded_and_moves_evenly() {
        let at = |frame: i32| (frame, Some(unit_box_at(f64::from(frame) * 0.01)));
        let window = SmoothingWindow::new(10.0);
        let neighbours: Vec<_> = window.frames().map(at).collect();
        let [lo, hi] = window.smooth(&neighbours, at(10).1).expect("visible");
        for (found, expected) in lo.iter().chain(&hi).zip([0.0, -0.1, 1.2, 1.1]) {
            assert!((found - expected).abs() < 1e-12, "{lo:?} {hi:?}");
        }
    }

    #[test]
    fn a_followed_box_always_holds_the_bounds() {
        let window = SmoothingWindow::new(4.5);
        let neighbours: Vec<_> = window.frames().map(|frame| (frame, Some(unit_box_at(0.0)))).collect();
        let now = unit_box_at(5.0);
        let followed = window.smooth(&neighbours, Some(now)).expect("visible");
        assert_eq!(union(followed, now), followed);
        assert_eq!(window.smooth::<2>(&[(4, None)], None), None);
    }

    #[test]
    fn thin_boxes_grow_about_their_middle() {
        assert_eq!(thickened([[0.0, 1.0], [2.0, 1.0]], 0.5), [[0.0, 0.75], [2.0, 1.25]]);
    }
}
