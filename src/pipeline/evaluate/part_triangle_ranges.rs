//! Maps the triangles of a layer's parts to the triangles of its shape. Plain data.

use crate::pipeline::PinAnchor;
use std::ops::Range;

/// The index ranges of a part's triangles in the shape of its layer.
#[derive(Clone, Debug)]
pub(in crate::pipeline) struct PartTriangleRanges {
    /// Index into the pose's parts.
    pub(in crate::pipeline) part: usize,
    /// #triangles + 1: index of the first triangle of the shape that comes from each triangle of the part. After
    /// clipping at the near plane, a triangle yields none, one or two.
    pub(in crate::pipeline) starts: Vec<u32>,
}

/// Returns the triangle of the shape to which a pin is attached.
pub(in crate::pipeline) fn held_triangle(anchor: &PinAnchor, parts: &[PartTriangleRanges]) -> Option<u32> {
    Some(held_triangles(anchor, parts)?.start as u32)
}

/// Returns the triangles of the shape that come from the triangle to which a pin is attached.
pub(in crate::pipeline) fn held_triangles(anchor: &PinAnchor, parts: &[PartTriangleRanges]) -> Option<Range<usize>> {
    let PinAnchor::Surface { part, triangle, .. } = *anchor else { return None };
    triangles_of(parts, part, triangle)
}

/// Returns the triangles of the shape that come from a triangle of a part; `None` if there are none.
pub(in crate::pipeline) fn triangles_of(
    parts: &[PartTriangleRanges],
    part: usize,
    triangle: usize,
) -> Option<Range<usize>> {
    let starts = &parts.iter().find(|own| own.part == part)?.starts;
    let [start, end] = [*starts.get(triangle)? as usize, *starts.get(triangle + 1)? as usize];
    (start < end).then_some(start..end)
}
