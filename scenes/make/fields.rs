//! Distance fields of the gnome's clothes: negative inside, metres.

use glam::{DVec2, DVec3};

/// A capsule whose radius changes from `r0` to `r1`.
pub(crate) fn capsule(at: DVec3, from: DVec3, to: DVec3, [r0, r1]: [f64; 2]) -> f64 {
    let axis = to - from;
    let share = ((at - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    at.distance(from + axis * share) - (r0 + (r1 - r0) * share)
}

/// An ellipsoid; the distance is exact on its surface only.
pub(crate) fn ellipsoid(at: DVec3, center: DVec3, radii: DVec3) -> f64 {
    let unit = (at - center) / radii;
    (unit.length() - 1.0) * radii.min_element()
}

/// A torus around the y axis.
pub(crate) fn ring(at: DVec3, radius: f64, height: f64, thickness: f64) -> f64 {
    DVec2::new(DVec2::new(at.x, at.z).length() - radius, at.y - height).length() - thickness
}

/// A box with round edges.
pub(crate) fn block(at: DVec3, center: DVec3, half: DVec3, round: f64) -> f64 {
    let beyond = (at - center).abs() - half + round;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0) - round
}

/// Smooth minimum (I. Quílez's quadratic polynomial): blends over `reach`.
pub(crate) fn blended(a: f64, b: f64, reach: f64) -> f64 {
    let overlap = (1.0 - (a - b).abs() / reach).max(0.0);
    a.min(b) - overlap * overlap * reach * 0.25
}

/// The point mirrored to positive x, so that fields of the left side apply to both.
pub(crate) fn mirrored(at: DVec3) -> DVec3 {
    DVec3::new(at.x.abs(), at.y, at.z)
}
