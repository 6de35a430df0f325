//! Which triangles of a layer's shape those of its parts are.
//!
//! Plain data.

use super::PinAnchor;

/// Where the triangles of a part lie in the shape of its layer.
#[derive(Clone, Debug)]
pub(super) struct PartStarts {
    /// Index into the pose's parts.
    pub(super) part: usize,
    /// Where those of each triangle of the part begin, #triangles + 1: there are none, one, or two that the near plane left.
    pub(super) starts: Vec<u32>,
}

/// The triangle of the shape that a pin holds.
pub(super) fn held_triangle(anchor: &PinAnchor, parts: &[PartStarts]) -> Option<u32> {
    let PinAnchor::Surface { part, triangle, .. } = *anchor else { return None };
    let starts = &parts.iter().find(|own| own.part == part)?.starts;
    let [start, end] = [*starts.get(triangle)?, *starts.get(triangle + 1)?];
    (start < end).then_some(start)
}
