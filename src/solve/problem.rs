//! The problem: a rest grid, a shape to preserve, pins and moved handles.
//!
//! In: plain data. Out: [`Problem`].

use super::branching::Link;
use super::settings::Settings;
use crate::lattice::Grid;
use std::sync::Arc;

/// The shape inside the lattice: points, triangles of any orientation (slivers are allowed) and polylines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape<const D: usize> {
    /// Rest positions, #vertices.
    pub points: Vec<[f64; D]>,
    /// Vertex indices of the corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Polylines as lists of vertex indices; a closed one repeats its first vertex.
    pub strokes: Vec<Vec<u32>>,
    /// Stiffness of each triangle, 0 or more, #triangles; empty for 1 everywhere.
    pub stiffness: Vec<f64>,
    /// Links that connect triangles, for [`Topology::Branching`](super::Topology::Branching). `None` links the triangles that
    /// share an edge at rest, and isolated parts to the nearest ones.
    pub(crate) links: Option<Arc<Vec<Link>>>,
}

impl<const D: usize> Shape<D> {
    /// Creates a shape of triangles of uniform stiffness.
    #[must_use]
    pub fn of_triangles(points: Vec<[f64; D]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { points, triangles, ..Self::default() }
    }

    /// Returns the length of the diagonal of the bounding box; 0 without points.
    pub(super) fn diagonal(&self) -> f64 {
        let side = |d: usize| {
            let values = self.points.iter().map(|point| point[d]);
            let [low, high] = [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)];
            (high - low).max(0.0)
        };
        (0..D).map(|d| side(d).powi(2)).sum::<f64>().sqrt()
    }
}

/// A point of the model at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModelPoint<const D: usize> {
    /// Rest position; a point outside the box counts as the nearest point of the box.
    pub at: [f64; D],
    /// Triangle of the shape on which the point lies, for shapes that overlap themselves; `None` for the nearest triangle.
    pub triangle: Option<u32>,
}

/// A point with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointPin<const D: usize> {
    /// Rest position of the point.
    pub at: [f64; D],
    /// Target position.
    pub target: [f64; D],
    /// Weight from 0 to 1, multiplied by the pin weight of the settings; a pin fades out as its weight falls to 0.
    pub weight: f64,
    /// Prescribed gradient at the pin (columns: images of the axes), for pins that hold a rotation and a scale.
    pub gradient: Option<[[f64; D]; D]>,
    /// Neighbourhood that moves with the pin; `None` for the point alone.
    pub(crate) region: Option<Region>,
    /// Triangle of the shape on which the point lies, for shapes that overlap themselves; `None` for the nearest triangle.
    pub triangle: Option<u32>,
}

impl<const D: usize> PointPin<D> {
    /// Creates a pin of full weight that holds only its position.
    #[must_use]
    pub fn new(at: [f64; D], target: [f64; D]) -> Self {
        Self { at, target, weight: 1.0, gradient: None, region: None, triangle: None }
    }

    /// The pin at another rest position, with the same displacement.
    pub(crate) fn moved_to(&self, at: [f64; D]) -> Self {
        let target = std::array::from_fn(|d| self.target[d] + at[d] - self.at[d]);
        Self { at, target, ..*self }
    }
}

/// Neighbourhood that moves with a pin; its effect fades out smoothly from the pin to the rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Region {
    /// Radius of the rim around the pin at rest, in units of the space.
    pub radius: f64,
    /// Rigidity with which the neighbourhood moves with the pin, from 0 (none) to 1 (rigid).
    pub rigidity: f64,
    /// Factor by which the stiffness of the shape is multiplied at the pin; it falls to 1 at the rim.
    pub stiffness: f64,
}

/// A handle with a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandlePin<const D: usize> {
    /// Index of the handle.
    pub index: usize,
    /// Target position.
    pub target: [f64; D],
}

/// All data of a solve.
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
