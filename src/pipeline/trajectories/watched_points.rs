//! Chooses the points of a layer's model that couple the knots of its trajectory.
//!
//! In: a [`PreparedShot`], a layer, a frame. Out: points of its surface, attached to triangles as pins are.

use crate::pipeline::{PinAnchor, PreparedShot};
use crate::screen::primitive;
use glam::DVec3;

/// Number of points.
const WATCHED_POINTS: usize = 256;

/// Returns points spread evenly over the area of a layer's triangles in a frame, or the vertices of a layer that has only lines.
pub(in crate::pipeline) fn watched_points(prepared: &PreparedShot, index: usize, frame: f64) -> Vec<PinAnchor> {
    let (pose, _) = prepared.view(frame);
    let mut areas = Vec::new();
    let mut total = 0.0;
    for &part in &prepared.assignment.parts_of_layer[index] {
        let positions = &pose.parts[part].positions;
        let share = prepared.assignment.share(index, part);
        for (triangle, corners) in primitive(&prepared.scene, &pose.parts[part]).triangles.iter().enumerate() {
            let [a, b, c]: [DVec3; 3] = corners.map(|corner| positions[corner as usize].0.as_dvec3());
            total += (b - a).cross(c - a).length() * share.of(corners);
            areas.push((total, part, (triangle, *corners)));
        }
    }
    if total > 0.0 {
        let pick = |k: usize| {
            let wanted = total * (k as f64 + 0.5) / WATCHED_POINTS as f64;
            let (_, part, (triangle, corners)) =
                areas[areas.partition_point(|area| area.0 < wanted).min(areas.len() - 1)];
            PinAnchor::Surface { part, triangle, corners, barycentric: [1.0 / 3.0; 3] }
        };
        return (0..WATCHED_POINTS).map(pick).collect();
    }
    let vertices = prepared.assignment.parts_of_layer[index].iter().flat_map(|&part| {
        let lines = &primitive(&prepared.scene, &pose.parts[part]).lines;
        lines.iter().flatten().map(move |&vertex| (part, vertex))
    });
    let vertices: Vec<(usize, u32)> = vertices.collect();
    let step = vertices.len().div_ceil(WATCHED_POINTS).max(1);
    let pinned = |&(part, vertex): &(usize, u32)| PinAnchor::Surface {
        part,
        // A line has no triangle.
        triangle: usize::MAX,
        corners: [vertex; 3],
        barycentric: [1.0, 0.0, 0.0],
    };
    vertices.iter().step_by(step).map(pinned).collect()
}
