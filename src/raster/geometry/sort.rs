//! Joins parts into one geometry: opaque draws first, then blended triangles from back to front.
//!
//! In: built parts. Out: vertices, indices and draws of a [`Geometry`].

use super::assembly::BuiltPart;
use crate::raster::{Draw, Geometry};
use std::ops::Range;

/// A blended triangle to be sorted from back to front.
struct Blended {
    depth: f32,
    corners: [u32; 3],
    /// Index in the list of all draws.
    draw: usize,
}

/// Joins all parts in a geometry without vertices and draws. The arrays of the first part are moved into the geometry,
/// so that a scene of one large mesh is not held twice.
pub(super) fn join(parts: Vec<BuiltPart>, geometry: &mut Geometry) {
    let mut blended = Vec::new();
    let mut draws = Vec::new();
    let vertices: usize = parts.iter().map(|built| built.vertices.len()).sum();
    let corners: usize = parts.iter().map(|built| 3 * built.triangles.len()).sum();
    for built in parts {
        let BuiltPart { vertices: part_vertices, triangles, draws: pieces, is_blended } = built;
        let base = geometry.vertices.len() as u32;
        if is_blended {
            let first = draws.len();
            blended.extend(triangles.into_iter().enumerate().map(|(number, corners)| Blended {
                depth: corners.iter().map(|&corner| part_vertices[corner as usize].depth).sum(),
                corners: corners.map(|corner| corner + base),
                draw: first + pieces.iter().take_while(|(_, end)| *end <= number).count(),
            }));
        } else {
            let start = geometry.indices.len() as u32;
            let part_corners = triangles.into_flattened();
            if base == 0 && start == 0 {
                geometry.indices = part_corners;
                geometry.indices.reserve_exact(corners - geometry.indices.len());
            } else {
                geometry.indices.extend(part_corners.into_iter().map(|corner| corner + base));
            }
            let mut from = start;
            for (draw, end) in &pieces {
                let to = start + 3 * *end as u32;
                push(geometry, draw, from..to);
                from = to;
            }
        }
        if base == 0 {
            geometry.vertices = part_vertices;
            geometry.vertices.reserve_exact(vertices - geometry.vertices.len());
        } else {
            geometry.vertices.extend(part_vertices);
        }
        draws.extend(pieces.into_iter().map(|(draw, _)| draw));
    }
    // A stable sort: equally distant triangles keep the file's order.
    blended.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    for run in blended.chunk_by(|a, b| a.draw == b.draw) {
        let start = geometry.indices.len() as u32;
        geometry.indices.extend(run.iter().flat_map(|triangle| triangle.corners));
        let end = geometry.indices.len() as u32;
        push(geometry, &draws[run[0].draw], start..end);
    }
}

/// Appends a draw of these indices, unless there are none.
fn push(geometry: &mut Geometry, draw: &Draw, indices: Range<u32>) {
    if !indices.is_empty() {
        geometry.draws.push(Draw { indices, ..draw.clone() });
    }
}
