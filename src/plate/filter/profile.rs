//! Filter profiles: the weights of samples around a place.
//!
//! In: the fraction of a place behind a sample, or a distance. Out: weights, which sum to 1 for the separable ones.
//!
//! Catmull-Rom: R. Keys, "Cubic convolution interpolation for digital image processing", 1981, with a = -0.5
//! (OpenImageIO's and Nuke's; OpenCV's INTER_CUBIC has -0.75 and rings more). Lanczos: C. Duchon, 1979, three lobes.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Weights of up to eight samples side by side.
pub(super) type Weights = [f32; 8];

/// Steps of a table of weights a sample; between them weights are linear: 1.1e-6 off at most.
const STEPS: usize = 1024;

/// Powers of the fraction (rows 0 to 3) to the weights of the samples at -1, 0, 1 and 2.
const CATMULL_ROM: [[f32; 4]; 4] =
    [[0.0, 1.0, 0.0, 0.0], [-0.5, 0.0, 0.5, 0.0], [1.0, -2.5, 2.0, -0.5], [-0.5, 1.5, -1.5, 0.5]];

static LANCZOS: LazyLock<Vec<Weights>> =
    LazyLock::new(|| (0..=STEPS).map(|step| lanczos_exact(step as f64 / STEPS as f64)).collect());

/// A product, and a sum: fused where the processor can, since a call to a library would be slow.
#[inline(always)]
pub(super) fn fma<const FUSED: bool>(a: f32, b: f32, c: f32) -> f32 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Catmull-Rom weights of the four samples from -1.
#[inline(always)]
pub(super) fn cubic<const FUSED: bool>(fraction: f32) -> Weights {
    let mut weights = [0.0; 8];
    for (k, weight) in weights[..4].iter_mut().enumerate() {
        let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|power| CATMULL_ROM[power][k]);
        *weight = fma::<FUSED>(fma::<FUSED>(fma::<FUSED>(c3, fraction, c2), fraction, c1), fraction, c0);
    }
    weights
}

/// Catmull-Rom at a distance.
#[inline(always)]
pub(super) fn catmull_rom<const FUSED: bool>(distance: f32) -> f32 {
    let t = distance.abs();
    let near = fma::<FUSED>(fma::<FUSED>(1.5, t, -2.5), t * t, 1.0);
    let far = fma::<FUSED>(fma::<FUSED>(fma::<FUSED>(-0.5, t, 2.5), t, -4.0), t, 2.0);
    if t < 1.0 {
        near
    } else if t < 2.0 {
        far
    } else {
        0.0
    }
}

/// The table of Lanczos weights, for [`lanczos`].
pub(super) fn lanczos_table() -> &'static [Weights] {
    &LANCZOS
}

/// Lanczos weights of the six samples from -2.
#[inline(always)]
pub(super) fn lanczos<const FUSED: bool>(table: &[Weights], fraction: f32) -> Weights {
    let place = fraction * STEPS as f32;
    let step = (place as usize).min(STEPS - 1);
    let part = place - step as f32;
    let (low, high) = (&table[step], &table[step + 1]);
    std::array::from_fn(|k| fma::<FUSED>(part, high[k] - low[k], low[k]))
}

fn lanczos_exact(fraction: f64) -> Weights {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let raw: [f64; 6] = std::array::from_fn(|k| {
        let distance = k as f64 - 2.0 - fraction;
        // At whole distances the sine is only nearly 0, and whole shifts have to be exact.
        if distance.fract() == 0.0 {
            return f64::from(u8::from(distance == 0.0));
        }
        if distance.abs() < 3.0 { sinc(distance) * sinc(distance / 3.0) } else { 0.0 }
    });
    let sum: f64 = raw.iter().sum();
    std::array::from_fn(|k| raw.get(k).map_or(0.0, |weight| (weight / sum) as f32))
}
