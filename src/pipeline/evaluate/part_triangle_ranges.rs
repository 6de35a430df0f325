//! Maps the triangles of a layer's parts to the triangles of its shape. Plain data.

use crate::pipeline::PinAnchor;

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
    let PinAnchor::Surface { part, triangle, .. } = *anchor else { return None };
    let starts = &parts.iter().find(|own| own.part == part)?.starts;
    let [start, end] = [*starts.get(triangle)?, *starts.get(triangle + 1)?];
    (start < end).then_some(start)
}
