//! Screen-space bounds of a layer.
//!
//! In: projected parts. Out: boxes in frame heights.

use super::camera::Projected;
use super::clip::{Corner, clip_near};
use super::mesh::{ScreenMesh, primitive};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::space::{FrameSize, ScreenBox, ScreenPoint};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Bounds are clipped to the frame scaled by this factor about its centre, so that a limb close to the camera cannot
/// stretch the lattice arbitrarily.
const REACH: f64 = 1.5;

/// Returns the maximum extent of lattices: the frame scaled by 1.5.
#[must_use]
pub(crate) fn reach_of_frame(frame: FrameSize) -> ScreenBox {
    let size = DVec2::new(frame.aspect(), 1.0);
    let margin = size * ((REACH - 1.0) * 0.5);
    ScreenBox::new(ScreenPoint(-margin), ScreenPoint(size + margin))
}

/// Number of triangles, and of vertices, that a thread goes through at a time.
const CHUNK: usize = 16_384;

/// The part of a scene that [`bounds`] considers.
#[derive(Clone, Copy)]
pub(crate) struct Extent<'a> {
    /// Indices into the pose's parts.
    pub(crate) parts: &'a [usize],
    /// Returns whether a triangle counts, given its part and corners.
    pub(crate) counts: &'a (dyn Fn(usize, &[u32; 3]) -> bool + Sync),
    /// Distance of the near plane in metres; nearer geometry is ignored.
    pub(crate) near: f64,
    /// The box that bounds are clipped to.
    pub(crate) reach: ScreenBox,
    /// Origin of the axes of the bounds.
    pub(crate) origin: DVec2,
    /// Angle of these axes, in radians, counter-clockwise.
    pub(crate) angle: f64,
}

/// Returns the bounds of the selected parts, clipped at the near plane and to the reach, along the given axes.
///
/// `None` if nothing is within reach.
#[must_use]
pub(crate) fn bounds(scene: &Scene, pose: &Pose, mesh: &ScreenMesh, extent: Extent) -> Option<ScreenBox> {
    let Extent { parts, counts, near, reach, origin, angle } = extent;
    let turn = (angle != 0.0).then(|| DVec2::from_angle(-angle));
    let along_axes = |ScreenPoint(point): ScreenPoint| {
        let from_origin = point - origin;
        ScreenPoint(turn.map_or(from_origin, |turn| turn.rotate(from_origin)))
    };
    let reach = reach.around_moved(along_axes);
    let of_part = |&part: &usize| {
        let source = primitive(scene, &pose.parts[part]);
        let surface = PartCorners::new(&mesh.parts[part].vertices, near);
        let triangles = source
            .triangles
            .par_chunks(CHUNK)
            .map(|chunk| surface.add(chunk.iter().copied().filter(|corners| counts(part, corners)), along_axes));
        let mut boxes: Vec<Option<ScreenBox>> = triangles.collect();
        boxes.push(surface.add(source.segments().map(|[a, b]| [a, b, b]), along_axes));
        boxes.extend(surface.whole(along_axes));
        boxes.into_iter().flatten().reduce(ScreenBox::union)
    };
    let whole = parts.iter().filter_map(of_part).reduce(ScreenBox::union)?;
    let min = whole.min.0.max(reach.min.0);
    let max = whole.max.0.min(reach.max.0);
    (min.cmple(max).all() && min.is_finite() && max.is_finite())
        .then(|| ScreenBox::new(ScreenPoint(min), ScreenPoint(max)))
}

/// The corners of a part's triangles and lines: vertices beyond the near plane, and points where triangles are cut. Only vertices of
/// triangles or lines count: others may belong to other parts.
struct PartCorners<'a> {
    vertices: &'a [Projected],
    near: f64,
    /// #vertices: whether a triangle that lies beyond the near plane has the vertex. Each such vertex is looked at once, however many
    /// triangles share it.
    is_used: Vec<AtomicBool>,
}

impl<'a> PartCorners<'a> {
    fn new(vertices: &'a [Projected], near: f64) -> Self {
        Self { vertices, near, is_used: vertices.iter().map(|_| AtomicBool::new(false)).collect() }
    }

    /// Adds triangles. Returns the bounds of those that cross the near plane.
    fn add(
        &self,
        triangles: impl Iterator<Item = [u32; 3]>,
        along_axes: impl Fn(ScreenPoint) -> ScreenPoint + Copy,
    ) -> Option<ScreenBox> {
        let near = self.near;
        let is_seen = |end: Projected| end.depth >= near && end.w > 0.0 && end.h.is_finite() && end.depth.is_finite();
        let cut = triangles.filter_map(|corners| {
            let ends = corners.map(|corner| self.vertices[corner as usize]);
            if !ends.iter().copied().all(is_seen) {
                return Some(ends);
            }
            corners.iter().for_each(|&corner| self.is_used[corner as usize].store(true, Ordering::Relaxed));
            None
        });
        ScreenBox::around(cut.flat_map(|ends| {
            let (cut, count) = clip_near(ends, near);
            let place = move |corner: Corner| along_axes(ends[corner.from].lerp(ends[corner.to], corner.t).point());
            cut.into_iter().take(count).flatten().map(place)
        }))
    }

    /// Returns the bounds of the added triangles that lie beyond the near plane, chunk by chunk.
    fn whole(&self, along_axes: impl Fn(ScreenPoint) -> ScreenPoint + Copy + Sync) -> Vec<Option<ScreenBox>> {
        let vertices = self.vertices.par_chunks(CHUNK).zip(self.is_used.par_chunks(CHUNK));
        let of_chunk = |(vertices, is_used): (&[Projected], &[AtomicBool])| {
            let used = vertices.iter().zip(is_used).filter(|(_, is_used)| is_used.load(Ordering::Relaxed));
            ScreenBox::around(used.map(|(vertex, _)| along_axes(vertex.point())))
        };
        vertices.map(of_chunk).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles in a fan, some of which cross the near plane or have a corner that is no number.
    fn fan(count: u32) -> (Vec<Projected>, Vec<[u32; 3]>) {
        let vertex = |index: u32| {
            let turn = DVec2::from_angle(0.37 * f64::from(index));
            let depth = if index % 97 == 5 { -0.4 } else { 1.0 + 0.3 * turn.y };
            let x = if index % 101 == 7 { f64::NAN } else { turn.x * (1.0 + 1e-3 * f64::from(index)) };
            Projected { h: DVec2::new(x, turn.y), w: depth, depth }
        };
        ((0..count).map(vertex).collect(), (0..count - 2).map(|index| [0, index + 1, index + 2]).collect())
    }

    #[test]
    fn bounds_are_those_of_all_corners_of_clipped_triangles() {
        let (vertices, triangles) = fan(40_000);
        let turned = |ScreenPoint(point): ScreenPoint| ScreenPoint(DVec2::from_angle(0.3).rotate(point));
        let corners = triangles.iter().flat_map(|corners| {
            let ends = corners.map(|corner| vertices[corner as usize]);
            let (cut, count) = clip_near(ends, 0.1);
            let place = move |corner: Corner| turned(ends[corner.from].lerp(ends[corner.to], corner.t).point());
            cut.into_iter().take(count).flatten().map(place)
        });
        let corner_bounds = ScreenBox::around(corners);
        let surface = PartCorners::new(&vertices, 0.1);
        let mut boxes = vec![surface.add(triangles.iter().copied(), turned)];
        boxes.extend(surface.whole(turned));
        assert!(corner_bounds.is_some());
        assert_eq!(boxes.into_iter().flatten().reduce(ScreenBox::union), corner_bounds);
    }
}
