//! Lines of a scene as the strokes of a shape.
//!
//! In: polylines and the projected vertices of their part. Out: the runs of vertices that the camera sees.

use crate::screen::Projected;
use crate::solve::Shape;

/// Adds the visible runs of a line to a shape, whose points hold the part's vertices from `base` on. A segment that
/// passes the near plane is left out: its cut end would slide along it.
pub(super) fn add(shape: &mut Shape<2>, line: &[u32], (vertices, base): (&[Projected], u32), near: f64) {
    let is_seen = |&vertex: &u32| {
        let place = vertices[vertex as usize];
        place.depth >= near && place.w > 0.0 && place.h.is_finite()
    };
    let runs = line.split(|vertex| !is_seen(vertex)).filter(|run| run.len() > 1);
    shape.strokes.extend(runs.map(|run| run.iter().map(|vertex| vertex + base).collect::<Vec<u32>>()));
}
