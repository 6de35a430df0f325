//! The shape of a layer on the screen: what is seen of its triangles and lines.
//!
//! In: a [`TimeSample`] and a layer. Out: a [`Shape`]: triangles cut at the near plane, with their stiffness, and the runs of
//! lines that the camera sees.

use super::stiffness::extend_stiffness;
use super::{PreparedShot, TimeSample};
use crate::screen::{Corner, Projected, clip_near, primitive};
use crate::solve::Shape;

/// The layer's triangles and lines on the screen, cut at the near plane.
pub(super) fn screen_shape(prepared: &PreparedShot, sample: &TimeSample, index: usize) -> Shape<2> {
    let (mesh, near) = (sample.mesh(), sample.camera.near());
    let mut shape = Shape::default();
    for &part in &prepared.assignment.parts_of_layer[index] {
        let stiffness = prepared.stiffness_of(index, part);
        let vertices = &mesh.parts[part].vertices;
        let base = shape.points.len() as u32;
        // Hidden vertices keep their index; no triangle that is left uses them.
        let place = |vertex: &Projected| if vertex.w > 0.0 { vertex.point().0.to_array() } else { [0.0; 2] };
        shape.points.extend(vertices.iter().map(place));
        let source = primitive(&prepared.scene, &sample.pose.parts[part]);
        source.lines.iter().for_each(|line| add_visible_runs(&mut shape, line, (vertices, base), near));
        for (number, corners) in source.triangles.iter().enumerate() {
            let ends = corners.map(|corner| vertices[corner as usize]);
            if ends.iter().all(|end| end.depth >= near && end.w > 0.0 && end.h.is_finite()) {
                shape.triangles.push(corners.map(|corner| corner + base));
                extend_stiffness(stiffness, number, &mut shape);
                continue;
            }
            let (cut, count) = clip_near(ends, near);
            for cut in &cut[..count] {
                let first = shape.points.len() as u32;
                let point = |corner: &Corner| ends[corner.from].lerp(ends[corner.to], corner.share).point();
                shape.points.extend(cut.iter().map(|corner| point(corner).0.to_array()));
                shape.triangles.push([first, first + 1, first + 2]);
            }
            extend_stiffness(stiffness, number, &mut shape);
        }
    }
    shape
}

/// Adds the visible runs of a line to a shape, whose points hold the part's vertices from `base` on. A segment that
/// passes the near plane is left out: its cut end would slide along it.
fn add_visible_runs(shape: &mut Shape<2>, line: &[u32], (vertices, base): (&[Projected], u32), near: f64) {
    let is_seen = |&vertex: &u32| {
        let place = vertices[vertex as usize];
        place.depth >= near && place.w > 0.0 && place.h.is_finite()
    };
    let runs = line.split(|vertex| !is_seen(vertex)).filter(|run| run.len() > 1);
    shape.strokes.extend(runs.map(|run| run.iter().map(|vertex| vertex + base).collect::<Vec<u32>>()));
}
