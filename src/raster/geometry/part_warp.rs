//! What warps a part on the screen: nothing, one lattice, one with branches, or several by weights of the vertices.
//!
//! In: lattices, weights. Out: where a point goes, and which edges need more than a straight line.

use super::curvature::{Curvature, MIN_LENGTH, TOLERANCE};
use crate::lattice::ScreenLattice;
use crate::solve::BranchedLattice;
use crate::space::ScreenPoint;
use glam::DVec2;

/// What warps a part.
#[derive(Clone, Debug, Default)]
pub enum PartWarp<'a> {
    /// It rests.
    #[default]
    Rest,
    /// One lattice moves all of it.
    Lattice(&'a ScreenLattice),
    /// One lattice with branches moves all of it.
    Branches(BranchWarp<'a>),
    /// Several move it, each vertex by its weights.
    Blend(WarpBlend<'a>),
}

/// A lattice with branches, and where the part lies in its shape.
#[derive(Clone, Copy, Debug)]
pub struct BranchWarp<'a> {
    /// The lattice.
    pub branches: &'a BranchedLattice<2>,
    /// Where the triangles of each triangle of the part begin in the shape, #triangles + 1: the near plane leaves none, one or two.
    pub starts: &'a [u32],
}

/// Warps that move the vertices of one part together: a vertex goes by the weighted sum of their displacements, so where
/// weights sum to less than 1 it goes less far.
#[derive(Clone, Debug)]
pub struct WarpBlend<'a> {
    /// The warps, none of them a blend.
    pub layers: Vec<PartWarp<'a>>,
    /// #vertices x #layers, rows one after the other.
    pub weights: &'a [f32],
}

/// Where a point lies on its part.
#[derive(Clone, Copy, Debug)]
pub struct PartPoint<'a> {
    /// One a layer of a blend; else none.
    pub weights: &'a [f32],
    /// A triangle of the part that holds the point, by its number; any where no lattice has branches.
    pub triangle: u32,
}

impl PartWarp<'_> {
    /// Nothing moves.
    #[must_use]
    pub fn is_rest(&self) -> bool {
        match self {
            Self::Rest => true,
            Self::Lattice(_) | Self::Branches(_) => false,
            Self::Blend(blend) => blend.layers.iter().all(Self::is_rest),
        }
    }

    /// Some lattice has branches.
    #[must_use]
    pub fn has_branches(&self) -> bool {
        match self {
            Self::Rest | Self::Lattice(_) => false,
            Self::Branches(_) => true,
            Self::Blend(blend) => blend.layers.iter().any(Self::has_branches),
        }
    }

    /// The weights of a vertex, one a layer; none where one lattice moves all.
    #[must_use]
    pub fn weights_of(&self, vertex: usize) -> &[f32] {
        match self {
            Self::Rest | Self::Lattice(_) | Self::Branches(_) => &[],
            Self::Blend(blend) => &blend.weights[vertex * blend.layers.len()..][..blend.layers.len()],
        }
    }

    /// Where a point goes. A weight of 1 gives the bits of that lattice alone, so that a part that is shared and its neighbour that
    /// is not agree on their border.
    #[must_use]
    pub fn warp(&self, point: ScreenPoint, on: PartPoint) -> ScreenPoint {
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

    fn layers(&self) -> &[Self] {
        match self {
            Self::Rest => &[],
            Self::Lattice(_) | Self::Branches(_) => std::slice::from_ref(self),
            Self::Blend(blend) => &blend.layers,
        }
    }

    /// `None`: it rests.
    fn curvature(&self) -> Option<Curvature> {
        match self {
            Self::Rest | Self::Blend(_) => None,
            Self::Lattice(lattice) => Some(Curvature::of(lattice)),
            Self::Branches(warp) => Some(Curvature::of_branches(warp.branches)),
        }
    }
}

impl BranchWarp<'_> {
    /// Where a point of a triangle of the part goes. Triangles of which the camera sees nothing rest.
    fn warp(&self, point: ScreenPoint, triangle: usize) -> ScreenPoint {
        let [start, end] = [triangle, triangle + 1].map(|k| self.starts.get(k).map_or(0, |&start| start as usize));
        if start >= end {
            return point;
        }
        let [x, y] = self.branches.warp(start..end, point.0.to_array());
        ScreenPoint::new(x, y)
    }
}

/// Answers which edges of a part need more than a straight line.
pub(super) struct EdgeBends<'a> {
    layers: Vec<Option<(&'a PartWarp<'a>, Curvature)>>,
}

impl<'a> EdgeBends<'a> {
    pub(super) fn of(warp: &'a PartWarp<'a>) -> Self {
        let table = |layer: &'a PartWarp<'a>| layer.curvature().map(|table| (layer, table));
        Self { layers: warp.layers().iter().map(table).collect() }
    }

    /// Whether the warp of the edge between two points needs more than a straight line. Symmetric in its ends, and lattices that
    /// weigh nothing at both do not count: parts that meet at the edge agree.
    pub(super) fn bends(&self, [a, b]: [DVec2; 2], on: [PartPoint; 2]) -> bool {
        let [from, to] = on.map(|point| point.weights);
        if from.is_empty() {
            return self.layers.iter().flatten().any(|(_, table)| table.bends(a, b));
        }
        let acting = self.layers.iter().zip(from.iter().zip(to));
        let mut strays = DVec2::ZERO;
        for ((layer, table), (&from, &to)) in acting.filter_map(|(layer, ends)| Some((layer.as_ref()?, ends))) {
            if from <= 0.0 && to <= 0.0 {
                continue;
            }
            if table.bends(a, b) {
                return true;
            }
            if from != to {
                let by = |point: DVec2, on: PartPoint| layer.warp(ScreenPoint(point), on).0 - point;
                strays += (by(b, on[1]) - by(a, on[0])) * f64::from(to - from);
            }
        }
        // The product of two linear functions leaves its chord by a quarter of the product of their changes.
        a.distance(b) >= MIN_LENGTH && strays.length() / 4.0 > TOLERANCE
    }
}
