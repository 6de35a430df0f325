//! Which triangles of a layer's shape those of its parts are.
//!
//! Plain data.

/// Where the triangles of a part lie in the shape of its layer.
#[derive(Clone, Debug)]
pub(super) struct PartStarts {
    /// Index into the pose's parts.
    pub(super) part: usize,
    /// Where those of each triangle of the part begin, #triangles + 1: there are none, one, or two that the near plane left.
    pub(super) starts: Vec<u32>,
}
