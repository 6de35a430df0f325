//! Which edges the warps of an assembly would bend.
//!
//! In: the warps of all parts. Out: the curvature of each lattice, and for each part the edges that need more than a straight line.

use super::curvature::{Curvature, MIN_LENGTH, TOLERANCE};
use super::part_warp::{PartPoint, PartWarp};
use crate::solve::Bending;
use crate::space::ScreenPoint;
use foldhash::fast::FixedState;
use glam::DVec2;
use rayon::prelude::*;
use std::collections::HashMap;

/// The curvature of the lattices of an assembly, each computed once, however many parts it warps.
pub(super) struct LatticeCurvatures {
    /// By the address of the lattice.
    of_lattices: HashMap<usize, LatticeCurvature, FixedState>,
}

/// The curvature of a lattice.
enum LatticeCurvature {
    Plain(Curvature),
    /// That of each branch.
    Branches(Vec<Curvature>),
}

impl LatticeCurvatures {
    pub(super) fn of<'a>(warps: impl Iterator<Item = &'a PartWarp<'a>>) -> Self {
        let layers = warps.flat_map(PartWarp::layers).filter_map(|layer| Some((address(layer)?, layer)));
        let distinct: HashMap<usize, &PartWarp, FixedState> = layers.collect();
        let curvature = |(lattice, layer): (usize, &PartWarp)| Some((lattice, LatticeCurvature::of(layer)?));
        Self { of_lattices: distinct.into_par_iter().filter_map(curvature).collect() }
    }

    /// Returns the edges that a warp, one of those given, bends.
    pub(super) fn edge_bends<'a>(&'a self, warp: &'a PartWarp<'a>) -> EdgeBends<'a> {
        let layer =
            |layer| LayerBends { layer, curvature: address(layer).and_then(|lattice| self.of_lattices.get(&lattice)) };
        EdgeBends { layers: warp.layers().iter().map(layer).collect() }
    }
}

/// The address of a layer's lattice; `None` at rest, and for blends, whose layers have lattices of their own.
fn address(layer: &PartWarp) -> Option<usize> {
    match layer {
        PartWarp::Rest | PartWarp::Blend(_) => None,
        PartWarp::Lattice(lattice) => Some(std::ptr::from_ref(*lattice).addr()),
        PartWarp::Branches(warp) => Some(std::ptr::from_ref(warp.branches).addr()),
    }
}

impl LatticeCurvature {
    /// Returns the curvature of a layer; `None` at rest and for blends.
    fn of(layer: &PartWarp) -> Option<Self> {
        match layer {
            PartWarp::Rest | PartWarp::Blend(_) => None,
            PartWarp::Lattice(lattice) => Some(Self::Plain(Curvature::of(lattice))),
            PartWarp::Branches(warp) => {
                let of_branch = |bending: &Bending| Curvature::of_branch(warp.branches.grid(), bending);
                Some(Self::Branches(warp.branches.bending().iter().map(of_branch).collect()))
            }
        }
    }
}

/// The edges of a part that need more than a straight line.
pub(super) struct EdgeBends<'a> {
    layers: Vec<LayerBends<'a>>,
}

/// The edges that one layer bends.
struct LayerBends<'a> {
    layer: &'a PartWarp<'a>,
    /// `None` at rest.
    curvature: Option<&'a LatticeCurvature>,
}

impl EdgeBends<'_> {
    /// Returns whether the warp of the edge between two points needs more than a straight line. Symmetric in its ends;
    /// lattices with zero weight at both are ignored, so that parts that share the edge agree.
    pub(super) fn bends(&self, [a, b]: [DVec2; 2], on: [PartPoint; 2]) -> bool {
        let [from, to] = on.map(|point| point.weights);
        if from.is_empty() {
            return self.layers.iter().any(|layer| layer.bends([a, b], on));
        }
        let acting = self.layers.iter().zip(from.iter().zip(to));
        let mut strays = DVec2::ZERO;
        for (own, (&from, &to)) in acting {
            if from <= 0.0 && to <= 0.0 || own.layer.is_rest() {
                continue;
            }
            if own.bends([a, b], on) {
                return true;
            }
            if from != to {
                let by = |point: DVec2, on: PartPoint| own.layer.warp(ScreenPoint(point), on).0 - point;
                strays += (by(b, on[1]) - by(a, on[0])) * f64::from(to - from);
            }
        }
        // The product of two linear functions deviates from its chord by a quarter of the product of their changes.
        a.distance(b) >= MIN_LENGTH && strays.length() / 4.0 > TOLERANCE
    }
}

impl LayerBends<'_> {
    /// Returns whether the layer bends the edge between two points, by the curvature of the branches at its ends.
    fn bends(&self, ends: [DVec2; 2], on: [PartPoint; 2]) -> bool {
        match (self.layer, self.curvature) {
            (PartWarp::Branches(warp), Some(LatticeCurvature::Branches(branches))) => {
                let [from, to] = [0, 1].map(|end| warp.branch(ScreenPoint(ends[end]), on[end].triangle as usize));
                let is_bent = |branch: Option<usize>| branch.is_some_and(|branch| branches[branch].bends(ends));
                is_bent(from) || from != to && is_bent(to)
            }
            (_, Some(LatticeCurvature::Plain(curvature))) => curvature.bends(ends),
            _ => false,
        }
    }
}
