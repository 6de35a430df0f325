//! Clips triangles at the near plane (Sutherland and Hodgman 1974 for a single plane).
//!
//! In: three projected corners. Out: zero, one or two triangles whose corners are interpolated from the given ones.

use super::camera::Projected;

/// A corner of a clipped triangle: a point on the edge from corner `from` to corner `to` of the original triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corner {
    /// 0, 1 or 2.
    pub(crate) from: usize,
    /// 0, 1 or 2; equal to `from` for a corner that was kept.
    pub(crate) to: usize,
    /// Fraction of the way from `from` to `to`, 0 for a kept corner.
    pub(crate) t: f64,
}

impl Corner {
    /// Returns the barycentric coordinates in the original triangle.
    #[must_use]
    pub(crate) fn barycentric(self) -> [f64; 3] {
        let mut weights = [0.0; 3];
        weights[self.from] += 1.0 - self.t;
        weights[self.to] += self.t;
        weights
    }
}

/// Returns the part of a triangle at or beyond the near plane, as a fan of at most two triangles with the same
/// orientation.
///
/// A clipped point depends only on its edge, not on the triangle or the order of the corners, so neighbours meet
/// exactly. Triangles with a non-finite corner are dropped.
#[must_use]
pub(crate) fn clip_near(corners: [Projected; 3], near: f64) -> ([[Corner; 3]; 2], usize) {
    let is_kept = corners.map(|corner| corner.depth >= near && corner.w > 0.0);
    let kept = |corner: usize| Corner { from: corner, to: corner, t: 0.0 };
    let whole = [kept(0), kept(1), kept(2)];
    // Always interpolated from the visible end to the hidden one, whatever the winding.
    let cut = |seen: usize, hidden: usize| {
        let (a, b) = (corners[seen].depth, corners[hidden].depth);
        Corner { from: seen, to: hidden, t: ((near - a) / (b - a)).clamp(0.0, 1.0) }
    };
    let next = |corner: usize| (corner + 1) % 3;
    if corners.iter().any(|corner| !(corner.h.is_finite() && corner.depth.is_finite())) {
        return ([whole; 2], 0);
    }
    match is_kept.iter().filter(|&&kept| kept).count() {
        3 => ([whole; 2], 1),
        2 => {
            let hidden = is_kept.iter().position(|&kept| !kept).unwrap_or(0);
            let (a, b) = (next(hidden), next(next(hidden)));
            let (from_a, from_b) = (cut(a, hidden), cut(b, hidden));
            ([[kept(a), kept(b), from_b], [kept(a), from_b, from_a]], 2)
        }
        1 => {
            let seen = is_kept.iter().position(|&kept| kept).unwrap_or(0);
            let (a, b) = (next(seen), next(next(seen)));
            ([[kept(seen), cut(seen, a), cut(seen, b)]; 2], 1)
        }
        _ => ([whole; 2], 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn at(x: f64, y: f64, depth: f64) -> Projected {
        Projected { h: DVec2::new(x, y), w: depth, depth }
    }

    fn depths(corners: [Projected; 3], near: f64) -> Vec<f64> {
        let (triangles, count) = clip_near(corners, near);
        let depth = |corner: &Corner| (0..3).map(|i| corner.barycentric()[i] * corners[i].depth).sum();
        triangles[..count].iter().flatten().map(depth).collect()
    }

    #[test]
    fn nothing_in_front_of_the_near_plane_survives() {
        assert_eq!(depths([at(0.0, 0.0, 0.05), at(1.0, 0.0, -3.0), at(0.0, 1.0, 0.0)], 0.1), Vec::<f64>::new());
        for corners in [
            [at(0.0, 0.0, 2.0), at(1.0, 0.0, -3.0), at(0.0, 1.0, 1.0)],
            [at(0.0, 0.0, -2.0), at(1.0, 0.0, -3.0), at(0.0, 1.0, 1.0)],
        ] {
            let depths = depths(corners, 0.1);
            assert!(!depths.is_empty() && depths.iter().all(|&depth| depth >= 0.1 - 1e-12), "{depths:?}");
        }
    }

    #[test]
    fn neighbours_cut_their_shared_edge_at_the_same_point() {
        let (seen, hidden) = (at(0.3, 0.1, 2.0), at(1.0, 0.0, -3.0));
        let t_of_cut = |corners: [Projected; 3], from: usize, to: usize| {
            let (triangles, count) = clip_near(corners, 0.1);
            let on_edge = |corner: &&Corner| corner.from == from && corner.to == to;
            triangles[..count].iter().flatten().find(on_edge).map(|corner| corner.t)
        };
        let one = t_of_cut([seen, hidden, at(0.0, 5.0, 1.0)], 0, 1);
        let other = t_of_cut([hidden, seen, at(0.0, -5.0, -1.0)], 1, 0);
        assert!(one.is_some());
        assert_eq!(one, other);
    }

    #[test]
    fn not_a_number_is_dropped() {
        assert_eq!(clip_near([at(f64::NAN, 0.0, 1.0), at(0.0, 0.0, 1.0), at(1.0, 0.0, 1.0)], 0.1).1, 0);
    }
}
