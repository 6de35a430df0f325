//! The mesh of a figure: the body on a triangular lattice inside its border, details triangulated between their border
//! points.
//!
//! In: a figure. Out: exactly the requested number of vertices, and triangles by part. Triangulation: crate spade
//! (constrained Delaunay).

use super::draw::Outline;
use super::{Body, Figure};
use crate::make::outline::{contour, gradient};
use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};

/// A figure's mesh.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) vertices: Vec<DVec2>,
    pub(crate) parts: Vec<MeshPart>,
    /// Number of vertices of the body, which come first.
    pub(crate) body_vertices: usize,
}

/// Triangles of one colour.
pub(crate) struct MeshPart {
    pub(crate) name: &'static str,
    pub(crate) color: &'static str,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Meshes a figure. Coordinates are rounded as in the file before anything is computed from them.
pub(crate) fn mesh(figure: &Figure) -> Mesh {
    let taken: usize = figure.details.iter().map(|detail| detail.border).sum();
    let mut mesh = Mesh { body_vertices: figure.vertices - taken, ..Mesh::default() };
    let (points, border) = body_points(&figure.body, mesh.body_vertices);
    let triangles = triangulate(&points, border);
    mesh.parts = colored(&figure.body, &points, &triangles);
    mesh.vertices = points;
    for detail in &figure.details {
        let points: Vec<DVec2> = detail.outline.points(detail.border).into_iter().map(rounded).collect();
        let first = mesh.vertices.len() as u32;
        let triangles = triangulate(&points, points.len());
        let triangles = triangles.into_iter().map(|corners| corners.map(|corner| corner + first)).collect();
        mesh.parts.push(MeshPart { name: detail.name, color: detail.color, triangles });
        mesh.vertices.extend(points);
    }
    mesh
}

/// Rounds to four decimals.
pub(crate) fn rounded(at: DVec2) -> DVec2 {
    (at * 1e4).round() / 1e4
}

/// Points of the border and of the interior, `count` in total, approximately evenly spaced; and the number of border
/// points.
fn body_points(body: &Body, count: usize) -> (Vec<DVec2>, usize) {
    let curve = Outline(contour(&body.field, 0.0, body.start, 4000));
    let ends = curve.0.iter().skip(1).chain(&curve.0[..1]);
    let length: f64 = curve.0.iter().zip(ends).map(|(a, b)| a.distance(*b)).sum();
    let mut spacing = 0.4;
    let inside = loop {
        let inside = fill(body, &curve.0, spacing);
        if inside.len() + (length / spacing).round() as usize >= count {
            break inside;
        }
        spacing *= 0.995;
    };
    let border = count - inside.len();
    let points = curve.points(border).into_iter().chain(inside).map(rounded).collect();
    (points, border)
}

/// Points of a triangular lattice well inside the border. Those close to the border of a region are moved onto it.
fn fill(body: &Body, curve: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let (low, high) = curve.iter().fold((curve[0], curve[0]), |(low, high), at| (low.min(*at), high.max(*at)));
    let rows = ((high.y - low.y) / (0.866 * spacing)) as usize + 2;
    let columns = ((high.x - low.x) / spacing) as usize + 2;
    let middle = 0.5 * (low.x + high.x);
    let mut points = Vec::new();
    for row in 0..rows {
        for column in 0..=columns {
            let shift =
                column as f64 - 0.5 * columns as f64 + if (row + columns).is_multiple_of(2) { 0.0 } else { 0.5 };
            let at = DVec2::new(middle + shift * spacing, low.y + 0.866 * spacing * row as f64);
            if (body.field)(at) < -0.55 * spacing {
                points.push(drawn_to_region(body, at, spacing));
            }
        }
    }
    points
}

/// Moves a point less than 0.4 spacings from the border of a region onto it.
fn drawn_to_region(body: &Body, at: DVec2, spacing: f64) -> DVec2 {
    for region in &body.regions {
        let slope = gradient(&region.field, at);
        let step = slope * ((region.field)(at) / slope.length_squared().max(1e-6));
        let moved = at - step;
        if step.length() < 0.4 * spacing && (body.field)(moved) < -0.45 * spacing {
            return moved;
        }
    }
    at
}

/// Counter-clockwise triangles inside the polygon of the first `border` points, sorted so that their order is
/// deterministic.
fn triangulate(points: &[DVec2], border: usize) -> Vec<[u32; 3]> {
    let corners = points.iter().map(|at| Point2::new(at.x, at.y)).collect();
    let edges = (0..border).map(|k| [k, (k + 1) % border]).collect();
    let net = ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(corners, edges)
        .expect("borders do not cross themselves");
    let mut triangles: Vec<[u32; 3]> = net
        .inner_faces()
        .map(|face| face.vertices().map(|corner| corner.index() as u32))
        .filter(|corners| is_inside(&points[..border], middle(points, corners)))
        .map(|mut corners| {
            let least = corners.iter().zip(0..).min().map_or(0, |(_, place)| place);
            corners.rotate_left(least);
            corners
        })
        .collect();
    triangles.sort_unstable();
    triangles
}

fn middle(points: &[DVec2], corners: &[u32; 3]) -> DVec2 {
    corners.iter().map(|corner| points[*corner as usize]).sum::<DVec2>() / 3.0
}

/// Point-in-polygon test by the even-odd rule.
fn is_inside(polygon: &[DVec2], at: DVec2) -> bool {
    let crosses = |k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    (0..polygon.len()).filter(|k| crosses(*k)).count() % 2 == 1
}

/// The body's triangles by region.
fn colored(body: &Body, points: &[DVec2], triangles: &[[u32; 3]]) -> Vec<MeshPart> {
    let region_of =
        |corners: &[u32; 3]| body.regions.iter().position(|region| (region.field)(middle(points, corners)) < 0.0);
    let part = |name, color, wanted: Option<usize>| {
        let triangles = triangles.iter().filter(|corners| region_of(corners) == wanted).copied().collect();
        MeshPart { name, color, triangles }
    };
    let regions = body.regions.iter().enumerate().map(|(k, region)| part(region.name, region.color, Some(k)));
    let mut parts = vec![part("body", body.color, None)];
    parts.extend(regions);
    parts
}
