//! Chooses the points of a layer's model that couple the knots of its trajectory.
//!
//! In: a [`PreparedShot`], a layer, a frame. Out: points of its surface, attached to triangles as pins are.

use crate::pipeline::evaluate::screen_layer::is_branching;
use crate::pipeline::{PinAnchor, PreparedShot};
use crate::pose::Pose;
use crate::screen::primitive;
use glam::DVec3;

/// Smallest number of points.
const MIN_POINTS: usize = 256;

/// Largest number of points of a branching lattice.
const MAX_POINTS: usize = 1024;

/// Number of positions, per point, from which the points of a branching lattice are selected.
const CANDIDATES: usize = 8;

/// Barycentric coordinates of the corners of a triangle.
const CORNERS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns points of a layer's triangles in a frame, or the vertices of a layer that has only lines. The points are spread evenly over
/// the area. Those of a branching lattice are about as far apart as its handles, and tips of limbs and small islands have one.
pub(in crate::pipeline) fn watched_points(prepared: &PreparedShot, index: usize, frame: f64) -> Vec<PinAnchor> {
    let layer = &prepared.shot.layers[index];
    let (pose, _) = prepared.view(frame);
    let surface = Surface::of(prepared, index, &pose);
    if surface.area() > 0.0 {
        let handles: usize = layer.space.dims().into_iter().product();
        return match is_branching(layer) {
            true => surface.farthest_points(handles.clamp(MIN_POINTS, MAX_POINTS)),
            false => surface.even_points(MIN_POINTS, |_| [1.0 / 3.0; 3]),
        };
    }
    let vertices = prepared.assignment.parts_of_layer[index].iter().flat_map(|&part| {
        let lines = &primitive(&prepared.scene, &pose.parts[part]).lines;
        lines.iter().flatten().map(move |&vertex| (part, vertex))
    });
    let vertices: Vec<(usize, u32)> = vertices.collect();
    let step = vertices.len().div_ceil(MIN_POINTS).max(1);
    let pinned = |&(part, vertex): &(usize, u32)| PinAnchor::Surface {
        part,
        // A line has no triangle.
        triangle: usize::MAX,
        corners: [vertex; 3],
        barycentric: [1.0, 0.0, 0.0],
    };
    vertices.iter().step_by(step).map(pinned).collect()
}

/// The triangles of a layer that have an area.
struct Surface<'a> {
    pose: &'a Pose,
    triangles: Vec<Triangle>,
}

/// A triangle of a layer.
struct Triangle {
    /// The area up to and including this triangle.
    area_so_far: f64,
    part: usize,
    index: usize,
    corners: [u32; 3],
}

impl Triangle {
    fn at(&self, barycentric: [f64; 3]) -> PinAnchor {
        let &Self { part, index: triangle, corners, .. } = self;
        PinAnchor::Surface { part, triangle, corners, barycentric }
    }
}

impl<'a> Surface<'a> {
    fn of(prepared: &PreparedShot, index: usize, pose: &'a Pose) -> Self {
        let mut triangles = Vec::new();
        let mut area_so_far = 0.0;
        for &part in &prepared.assignment.parts_of_layer[index] {
            let positions = &pose.parts[part].positions;
            let share = prepared.assignment.share(index, part);
            for (index, &corners) in primitive(&prepared.scene, &pose.parts[part]).triangles.iter().enumerate() {
                let [a, b, c]: [DVec3; 3] = corners.map(|corner| positions[corner as usize].0.as_dvec3());
                let area = (b - a).cross(c - a).length() * share.of(&corners);
                if area > 0.0 {
                    area_so_far += area;
                    triangles.push(Triangle { area_so_far, part, index, corners });
                }
            }
        }
        Self { pose, triangles }
    }

    fn area(&self) -> f64 {
        self.triangles.last().map_or(0.0, |triangle| triangle.area_so_far)
    }

    /// Returns points that are spread evenly over the area. `barycentric` places each of them in its triangle.
    fn even_points(&self, count: usize, barycentric: impl Fn(usize) -> [f64; 3]) -> Vec<PinAnchor> {
        let pick = |k: usize| {
            let wanted = self.area() * (k as f64 + 0.5) / count as f64;
            let place = self.triangles.partition_point(|triangle| triangle.area_so_far < wanted);
            self.triangles[place.min(self.triangles.len() - 1)].at(barycentric(k))
        };
        (0..count).map(pick).collect()
    }

    /// Returns points each of which is as far as possible from those before it (farthest-point sampling: T. F. Gonzalez, Theoretical
    /// Computer Science 38, 1985, pages 293 to 306).
    fn farthest_points(&self, count: usize) -> Vec<PinAnchor> {
        let mut candidates = self.even_points(CANDIDATES * count, scattered);
        let step = self.triangles.len().div_ceil(CANDIDATES * count);
        let corners = |triangle: &Triangle| CORNERS.map(|corner| triangle.at(corner));
        candidates.extend(self.triangles.iter().step_by(step).flat_map(corners));
        let positions: Vec<DVec3> = candidates.iter().filter_map(|candidate| candidate.in_scene(self.pose)).collect();
        let mut distances = vec![f64::INFINITY; candidates.len()];
        let mut farthest = 0;
        let mut points = Vec::with_capacity(count);
        while points.len() < count && distances[farthest] > 0.0 {
            points.push(candidates[farthest]);
            let newest = positions[farthest];
            for (position, distance) in positions.iter().zip(&mut distances) {
                *distance = distance.min(newest.distance_squared(*position));
            }
            farthest = (0..distances.len()).max_by(|&a, &b| distances[a].total_cmp(&distances[b])).unwrap_or(0);
        }
        points
    }
}

/// Returns barycentric coordinates that fill a triangle evenly for consecutive numbers (M. Roberts, "The Unreasonable Effectiveness
/// of Quasirandom Sequences", 2018).
fn scattered(number: usize) -> [f64; 3] {
    let [mut u, mut v] = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| (number as f64 * step).fract());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    [u, v, 1.0 - u - v]
}
