//! Maps the triangles of a layer's parts to the triangles of its shape.
//!
//! In: pins and links on the parts. Out: the same on the shape.

use crate::pipeline::PinAnchor;
use crate::solve::{Link, LinkEnd, LinkKind};
use std::ops::Range;
use std::sync::Arc;

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

/// Converts links between triangles of the parts to links between triangles of the shape. The two halves of a triangle that
/// the near plane clips into two are linked to each other, and the triangle's links are attached to the centre of the
/// first half.
pub(in crate::pipeline) fn links_of_shape(links: &Arc<Vec<Link>>, parts: &[PartTriangleRanges]) -> Arc<Vec<Link>> {
    let runs: Vec<[u32; 2]> =
        parts.iter().flat_map(|part| part.starts.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    if runs.iter().enumerate().all(|(number, &[start, end])| start as usize == number && end == start + 1) {
        return Arc::clone(links);
    }
    let now = |end: &LinkEnd| {
        let [start, next] = runs[end.triangle as usize];
        match next - start {
            0 => None,
            1 => Some(LinkEnd { triangle: start, ..*end }),
            _ => Some(LinkEnd { triangle: start, barycentric: [1.0 / 3.0; 3] }),
        }
    };
    let kept = links.iter().filter_map(|link| {
        let [from, to] = link.ends.each_ref().map(now);
        Some(Link { ends: [from?, to?], kind: link.kind })
    });
    let halves = runs.iter().filter(|[start, end]| end - start > 1).map(|&[start, _]| {
        let ends = [LinkEnd::corner(start as usize, 0), LinkEnd::corner(start as usize + 1, 1)];
        Link { ends, kind: LinkKind::Edge }
    });
    Arc::new(kept.chain(halves).collect())
}
