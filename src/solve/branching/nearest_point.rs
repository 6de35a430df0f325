//! The point of a triangle that is nearest to a point, in the plane and in space.
//!
//! In: a point, three corners. Out: the nearest point, or its barycentric coordinates.

use crate::solve::linalg::small_matrix::{dot, minus};

/// The point of a triangle that is nearest to a point.
pub(super) fn nearest_of_triangle<const D: usize>(point: &[f64; D], corners: &[[f64; D]; 3]) -> [f64; D] {
    let [a, b, c] = corners;
    let [_, v, w] = nearest_barycentric(point, corners);
    std::array::from_fn(|d| a[d] + v * (b[d] - a[d]) + w * (c[d] - a[d]))
}

/// The squared distance of a point from the bounding box of a triangle.
pub(super) fn squared_distance_to_box<const D: usize>(point: &[f64; D], [a, b, c]: &[[f64; D]; 3]) -> f64 {
    let outside = |d: usize| {
        let (low, high) = (a[d].min(b[d]).min(c[d]), a[d].max(b[d]).max(c[d]));
        (low - point[d]).max(point[d] - high).max(0.0)
    };
    (0..D).map(|d| outside(d).powi(2)).sum()
}

/// Barycentric coordinates of the point of a triangle that is nearest to a point (C. Ericson, "Real-Time Collision Detection", 2005,
/// section 5.1.5).
pub(crate) fn nearest_barycentric<const D: usize>(point: &[f64; D], [a, b, c]: &[[f64; D]; 3]) -> [f64; 3] {
    let blend = |v: f64, w: f64| [1.0 - v - w, v, w];
    let (ab, ac) = (minus(b, a), minus(c, a));
    let [(d1, d2), (d3, d4), (d5, d6)] = [a, b, c].map(|corner| {
        let gap = minus(point, corner);
        (dot(&ab, &gap), dot(&ac, &gap))
    });
    let share = |part: f64, whole: f64| if whole > 0.0 { (part / whole).clamp(0.0, 1.0) } else { 0.0 };
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        blend(0.0, 0.0)
    } else if d3 >= 0.0 && d4 <= d3 {
        blend(1.0, 0.0)
    } else if d6 >= 0.0 && d5 <= d6 {
        blend(0.0, 1.0)
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        blend(share(d1, d1 - d3), 0.0)
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        blend(0.0, share(d2, d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = share(d4 - d3, (d4 - d3) + (d5 - d6));
        blend(1.0 - w, w)
    } else {
        let whole = va + vb + vc;
        blend(share(vb, whole), share(vc, whole))
    }
}
