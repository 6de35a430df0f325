//! Computes the shape of a layer on the screen: the visible portions of its triangles and lines.
//!
//! In: a [`TimeSample`] and a layer. Out: a [`ScreenShape`]: triangles clipped at the near plane, with their stiffness
//! and links, and the runs of lines beyond the near plane.

use super::part_triangle_ranges::{PartTriangleRanges, links_of_shape};
use crate::pipeline::{PreparedShot, TimeSample};
use crate::screen::{Corner, Projected, clip_near, primitive};
use crate::solve::Shape;
use rayon::prelude::*;

/// Least number of vertices or triangles per thread.
const MIN_LEN: usize = 4096;

/// A layer's shape, and the origin of its triangles.
pub(in crate::pipeline) struct ScreenShape {
    pub(in crate::pipeline) shape: Shape<2>,
    pub(in crate::pipeline) starts: Vec<PartTriangleRanges>,
}

/// Returns the layer's triangles and lines on the screen, clipped at the near plane.
pub(in crate::pipeline) fn screen_shape(prepared: &PreparedShot, sample: &TimeSample, index: usize) -> Shape<2> {
    screen_shape_with_starts(prepared, sample, index).shape
}

/// Returns the same as [`screen_shape`], together with the position of each part in the shape.
pub(in crate::pipeline) fn screen_shape_with_starts(
    prepared: &PreparedShot,
    sample: &TimeSample,
    index: usize,
) -> ScreenShape {
    let (mesh, near) = (sample.mesh(), sample.camera.near());
    let mut shape = Shape::default();
    let mut all = Vec::new();
    for &part in &prepared.assignment.parts_of_layer[index] {
        let stiffness = prepared.stiffness_of(index, part);
        let vertices = &mesh.parts[part].vertices;
        let base = shape.points.len() as u32;
        // Vertices behind the camera keep their index; no remaining triangle uses them.
        let place = |vertex: &Projected| if vertex.w > 0.0 { vertex.point().0.to_array() } else { [0.0; 2] };
        shape.points.par_extend(vertices.par_iter().with_min_len(MIN_LEN).map(place));
        let source = primitive(&prepared.scene, &sample.pose.parts[part]);
        source.lines.iter().for_each(|line| add_visible_runs(&mut shape, line, (vertices, base), near));
        let is_seen =
            |ends: &[Projected; 3]| ends.iter().all(|end| end.depth >= near && end.w > 0.0 && end.h.is_finite());
        let ends_of = |corners: &[u32; 3]| corners.map(|corner| vertices[corner as usize]);
        let is_whole = |corners: &[u32; 3]| stiffness.meets(corners) && is_seen(&ends_of(corners));
        if stiffness.is_even() && source.triangles.par_iter().with_min_len(MIN_LEN).all(is_whole) {
            let first = shape.triangles.len() as u32;
            let moved = |corners: &[u32; 3]| corners.map(|corner| corner + base);
            shape.triangles.par_extend(source.triangles.par_iter().with_min_len(MIN_LEN).map(moved));
            all.push(PartTriangleRanges { part, starts: (first..=shape.triangles.len() as u32).collect() });
            continue;
        }
        let mut starts = Vec::with_capacity(source.triangles.len() + 1);
        for (number, corners) in source.triangles.iter().enumerate() {
            starts.push(shape.triangles.len() as u32);
            if !stiffness.meets(corners) {
                continue;
            }
            let ends = ends_of(corners);
            if is_seen(&ends) {
                shape.triangles.push(corners.map(|corner| corner + base));
            } else {
                add_cut(&mut shape, ends, near);
            }
            stiffness.extend((number, corners), &mut shape);
        }
        starts.push(shape.triangles.len() as u32);
        all.push(PartTriangleRanges { part, starts });
    }
    let links = prepared.links_of(index);
    shape.links = links.map(|links| links_of_shape(links, &all));
    ScreenShape { shape, starts: all }
}

/// Adds the parts of a triangle beyond the near plane.
fn add_cut(shape: &mut Shape<2>, ends: [Projected; 3], near: f64) {
    let (cut, count) = clip_near(ends, near);
    for cut in &cut[..count] {
        let first = shape.points.len() as u32;
        let point = |corner: &Corner| ends[corner.from].lerp(ends[corner.to], corner.t).point();
        shape.points.extend(cut.iter().map(|corner| point(corner).0.to_array()));
        shape.triangles.push([first, first + 1, first + 2]);
    }
}

/// Adds the visible runs of a line to a shape, whose points hold the part's vertices from `base` on. A segment that
/// crosses the near plane is left out, because its clipped end would slide along it.
fn add_visible_runs(shape: &mut Shape<2>, line: &[u32], (vertices, base): (&[Projected], u32), near: f64) {
    let is_seen = |&vertex: &u32| {
        let place = vertices[vertex as usize];
        place.depth >= near && place.w > 0.0 && place.h.is_finite()
    };
    let runs = line.split(|vertex| !is_seen(vertex)).filter(|run| run.len() > 1);
    shape.strokes.extend(runs.map(|run| run.iter().map(|vertex| vertex + base).collect::<Vec<u32>>()));
}
