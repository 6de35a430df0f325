//! The problem: a rest grid, a shape to preserve, pins and moved handles.
//!
//! In: plain data. Out: [`Problem`].

use super::branching::Link;
use super::settings::Settings;
use crate::lattice::Grid;
use std::sync::Arc;

/// The shape inside the lattice: #vertices points, triangles over them (any orientation; slivers allowed) and lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape<const D: usize> {
    /// Rest points, #vertices.
    pub points: Vec<[f64; D]>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// Polylines: vertices one after the other; a closed one repeats its first.
    pub strokes: Vec<Vec<u32>>,
    /// Stiffness of each triangle, 0 or more, #triangles; empty: 1 everywhere.
    pub stiffness: Vec<f64>,
    /// Which triangles hang together, for [`Topology::Branching`](super::Topology::Branching); `None`: those that share an edge as
    /// the shape lies here, and islands with what is nearest.
    pub links: Option<Arc<Vec<Link>>>,
}

impl<const D: usize> Shape<D> {
    /// Triangles of uniform stiffness.
    #[must_use]
    pub fn of_triangles(points: Vec<[f64; D]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { points, triangles, ..Self::default() }
    }
}

/// A point of the model at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelPoint<const D: usize> {
    /// Its place; outside the box it counts where it is nearest to it.
    pub at: [f64; D],
    /// The triangle of the shape that it lies on, where parts of the shape lie over each other; `None`: the nearest one.
    pub triangle: Option<u32>,
}

/// A point with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPin<const D: usize> {
    /// Rest position of the point.
    pub at: [f64; D],
    /// Its target.
    pub target: [f64; D],
    /// 0..=1, times the pin weight of the settings; a pin fades out with it.
    pub weight: f64,
    /// Wanted gradient at the pin (columns: images of the axes), for pins that hold a rotation and scale.
    pub gradient: Option<[[f64; D]; D]>,
    /// The neighbourhood that moves with the pin; `None`: the point alone.
    pub region: Option<Region>,
    /// The triangle of the shape that the point lies on, where parts of the shape lie over each other; `None`: the nearest one.
    pub triangle: Option<u32>,
}

impl<const D: usize> PointPin<D> {
    /// A pin of full weight that holds only its point.
    #[must_use]
    pub fn new(at: [f64; D], target: [f64; D]) -> Self {
        Self { at, target, weight: 1.0, gradient: None, region: None, triangle: None }
    }
}

/// The neighbourhood that moves with a pin, fading out smoothly from the pin to the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Distance of the rim from the pin at rest, in units of the space.
    pub radius: f64,
    /// How rigidly the neighbourhood moves with the pin, 0 (not at all) to 1 (rigidly).
    pub rigidity: f64,
    /// Multiplier of the stiffness of the shape at the pin; 1 at the rim.
    pub stiffness: f64,
}

/// A handle with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandlePin<const D: usize> {
    /// Handle index.
    pub index: usize,
    /// Its target.
    pub target: [f64; D],
}

/// Everything a solve needs.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a, const D: usize> {
    /// The rest grid.
    pub grid: &'a Grid<D>,
    /// The shape to preserve.
    pub shape: &'a Shape<D>,
    /// Pins.
    pub pins: &'a [PointPin<D>],
    /// Moved handles.
    pub handles: &'a [HandlePin<D>],
    /// Settings.
    pub settings: &'a Settings,
}
