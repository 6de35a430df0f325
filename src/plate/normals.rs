//! Rotates normals with the picture.
//!
//! In: view-space normals (x right, y up, z towards the viewer) of the visible pixels, and the map. Out: the same,
//! rotated about the view axis by the rotation nearest to the gradient of the warp (its polar factor).

use super::WarpMap;
use super::composite::Composite;
use super::visible_samples::VisibleSample;
use rayon::prelude::*;

/// Rotations below this, in radians, leave the normals bit-exact.
const MIN_ANGLE: f64 = 1e-6;

/// Rotates the first two components of the visible normals of a composite; each: #pixels of the composite.
pub(super) fn turn_normals(
    composite: &Composite,
    visible: &[VisibleSample],
    [xs, ys]: [&mut [f32]; 2],
    pixel_aspect: f64,
) {
    let pixels = xs.par_iter_mut().zip(ys).zip(visible).enumerate();
    pixels.for_each(|(at, ((x, y), seen))| {
        let VisibleSample::Sample { layer, .. } = seen else { return };
        let layer = &composite.layers[usize::from(*layer)];
        let pixel = composite.window.pixel_at(at);
        let Some((map, index)) = layer.map.as_ref().zip(layer.window.sample_index(pixel)) else { return };
        let angle = rotation(map, index, pixel_aspect);
        if angle.abs() > MIN_ANGLE {
            let (sin, cos) = angle.sin_cos();
            let [old_x, old_y] = [f64::from(*x), f64::from(*y)];
            (*x, *y) = ((cos * old_x - sin * old_y) as f32, (sin * old_x + cos * old_y) as f32);
        }
    });
}

/// Returns the counter-clockwise rotation of the picture at a pixel, in radians.
///
/// The map is an inverse and has y down: each flips the sign, so its angle is that of the warp.
fn rotation(map: &WarpMap, index: usize, pixel_aspect: f64) -> f64 {
    let [[xx, xy], [yx, yy]] = map.jacobian(index).map(|row| row.map(f64::from));
    (yx / pixel_aspect - xy * pixel_aspect).atan2(xx + yy)
}
