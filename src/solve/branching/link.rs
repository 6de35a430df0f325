//! Links: connections between triangles of a shape.
//!
//! In: a shape at rest. Out: [`Link`]s between its triangles. Their ends are barycentric, so that they are valid in every pose.

/// How two triangles are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LinkKind {
    /// They share an edge, whose ends are those of the link.
    Edge,
    /// One end lies in each triangle. The link crosses a gap between parts, or the inside of a solid.
    Across,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinkEnd {
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates.
    pub barycentric: [f32; 3],
}

/// A connection between two triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    /// A point in each triangle.
    pub(crate) ends: [LinkEnd; 2],
    /// The kind of connection.
    pub(crate) kind: LinkKind,
}

impl LinkEnd {
    /// A corner of a triangle, 0, 1 or 2.
    #[must_use]
    pub(crate) fn corner(triangle: usize, corner: usize) -> Self {
        let mut barycentric = [0.0; 3];
        barycentric[corner] = 1.0;
        Self { triangle: triangle as u32, barycentric }
    }

    /// Position of the point.
    pub(super) fn point<const D: usize>(&self, points: &[[f64; D]], triangles: &[[u32; 3]]) -> [f64; D] {
        let corners = triangles[self.triangle as usize].map(|corner| points[corner as usize]);
        let shares = self.barycentric.map(f64::from);
        std::array::from_fn(|d| (0..3).map(|k| shares[k] * corners[k][d]).sum())
    }
}
