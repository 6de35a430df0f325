//! Casts a screen point onto the front-most unwarped surface.
//!
//! In: a projected pose and a screen point. Out: part, triangle, barycentric coordinates.

use super::camera::Projected;
use super::clip::clip_near;
use super::mesh::{ScreenMesh, primitive};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::space::ScreenPoint;
use glam::DVec2;
use rayon::prelude::*;

/// Number of triangles that a thread tests at a time.
const CHUNK: usize = 16_384;

/// A surface point hit by a pick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Index into [`Pose::parts`].
    pub(crate) part: usize,
    /// Index into the primitive's triangles.
    pub(crate) triangle: usize,
    /// Barycentric coordinates in scene space; they sum to 1.
    pub(crate) barycentric: [f64; 3],
    /// Distance along the view axis in metres.
    pub(crate) depth: f64,
}

/// Returns the nearest surface at a screen point; `None` if there is none. Both sides of a surface count.
#[must_use]
pub(crate) fn pick(scene: &Scene, pose: &Pose, mesh: &ScreenMesh, near: f64, at: ScreenPoint) -> Option<Hit> {
    let of_part = |(part, posed): (usize, &crate::pose::PosedPart)| {
        let vertices = &mesh.parts[part].vertices;
        let of_triangle = move |(triangle, corners): (usize, &[u32; 3])| {
            let (barycentric, depth) = hit_triangle(corners.map(|corner| vertices[corner as usize]), near, at)?;
            Some(Hit { part, triangle, barycentric, depth })
        };
        let of_chunk = move |(chunk, triangles): (usize, &[[u32; 3]])| {
            let numbered = triangles.iter().enumerate().map(|(index, corners)| (chunk * CHUNK + index, corners));
            nearest(numbered.filter_map(of_triangle))
        };
        let hits = primitive(scene, posed).triangles.par_chunks(CHUNK).enumerate().map(of_chunk);
        hits.collect::<Vec<Option<Hit>>>().into_iter().flatten()
    };
    nearest(pose.parts.iter().enumerate().flat_map(of_part))
}

/// Returns the hit with the least depth; the first one of several.
fn nearest(hits: impl Iterator<Item = Hit>) -> Option<Hit> {
    hits.min_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// Returns the barycentric coordinates (in scene space) and depth of a screen point on a triangle.
fn hit_triangle(corners: [Projected; 3], near: f64, at: ScreenPoint) -> Option<([f64; 3], f64)> {
    let (cut, count) = clip_near(corners, near);
    cut[..count].iter().find_map(|cut| {
        let ends = cut.map(|corner| corners[corner.from].lerp(corners[corner.to], corner.t));
        let on_screen = screen_barycentric(ends.map(|end| end.point().0), at.0)?;
        // Dividing screen weights by w gives scene weights (perspective-correct interpolation).
        let over_w: [f64; 3] = std::array::from_fn(|i| on_screen[i] / ends[i].w);
        let total: f64 = over_w.iter().sum();
        let mut barycentric = [0.0; 3];
        for (corner, share) in cut.iter().zip(over_w) {
            let weights = corner.barycentric();
            (0..3).for_each(|i| barycentric[i] += weights[i] * share / total);
        }
        let depth = (0..3).map(|i| barycentric[i] * corners[i].depth).sum();
        Some((barycentric, depth))
    })
}

/// Returns the barycentric coordinates of a point in a screen triangle of either orientation; `None` if outside or
/// degenerate.
fn screen_barycentric(ends: [DVec2; 3], at: DVec2) -> Option<[f64; 3]> {
    let area = (ends[1] - ends[0]).perp_dot(ends[2] - ends[0]);
    let weight = |a: DVec2, b: DVec2| (a - at).perp_dot(b - at) / area;
    let weights = [weight(ends[1], ends[2]), weight(ends[2], ends[0]), weight(ends[0], ends[1])];
    weights.iter().all(|&weight| weight >= 0.0).then_some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, depth: f64) -> Projected {
        Projected { h: DVec2::new(x, y) * depth, w: depth, depth }
    }

    #[test]
    fn perspective_weights_reproduce_the_point() {
        let corners = [at(0.1, 0.1, 1.0), at(0.9, 0.2, 5.0), at(0.3, 0.8, 2.0)];
        let wanted = ScreenPoint::new(0.4, 0.35);
        let (weights, depth) = hit_triangle(corners, 0.1, wanted).expect("inside");
        let h: DVec2 = (0..3).map(|i| corners[i].h * weights[i]).sum();
        let w: f64 = (0..3).map(|i| corners[i].w * weights[i]).sum();
        assert!((h / w - wanted.0).length() < 1e-12 && (w - depth).abs() < 1e-12);
    }

    #[test]
    fn outside_and_flat_triangles_are_missed() {
        let corners = [at(0.0, 0.0, 1.0), at(1.0, 0.0, 1.0), at(0.0, 1.0, 1.0)];
        assert!(hit_triangle(corners, 0.1, ScreenPoint::new(0.9, 0.9)).is_none());
        assert!(hit_triangle([corners[0]; 3], 0.1, ScreenPoint::new(0.0, 0.0)).is_none());
    }
}
