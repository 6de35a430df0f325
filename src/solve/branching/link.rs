//! Where triangles of a shape hang together.
//!
//! In: a shape at rest. Out: [`Link`]s between its triangles, as points of triangles, so that they hold in every pose.

/// How two triangles hang together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkKind {
    /// They share an edge; the link's ends are those of the edge.
    Edge,
    /// One end lies in the first triangle and one in the second, with solid matter between them at rest.
    Across,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkEnd {
    /// The triangle, by index.
    pub triangle: u32,
    /// Barycentric coordinates.
    pub barycentric: [f32; 3],
}

/// Two triangles that hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// A point in each.
    pub ends: [LinkEnd; 2],
    /// How.
    pub kind: LinkKind,
}

impl LinkEnd {
    /// A corner of a triangle, 0, 1 or 2.
    #[must_use]
    pub fn corner(triangle: usize, corner: usize) -> Self {
        let mut barycentric = [0.0; 3];
        barycentric[corner] = 1.0;
        Self { triangle: triangle as u32, barycentric }
    }

    /// Where it lies.
    pub(super) fn point<const D: usize>(&self, points: &[[f64; D]], triangles: &[[u32; 3]]) -> [f64; D] {
        let corners = triangles[self.triangle as usize].map(|corner| points[corner as usize]);
        let shares = self.barycentric.map(f64::from);
        std::array::from_fn(|d| (0..3).map(|k| shares[k] * corners[k][d]).sum())
    }
}
