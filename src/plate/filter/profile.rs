//! Filter profiles: the weights of the samples around a position.
//!
//! In: the fraction of a position after a sample, or a distance. Out: weights, which sum to 1 for the separable filters.
//!
//! Catmull-Rom: R. Keys, "Cubic convolution interpolation for digital image processing", 1981, with a = -0.5 (as in
//! OpenImageIO and Nuke; OpenCV's INTER_CUBIC has -0.75 and rings more). Lanczos: C. Duchon, 1979, three lobes.

use super::simd::{LANES, load, store};
use pulp::Simd;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Weights of up to eight adjacent samples.
pub(crate) type Weights = [f32; LANES];

/// Table entries per sample spacing; linear interpolation between them is off by at most 1.1e-6.
const STEPS: usize = 1024;

/// Matrix from powers of the fraction (rows 0 to 3) to the weights of the samples at -1, 0, 1 and 2.
const CATMULL_ROM: [Weights; 4] = [
    [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, -2.5, 2.0, -0.5, 0.0, 0.0, 0.0, 0.0],
    [-0.5, 1.5, -1.5, 0.5, 0.0, 0.0, 0.0, 0.0],
];

static LANCZOS: LazyLock<Vec<Weights>> =
    LazyLock::new(|| (0..=STEPS).map(|step| lanczos_exact(step as f64 / STEPS as f64)).collect());

/// A separable filter that is the same for every pixel.
pub(super) trait Profile<const PAIRS: usize>: Copy {
    /// Returns the weights of 2·`PAIRS` samples, starting 1 − `PAIRS` after the preceding sample.
    fn weights<S: Simd>(self, simd: S, fraction: f32) -> Weights;
}

#[derive(Clone, Copy)]
pub(super) struct Cubic;

#[derive(Clone, Copy)]
pub(super) struct Lanczos<'a>(pub(super) &'a [Weights]);

impl Profile<2> for Cubic {
    #[inline(always)]
    fn weights<S: Simd>(self, simd: S, fraction: f32) -> Weights {
        let fraction = simd.splat_f32s(fraction);
        let [c0, c1, c2, c3] = &CATMULL_ROM;
        let high = simd.mul_add_e_f32s(load::<S>(c3), fraction, load::<S>(c2));
        let low = simd.mul_add_e_f32s(high, fraction, load::<S>(c1));
        store::<S>(simd.mul_add_e_f32s(low, fraction, load::<S>(c0)))
    }
}

impl Profile<3> for Lanczos<'_> {
    #[inline(always)]
    fn weights<S: Simd>(self, simd: S, fraction: f32) -> Weights {
        let place = fraction * STEPS as f32;
        // For a pixel outside the picture, the fraction is NaN and the step 0.
        let step = (place as i32 as usize).min(STEPS - 1);
        let part = simd.splat_f32s(place - step as f32);
        let (low, high) = (load::<S>(&self.0[step]), load::<S>(&self.0[step + 1]));
        store::<S>(simd.mul_add_e_f32s(part, simd.sub_f32s(high, low), low))
    }
}

/// Evaluates Catmull-Rom at eight distances.
#[inline(always)]
pub(super) fn catmull_rom<S: Simd>(simd: S, distance: S::f32s) -> S::f32s {
    let splat = |x: f32| simd.splat_f32s(x);
    let t = simd.abs_f32s(distance);
    // Beyond 2, the outer piece is evaluated at 2, where it is 0.
    let u = simd.min_f32s(t, splat(2.0));
    let near = simd.mul_add_e_f32s(splat(1.5), t, splat(-2.5));
    let near = simd.mul_add_e_f32s(near, simd.mul_f32s(t, t), splat(1.0));
    let far = simd.mul_add_e_f32s(splat(-0.5), u, splat(2.5));
    let far = simd.mul_add_e_f32s(simd.mul_add_e_f32s(far, u, splat(-4.0)), u, splat(2.0));
    simd.select_f32s(simd.less_than_f32s(t, splat(1.0)), near, far)
}

/// Returns the table of Lanczos weights, for [`Lanczos`] and its counterpart on devices.
pub(crate) fn lanczos_table() -> &'static [Weights] {
    &LANCZOS
}

fn lanczos_exact(fraction: f64) -> Weights {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let raw: [f64; 6] = std::array::from_fn(|k| {
        let distance = k as f64 - 2.0 - fraction;
        // At integers the sine is only nearly 0, but integer shifts must be exact.
        if distance.fract() == 0.0 {
            return f64::from(u8::from(distance == 0.0));
        }
        if distance.abs() < 3.0 { sinc(distance) * sinc(distance / 3.0) } else { 0.0 }
    });
    let sum: f64 = raw.iter().sum();
    std::array::from_fn(|k| raw.get(k).map_or(0.0, |weight| (weight / sum) as f32))
}
