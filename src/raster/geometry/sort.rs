//! Joins parts into one geometry: opaque draws first, then blended triangles from back to front.
//!
//! In: built parts. Out: vertices, indices and draws of a [`Geometry`].

use super::BuiltPart;
use crate::raster::{Draw, Geometry};

/// A blended triangle on its way into the back-to-front order.
struct Blended {
    depth: f32,
    corners: [u32; 3],
    part: usize,
}

/// Appends all parts to a geometry without draws.
pub(super) fn join(parts: Vec<BuiltPart>, geometry: &mut Geometry) {
    let mut blended = Vec::new();
    let mut draws = Vec::new();
    for (part, built) in parts.into_iter().enumerate() {
        let base = geometry.vertices.len() as u32;
        if built.is_blended {
            blended.extend(built.triangles.iter().map(|corners| Blended {
                depth: corners.iter().map(|&corner| built.vertices[corner as usize].depth).sum(),
                corners: corners.map(|corner| corner + base),
                part,
            }));
        } else {
            let start = geometry.indices.len() as u32;
            geometry.indices.extend(built.triangles.iter().flatten().map(|corner| corner + base));
            push(geometry, &built.draw, start);
        }
        geometry.vertices.extend(built.vertices);
        draws.push(built.draw);
    }
    // Stable: equally far triangles keep the file's order.
    blended.sort_by(|a, b| b.depth.total_cmp(&a.depth));
    for run in blended.chunk_by(|a, b| a.part == b.part) {
        let start = geometry.indices.len() as u32;
        geometry.indices.extend(run.iter().flat_map(|triangle| triangle.corners));
        push(geometry, &draws[run[0].part], start);
    }
}

/// Adds a draw of all indices since `start`, unless there are none.
fn push(geometry: &mut Geometry, draw: &Draw, start: u32) {
    let end = geometry.indices.len() as u32;
    if start < end {
        geometry.draws.push(Draw { indices: start..end, ..draw.clone() });
    }
}
