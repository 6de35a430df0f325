//! Triangulates the inside of outlines: constrained Delaunay triangulation (crate spade), refined after Ruppert, "A
//! Delaunay Refinement Algorithm for Quality 2-Dimensional Mesh Generation", 1995.
//!
//! In: closed outlines and an edge length. Out: points and triangles, sorted independently of the crate's order.

use super::contour::pairs;
use super::simplify::distance_to_segment;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation as _};
use std::collections::BTreeMap;

/// Minimum angle in degrees, except where the outline itself has smaller ones.
const MIN_ANGLE: f64 = 20.0;

/// Inner points keep this fraction of an edge length away from the outline.
const CLEARANCE: f64 = 0.6;

/// Maximum area of a triangle in squared edge lengths; equilateral ones have √3/4.
const LARGEST: f64 = 0.75;

/// Maximum number of vertices that refinement adds per existing vertex.
const ADDED: usize = 3;

/// A triangulation in the plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::scene) struct Triangulated {
    /// #vertices.
    pub(in crate::scene) points: Vec<[f64; 2]>,
    /// Vertex indices, counter-clockwise as seen in image space (y down).
    pub(in crate::scene) triangles: Vec<[u32; 3]>,
}

/// Triangulates the points inside an odd number of outlines; `None` if outlines cross.
pub(super) fn triangulate(outlines: &[Vec<[f64; 2]>], spacing: f64) -> Option<Triangulated> {
    let outlines: Vec<Vec<[f64; 2]>> = outlines.iter().map(|points| divided_loop(points, spacing)).collect();
    let mut points = Vec::new();
    let mut edges = Vec::new();
    for outline in &outlines {
        let (first, count) = (points.len(), outline.len());
        edges.extend((0..count).map(|k| [first + k, first + (k + 1) % count]));
        points.extend(outline.iter().map(|&[x, y]| Point2::new(x, y)));
    }
    points.extend(inner_points(&outlines, spacing));
    let count = points.len();
    let mut crosses = false;
    let net = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, edges, |_| crosses = true);
    let mut net = net.ok().filter(|net| net.num_vertices() == count)?;
    if crosses {
        return None;
    }
    let parameters = RefinementParameters::new()
        .exclude_outer_faces(true)
        .with_angle_limit(AngleLimit::from_deg(MIN_ANGLE))
        .with_max_allowed_area(LARGEST * spacing * spacing)
        .with_max_additional_vertices(ADDED * count);
    let outside = net.refine(parameters).excluded_faces.into_iter().collect::<std::collections::HashSet<_>>();
    let inside = net.inner_faces().filter(|face| !outside.contains(&face.fix()));
    // Counter-clockwise with y up is clockwise with y down.
    let triangles = inside.map(|face| face.vertices().map(|corner| corner.index()));
    let triangles: Vec<[usize; 3]> = triangles.map(|[a, b, c]| [a, c, b]).collect();
    let places: Vec<[f64; 2]> = net.vertices().map(|vertex| [vertex.position().x, vertex.position().y]).collect();
    Some(packed(&places, triangles))
}

/// Splits the long segments of an outline as [`divided`] does.
fn divided_loop(points: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let mut divided = divided(&[points, &points[..1]].concat(), spacing);
    divided.pop();
    divided
}

/// Splits the long segments of a line into equal pieces of at most `spacing`.
pub(super) fn divided(line: &[[f64; 2]], spacing: f64) -> Vec<[f64; 2]> {
    let pieces = |pair: &[[f64; 2]]| {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
        let count = ((bx - ax).hypot(by - ay) / spacing).ceil().max(1.0);
        (0..count as usize).map(move |k| {
            let share = k as f64 / count;
            [ax + (bx - ax) * share, ay + (by - ay) * share]
        })
    };
    line.windows(2).flat_map(pieces).chain(line.last().copied()).collect()
}

/// Returns the points of a triangular lattice inside the outlines, with clearance.
fn inner_points(outlines: &[Vec<[f64; 2]>], spacing: f64) -> Vec<Point2<f64>> {
    let all = || outlines.iter().flatten();
    let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| all().map(|point| point[axis]).fold(start, pick);
    let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY));
    let high = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY));
    let step = [spacing, 0.75_f64.sqrt() * spacing];
    let count = |axis: usize| ((high[axis] - low[axis]) / step[axis]).max(0.0) as usize;
    let segments: Vec<_> = outlines.iter().flat_map(|outline| pairs(outline)).collect();
    let mut points = Vec::new();
    for row in 1..=count(1) {
        let shift = if row % 2 == 0 { 0.5 } else { 0.0 };
        for column in 0..=count(0) {
            let at = [low[0] + (column as f64 + shift) * step[0], low[1] + row as f64 * step[1]];
            if is_well_inside(&segments, at, CLEARANCE * spacing) {
                points.push(Point2::new(at[0], at[1]));
            }
        }
    }
    points
}

/// Whether a point is inside by the even-odd rule, with no segment nearer than `clearance`.
pub(super) fn is_well_inside(segments: &[([f64; 2], [f64; 2])], at: [f64; 2], clearance: f64) -> bool {
    let mut is_inside = false;
    for &(a, b) in segments {
        if distance_to_segment(at, a, b) < clearance {
            return false;
        }
        let is_between = (a[1] > at[1]) != (b[1] > at[1]);
        if is_between && at[0] < a[0] + (at[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            is_inside = !is_inside;
        }
    }
    is_inside
}

/// Drops unused vertices and sorts the others in reading order; sorts triangles, smallest corner first.
pub(super) fn packed(points: &[[f64; 2]], triangles: Vec<[usize; 3]>) -> Triangulated {
    let mut used: Vec<usize> = triangles.iter().flatten().copied().collect();
    used.sort_by(|&a, &b| points[a][1].total_cmp(&points[b][1]).then(points[a][0].total_cmp(&points[b][0])));
    used.dedup();
    let places: BTreeMap<usize, u32> = used.iter().zip(0..).map(|(&vertex, place)| (vertex, place)).collect();
    let mut corners: Vec<[u32; 3]> =
        triangles.into_iter().map(|corners| min_first(corners.map(|c| places[&c]))).collect();
    corners.sort_unstable();
    Triangulated { points: used.into_iter().map(|vertex| points[vertex]).collect(), triangles: corners }
}

/// Rotates the corners so that the smallest comes first.
fn min_first(mut corners: [u32; 3]) -> [u32; 3] {
    let least = corners.iter().zip(0..).min().map_or(0, |(_, place)| place);
    corners.rotate_left(least);
    corners
}
