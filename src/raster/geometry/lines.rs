//! Lines as ribbons of constant screen width, since native lines look different on every device.
//!
//! In: vertices and polylines. Out: raster vertices, two per point of the line, and two triangles per segment. Points
//! are warped, the width is not; depth and motion are those of the line itself.

use super::edge_bends::EdgeBends;
use super::part_warp::PartPoint;
use super::vertex::{ClipVertex, VertexList};
use crate::raster::RasterVertex;
use crate::screen::Camera;
use glam::{DVec2, Vec3};

/// Maximum widening of the ribbon at sharp turns.
const MITER_LIMIT: f64 = 2.0;

/// Depth bias: lines often lie on surfaces, so they are moved nearer by this fraction of their z.
const LIFT: f32 = 1e-3;

/// Maximum number of times a segment is halved.
const MAX_HALVINGS: u32 = 11;

/// The clipping and splitting of lines.
pub(super) struct LineClipper<'a> {
    pub(super) vertices: &'a VertexList<'a>,
    pub(super) near: f64,
    pub(super) bends: &'a EdgeBends<'a>,
}

impl LineClipper<'_> {
    /// Returns the parts of a line at or beyond the near plane, with curved segments halved until they are straight.
    pub(super) fn runs(&self, line: &[u32]) -> Vec<Vec<ClipVertex>> {
        let mut runs: Vec<Vec<ClipVertex>> = Vec::new();
        let mut is_open = false;
        for ends in line.windows(2) {
            let [a, b] = [ends[0], ends[1]].map(|vertex| self.vertices.get(vertex));
            let Some([from, to]) = self.cut(a, b) else {
                is_open = false;
                continue;
            };
            if !is_open || !self.is_seen(&a) {
                runs.push(vec![from]);
            }
            if let Some(run) = runs.last_mut() {
                self.split(run, [from, to], 0);
            }
            is_open = self.is_seen(&b);
        }
        runs
    }

    fn is_seen(&self, vertex: &ClipVertex) -> bool {
        vertex.places[0].depth >= self.near && vertex.places[0].w > 0.0
    }

    /// Returns the visible part of a segment.
    fn cut(&self, a: ClipVertex, b: ClipVertex) -> Option<[ClipVertex; 2]> {
        let is_number = |vertex: &ClipVertex| vertex.places[0].h.is_finite() && vertex.places[0].depth.is_finite();
        if !(is_number(&a) && is_number(&b)) {
            return None;
        }
        let depth = |vertex: &ClipVertex| vertex.places[0].depth;
        let middle = |seen: &ClipVertex, hidden: &ClipVertex| {
            seen.lerp(hidden, ((self.near - depth(seen)) / (depth(hidden) - depth(seen))).clamp(0.0, 1.0))
        };
        match (self.is_seen(&a), self.is_seen(&b)) {
            (true, true) => Some([a, b]),
            (true, false) => Some([a, middle(&a, &b)]),
            (false, true) => Some([middle(&b, &a), b]),
            (false, false) => None,
        }
    }

    /// Appends the end of a segment, after the intermediate points that the warp needs.
    fn split(&self, run: &mut Vec<ClipVertex>, [a, b]: [ClipVertex; 2], halvings: u32) {
        let place = |vertex: &ClipVertex| vertex.places[0].point().0;
        if halvings < MAX_HALVINGS
            && self.bends.bends([place(&a), place(&b)], [PartPoint { weights: &[], triangle: 0 }; 2])
        {
            let middle = a.lerp(&b, 0.5);
            self.split(run, [a, middle], halvings + 1);
            self.split(run, [middle, b], halvings + 1);
        } else {
            run.push(b);
        }
    }
}

/// Appends the ribbon along a run of warped points.
pub(super) fn add_ribbon(
    points: &[RasterVertex],
    (camera, width): (&Camera, f64),
    (vertices, triangles): (&mut Vec<RasterVertex>, &mut Vec<[u32; 3]>),
) {
    let first = vertices.len() as u32;
    vertices.extend(sides(points, (camera, width)).into_iter().flatten());
    for segment in 0..points.len() as u32 - 1 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + 2 * segment + k);
        triangles.extend([[a, b, d], [a, d, c]]);
    }
}

/// Returns the left and right border of every point; `points` has at least two.
fn sides(points: &[RasterVertex], (camera, width): (&Camera, f64)) -> Vec<[RasterVertex; 2]> {
    let places: Vec<DVec2> = points.iter().map(RasterVertex::on_screen).collect();
    let is_closed = places.len() > 3 && places.first() == places.last();
    let last = places.len() - 1;
    let direction = |from: usize, to: usize| (places[to] - places[from]).normalize_or_zero();
    let sides = points.iter().enumerate().map(|(k, point)| {
        let before = match k {
            0 if is_closed => direction(last - 1, last),
            0 => DVec2::ZERO,
            _ => direction(k - 1, k),
        };
        let after = match k {
            _ if k < last => direction(k, k + 1),
            _ if is_closed => direction(0, 1),
            _ => DVec2::ZERO,
        };
        let out = miter(before, after) * (0.5 * width);
        // Square caps, so that lines meeting at their ends leave no notch.
        let along = if is_closed { DVec2::ZERO } else { (before - after) * (0.5 * width) * end_share(k, last) };
        [along + out, along - out].map(|by| shifted(point, by, camera))
    });
    sides.collect()
}

/// Returns 1 at the ends of a line, else 0.
fn end_share(k: usize, last: usize) -> f64 {
    if k == 0 || k == last { 1.0 } else { 0.0 }
}

/// Returns the vector from the centre line to the left border at a turn, for a ribbon of half width 1.
fn miter(before: DVec2, after: DVec2) -> DVec2 {
    let tangent = (before + after).normalize_or(before);
    let left = tangent.perp();
    let straight = if before == DVec2::ZERO { after } else { before };
    left / left.dot(straight.perp()).max(1.0 / MITER_LIMIT)
}

/// Returns a vertex displaced from the line, at all three times, with its normal facing the viewer.
fn shifted(point: &RasterVertex, by: DVec2, camera: &Camera) -> RasterVertex {
    let by = by.as_vec2();
    let aside = |[x, y, w]: [f32; 3]| [x + by.x * w, y + by.y * w, w];
    let [x, y, z, w] = point.screen;
    let [x, y, _] = aside([x, y, w]);
    RasterVertex {
        screen: [x, y, (z * (1.0 + LIFT)).min(w), w],
        next: aside(point.next),
        previous: aside(point.previous),
        normal: to_viewer(point, camera).to_array(),
        ..*point
    }
}

fn to_viewer(point: &RasterVertex, camera: &Camera) -> Vec3 {
    let towards = camera.eye().0 - Vec3::from_array(point.position);
    if camera.is_parallel() { camera.towards_viewer() } else { towards.normalize_or(Vec3::Z) }
}
