//! The screen-space warp of a part: none, one lattice, one with branches, or several blended by vertex weights.
//!
//! In: lattices, weights. Out: warped points.

use crate::lattice::ScreenLattice;
use crate::solve::BranchedLattice;
use crate::space::ScreenPoint;
use glam::DVec2;
use std::ops::Range;

/// The warp of a part.
#[derive(Clone, Debug, Default)]
pub(crate) enum PartWarp<'a> {
    /// No displacement.
    #[default]
    Rest,
    /// One lattice.
    Lattice(&'a ScreenLattice),
    /// One lattice with branches.
    Branches(BranchWarp<'a>),
    /// Several lattices, blended by weights of the vertices.
    Blend(WarpBlend<'a>),
}

/// A lattice with branches, and the correspondence between the part's triangles and its shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BranchWarp<'a> {
    /// The lattice.
    pub branches: &'a BranchedLattice<2>,
    /// Index of the first triangle in the shape of each triangle of the part, #triangles + 1: near-plane clipping
    /// leaves zero, one or two.
    pub starts: &'a [u32],
}

/// A blend of warps: a vertex is displaced by the weighted sum of their displacements; weights that sum to less than 1
/// reduce the displacement.
#[derive(Clone, Debug)]
pub(crate) struct WarpBlend<'a> {
    /// The blended warps, none of which is a blend.
    pub layers: Vec<PartWarp<'a>>,
    /// #vertices x #layers, row-major.
    pub weights: &'a [f32],
}

/// The position of a point on its part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPoint<'a> {
    /// One weight per layer of a blend; else empty.
    pub(crate) weights: &'a [f32],
    /// Index of a triangle of the part that contains the point; arbitrary if no lattice has branches.
    pub(crate) triangle: u32,
}

impl PartWarp<'_> {
    /// Returns whether there is no displacement.
    #[must_use]
    pub(crate) fn is_rest(&self) -> bool {
        match self {
            Self::Rest => true,
            Self::Lattice(_) | Self::Branches(_) => false,
            Self::Blend(blend) => blend.layers.iter().all(Self::is_rest),
        }
    }

    /// Returns whether any lattice has branches.
    #[must_use]
    pub(crate) fn has_branches(&self) -> bool {
        match self {
            Self::Rest | Self::Lattice(_) => false,
            Self::Branches(_) => true,
            Self::Blend(blend) => blend.layers.iter().any(Self::has_branches),
        }
    }

    /// Returns the weights of a vertex, one per layer; empty if a single lattice warps the part.
    #[must_use]
    pub(crate) fn weights_of(&self, vertex: usize) -> &[f32] {
        match self {
            Self::Rest | Self::Lattice(_) | Self::Branches(_) => &[],
            Self::Blend(blend) => &blend.weights[vertex * blend.layers.len()..][..blend.layers.len()],
        }
    }

    /// Warps a point. A weight of 1 gives exactly the bits of that lattice alone, so that a blended part and an
    /// adjacent part that is not blended agree on their border.
    #[must_use]
    pub(crate) fn warp(&self, point: ScreenPoint, on: PartPoint) -> ScreenPoint {
        match self {
            Self::Rest => point,
            Self::Lattice(lattice) => lattice.warp(point),
            Self::Branches(warp) => warp.warp(point, on.triangle as usize),
            Self::Blend(blend) => {
                let mut moved = DVec2::ZERO;
                for (layer, &weight) in blend.layers.iter().zip(on.weights) {
                    if weight <= 0.0 || layer.is_rest() {
                        continue;
                    }
                    if weight == 1.0 {
                        return layer.warp(point, on);
                    }
                    moved += (layer.warp(point, on) - point).0 * f64::from(weight);
                }
                ScreenPoint(point.0 + moved)
            }
        }
    }

    /// Returns the warps of a blend, or the warp itself; none at rest.
    pub(super) fn layers(&self) -> &[Self] {
        match self {
            Self::Rest => &[],
            Self::Lattice(_) | Self::Branches(_) => std::slice::from_ref(self),
            Self::Blend(blend) => &blend.layers,
        }
    }
}

impl BranchWarp<'_> {
    /// Warps a point of a triangle of the part. Triangles that are completely clipped are not displaced.
    fn warp(&self, point: ScreenPoint, triangle: usize) -> ScreenPoint {
        let moved = self.triangles(triangle).map(|own| self.branches.warp(own, point.0.to_array()));
        moved.map_or(point, |[x, y]| ScreenPoint::new(x, y))
    }

    /// Returns the branch at a point of a triangle of the part; `None` if the triangle is completely clipped.
    pub(super) fn branch(&self, point: ScreenPoint, triangle: usize) -> Option<usize> {
        Some(self.branches.branch_within(self.triangles(triangle)?, point.0.to_array()))
    }

    /// Returns the triangles of the shape that a triangle of the part consists of; `None` if it is completely clipped.
    fn triangles(&self, triangle: usize) -> Option<Range<usize>> {
        let [start, end] = [triangle, triangle + 1].map(|k| self.starts.get(k).map_or(0, |&start| start as usize));
        (start < end).then_some(start..end)
    }
}
