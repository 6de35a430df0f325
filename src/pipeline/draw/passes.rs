//! Plans the sample passes of a frame: time and sub-pixel offset of each.
//!
//! One mechanism provides anti-aliasing and motion blur: every pass samples the pixel centres of the picture, shifted
//! by a sub-pixel offset, at a sub-frame time; the beauty is the mean over the passes. The offsets are distributed like
//! the reconstruction filter (filter importance sampling: Ernst, Stamminger and Greiner, "Filter Importance Sampling",
//! 2006), so the plain mean is the filtered picture.

use crate::raster::PassRole;
use crate::shot::Shutter;
use glam::{DVec2, Vec2};

/// Radius of the Blackman-Harris reconstruction filter, pixels.
const FILTER_RADIUS_PX: f64 = 1.5;

/// Step of the R2 sequence, the first two negative powers of the plastic number (Roberts, "The Unreasonable
/// Effectiveness of Quasirandom Sequences", 2018).
const R2_STEP: DVec2 = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_3);

/// One pass of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PassPlan {
    /// Time of the pass relative to the frame, in frames.
    pub(crate) time_frames: f64,
    /// Offset of the picture, pixels, x right, y down.
    pub(crate) jitter_px: Vec2,
    /// Whether the pass contributes to beauty, data or both.
    pub(crate) role: PassRole,
}

/// Returns the middle of the shutter's opening relative to the frame, in frames.
#[must_use]
pub(in crate::pipeline) fn mid_shutter(shutter: Shutter) -> f64 {
    if shutter.angle > 0.0 { (shutter.phase + shutter.angle * 0.5) / 360.0 } else { 0.0 }
}

/// Returns the passes of a frame, the beauty passes in time order. They are the same for every frame, so nothing flickers.
///
/// One pass draws data: at mid-shutter and at the pixel centres, whatever the number of samples. Without motion blur
/// this is the first beauty pass, which has no offset; with motion blur it is an additional pass, at the end of the
/// list.
#[must_use]
pub(crate) fn plan_passes(samples: u32, shutter: Shutter) -> Vec<PassPlan> {
    let samples = samples.max(1);
    let middle = mid_shutter(shutter);
    let is_blurred = shutter.angle > 0.0 && samples > 1;
    let time = |index: u32| {
        let opened = (f64::from(index) + 0.5) / f64::from(samples);
        if is_blurred { (shutter.phase + shutter.angle * opened) / 360.0 } else { middle }
    };
    let role = |index: u32| if index == 0 && !is_blurred { PassRole::BeautyAndData } else { PassRole::Beauty };
    let beauty = |index| PassPlan { time_frames: time(index), jitter_px: filter_offset(index), role: role(index) };
    let data = PassPlan { time_frames: middle, jitter_px: Vec2::ZERO, role: PassRole::Data };
    (0..samples).map(beauty).chain(is_blurred.then_some(data)).collect()
}

/// Returns the `index`-th offset of a sequence whose density is the reconstruction filter; the first is 0.
fn filter_offset(index: u32) -> Vec2 {
    if index == 0 {
        return Vec2::ZERO;
    }
    let uniform = (DVec2::splat(0.5) + R2_STEP * f64::from(index)).fract();
    Vec2::new(inverse_filter(uniform.x) as f32, inverse_filter(uniform.y) as f32)
}

/// Returns the offset at which the filter's integral reaches `share`, pixels, by bisection because it has no closed form.
fn inverse_filter(share: f64) -> f64 {
    let (mut low, mut high) = (-FILTER_RADIUS_PX, FILTER_RADIUS_PX);
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if filter_integral(middle) < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns the integral of the normalised 4-term Blackman-Harris window (Harris 1978) from its left end to `x` pixels.
fn filter_integral(x: f64) -> f64 {
    const A: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];
    let t = std::f64::consts::TAU * (x / FILTER_RADIUS_PX + 1.0) * 0.5;
    let wave = |k: usize| A[k] * (t * k as f64).sin() / k as f64;
    (A[0] * t - wave(1) + wave(2) - wave(3)) / (A[0] * std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPEN: Shutter = Shutter { angle: 180.0, phase: -90.0 };

    #[test]
    fn one_sample_sits_in_the_middle() {
        let plan = plan_passes(1, Shutter::CLOSED);
        assert_eq!(plan, [PassPlan { time_frames: 0.0, jitter_px: Vec2::ZERO, role: PassRole::BeautyAndData }]);
    }

    #[test]
    fn shutter_times_fill_the_opening() {
        let plan = plan_passes(16, Shutter { angle: 180.0, phase: 0.0 });
        let times: Vec<f64> = plan.iter().filter(|p| p.role == PassRole::Beauty).map(|p| p.time_frames).collect();
        assert_eq!((times.len(), times[0], times[15]), (16, 0.5 / 32.0, 15.5 / 32.0));
        assert_eq!(mid_shutter(OPEN), 0.0);
    }

    #[test]
    fn one_pass_draws_data_in_the_middle_of_shutter_and_pixel() {
        for shutter in [OPEN, Shutter::CLOSED, Shutter { angle: 90.0, phase: 30.0 }] {
            for samples in [1, 2, 4, 11, 16] {
                let plan = plan_passes(samples, shutter);
                let data: Vec<_> = plan.iter().filter(|pass| pass.role != PassRole::Beauty).collect();
                assert_eq!(data.len(), 1, "{samples} samples, {shutter:?}");
                assert_eq!((data[0].time_frames, data[0].jitter_px), (mid_shutter(shutter), Vec2::ZERO));
                let beauty = plan.iter().filter(|pass| pass.role != PassRole::Data).count();
                assert_eq!(beauty, samples as usize);
            }
        }
    }

    #[test]
    fn offsets_follow_the_filter() {
        let offsets: Vec<Vec2> = plan_passes(1024, Shutter::CLOSED).iter().map(|pass| pass.jitter_px).collect();
        let mean: Vec2 = offsets.iter().sum::<Vec2>() / 1024.0;
        // The mean of n points of a low-discrepancy sequence deviates by about the width / n.
        assert!(mean.length() < 3.0 / 1024.0, "{mean}");
        // Standard deviation of the window of radius 1.5, integrated numerically and estimated from the samples.
        let steps = 10_000;
        let density = |x: f64| (filter_integral(x + 1e-5) - filter_integral(x - 1e-5)) / 2e-5;
        let place = |k: i32| -1.499 + 2.998 * (f64::from(k) + 0.5) / f64::from(steps);
        let variance: f64 = (0..steps).map(|k| place(k).powi(2) * density(place(k)) * 2.998 / f64::from(steps)).sum();
        let sampled: f32 = offsets.iter().map(|offset| offset.x * offset.x).sum::<f32>() / 1024.0;
        assert!((variance - f64::from(sampled)).abs() < 1e-3, "{variance} {sampled}");
    }
}
