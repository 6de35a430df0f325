//! Divides triangles along lines, so that none of them lies on both sides of a line: constrained Delaunay triangulation (crate spade).
//!
//! In: a triangulation in the plane and polylines. Out: a triangulation of the same area that has the polylines as edges.

use super::mesh::{Triangulated, divided, is_well_inside, packed};
use super::simplify::{distance_to_segment, simplified_line};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};
use std::collections::{BTreeMap, BTreeSet};

/// Inner vertices nearer to a line than this fraction of an edge length are dropped: they would make slivers.
const CLEARANCE: f64 = 0.35;

/// Maximum number of points of all lines; more are simplified further.
const MAX_POINTS: usize = 4000;

type Net = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Divides triangles, counter-clockwise with y up, along lines. Lines keep within `tolerance` of what is given, unless they have too many
/// points.
pub(in crate::scene) fn cut_along(mesh: &Triangulated, lines: &[Vec<[f64; 2]>], tolerance: f64) -> Triangulated {
    let spacing = mean_edge(mesh);
    let lines = simplified(lines, tolerance, spacing);
    let rim = rim(mesh);
    let on_rim: BTreeSet<usize> = rim.iter().flatten().copied().collect();
    let is_clear = |at: [f64; 2]| {
        let segments = lines.iter().flat_map(|line| line.windows(2));
        segments.into_iter().all(|pair| distance_to_segment(at, pair[0], pair[1]) > CLEARANCE * spacing)
    };
    let mut net = Net::new();
    let mut vertices = BTreeMap::new();
    for (index, &at) in mesh.points.iter().enumerate() {
        if on_rim.contains(&index) || is_clear(at) {
            let Ok(vertex) = net.insert(Point2::new(at[0], at[1])) else { continue };
            vertices.insert(index, vertex);
        }
    }
    for ends in &rim {
        if let [Some(&from), Some(&to)] = ends.map(|end| vertices.get(&end)) {
            net.add_constraint_and_split(from, to, |point| point);
        }
    }
    for line in &lines {
        let mut before = None;
        for &[x, y] in line {
            let Ok(vertex) = net.insert(Point2::new(x, y)) else { continue };
            if let Some(before) = before.filter(|before| *before != vertex) {
                net.add_constraint_and_split(before, vertex, |point| point);
            }
            before = Some(vertex);
        }
    }
    let places: Vec<[f64; 2]> = net.vertices().map(|vertex| [vertex.position().x, vertex.position().y]).collect();
    let segments: Vec<_> = rim.iter().map(|&[from, to]| (mesh.points[from], mesh.points[to])).collect();
    let faces = net.inner_faces().map(|face| face.vertices().map(|corner| corner.index()));
    let is_inside = |corners: &[usize; 3]| {
        let middle = [0, 1].map(|axis| corners.iter().map(|&corner| places[corner][axis]).sum::<f64>() / 3.0);
        is_well_inside(&segments, middle, 0.0)
    };
    packed(&places, faces.filter(is_inside).collect())
}

/// Simplifies lines, all of them more if they have too many points, and splits segments that are longer than an edge.
fn simplified(lines: &[Vec<[f64; 2]>], mut tolerance: f64, spacing: f64) -> Vec<Vec<[f64; 2]>> {
    loop {
        let is_kept = |line: &&Vec<[f64; 2]>| extent(line) > 2.0 * tolerance;
        let simple: Vec<_> = lines.iter().filter(is_kept).map(|line| simplified_line(line, tolerance)).collect();
        if simple.iter().map(Vec::len).sum::<usize>() <= MAX_POINTS {
            return simple.iter().map(|line| divided(line, spacing)).collect();
        }
        tolerance *= 2.0;
    }
}

/// The longer side of a line's bounding box.
fn extent(line: &[[f64; 2]]) -> f64 {
    let along = |axis: usize| {
        let [low, high] = line.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], point| {
            [low.min(point[axis]), high.max(point[axis])]
        });
        high - low
    };
    along(0).max(along(1))
}

/// The side of an equilateral triangle of mean area.
fn mean_edge(mesh: &Triangulated) -> f64 {
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| mesh.points[corner as usize]);
        (0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))).abs()
    };
    let total: f64 = mesh.triangles.iter().map(area).sum();
    (total / mesh.triangles.len().max(1) as f64 * 4.0 / 3.0_f64.sqrt()).sqrt()
}

/// Returns the edges of only one triangle.
fn rim(mesh: &Triangulated) -> Vec<[usize; 2]> {
    let mut counts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for corners in &mesh.triangles {
        for k in 0..3 {
            let [a, b] = [corners[k] as usize, corners[(k + 1) % 3] as usize];
            *counts.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    counts.into_iter().filter(|&(_, count)| count == 1).map(|(ends, _)| ends).collect()
}
