//! Grids at rest: validation, rest handles, and the weight and gradient of every handle at a point.
//!
//! In: dims, basis, box. Out: rows of W and ∇W (sparse if the basis is local).

use super::axis::{self, AxisTerms, MAX_HANDLES, MAX_HANDLES_IN_ALL, MAX_LOCAL};
use super::basis::{Basis, Support};
use super::error::LatticeError;
use crate::space::{RotatedBox, ScreenBox, ScreenPoint};

/// Capacity that suffices for most axes and is faster to clear than [`MAX_HANDLES`].
const USUAL: usize = 16;

/// Weight and gradient of a handle at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HandleWeight<const D: usize> {
    /// Index of the handle.
    pub(crate) handle: usize,
    /// Weight of the handle; all weights at a point sum to 1.
    pub(crate) weight: f64,
    /// Gradient of the weight, per unit of space.
    pub(crate) gradient: [f64; D],
}

/// A grid of handles over a rest box, in D dimensions. Handle index h = i + nx·(j + ny·k).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<const D: usize> {
    /// Handles per axis.
    pub dims: [usize; D],
    /// Basis functions.
    pub basis: Basis,
    /// Lower corner of the rest box.
    pub lo: [f64; D],
    /// Upper corner of the rest box.
    pub hi: [f64; D],
    /// Rotation of the rest box about its centre, in radians: from the first axis to the second, in 2D counter-clockwise.
    pub angle: f64,
}

/// A grid with moved handles.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice<const D: usize> {
    /// The grid at rest.
    pub grid: Grid<D>,
    /// Positions of the handles: #handles, x fastest.
    pub handles: Vec<[f64; D]>,
}

/// A lattice in screen space.
pub type ScreenLattice = Lattice<2>;

impl Grid<2> {
    /// Creates a grid over a box of the screen.
    #[must_use]
    pub(crate) fn over(bounds: impl Into<RotatedBox>, dims: [usize; 2], basis: Basis) -> Self {
        let RotatedBox { upright: ScreenBox { min, max }, angle } = bounds.into();
        Self { dims, basis, lo: min.0.to_array(), hi: max.0.to_array(), angle }
    }

    /// Returns the box of the grid.
    #[must_use]
    pub(crate) fn bounds(&self) -> RotatedBox {
        let upright = ScreenBox::new(ScreenPoint(self.lo.into()), ScreenPoint(self.hi.into()));
        RotatedBox { upright, angle: self.angle }
    }
}

impl<const D: usize> Grid<D> {
    /// Checks dims, their product and the box.
    ///
    /// # Errors
    /// [`LatticeError`], naming the axis.
    pub(crate) fn check(&self) -> Result<(), LatticeError> {
        let least = self.basis.min_handles();
        for axis in 0..D {
            let found = self.dims[axis];
            if !(least..=MAX_HANDLES).contains(&found) {
                return Err(LatticeError::Dims { axis, found, least, most: MAX_HANDLES, basis: self.basis });
            }
            let (lo, hi) = (self.lo[axis], self.hi[axis]);
            if !((hi - lo).is_normal() && hi > lo && lo.is_finite()) {
                return Err(LatticeError::Box { axis, lo, hi });
            }
        }
        if !self.angle.is_finite() {
            return Err(LatticeError::Angle { angle: self.angle });
        }
        match self.handle_count() {
            found if found > MAX_HANDLES_IN_ALL => Err(LatticeError::Size { found, most: MAX_HANDLES_IN_ALL }),
            _ => Ok(()),
        }
    }

    /// Returns the number of handles.
    #[must_use]
    pub(crate) fn handle_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Returns the number of cells of the box.
    #[must_use]
    pub(crate) fn cell_count(&self) -> usize {
        self.dims.iter().map(|&count| self.basis.spans(count)).product()
    }

    /// Returns column, row (and layer) of a cell, numbered x fastest.
    #[must_use]
    pub(crate) fn cell_coords(&self, mut cell: usize) -> [usize; D] {
        self.dims.map(|count| {
            let (spans, place) = (self.basis.spans(count), cell);
            cell /= spans;
            place % spans
        })
    }

    /// Returns the number of a cell, x fastest, from its place between handles as in [`super::Folds::cells`], which also counts the
    /// handles outside the box.
    #[must_use]
    pub(crate) fn cell_between_handles(&self, place: &[usize; D]) -> usize {
        let margin = self.basis.margin();
        (0..D).rev().fold(0, |cell, axis| cell * self.basis.spans(self.dims[axis]) + place[axis] - margin)
    }

    /// Returns the extent of the box on an axis.
    #[must_use]
    pub fn size(&self, axis: usize) -> f64 {
        self.hi[axis] - self.lo[axis]
    }

    /// Returns the length of the diagonal of the box.
    #[must_use]
    pub(crate) fn diagonal(&self) -> f64 {
        (0..D).map(|axis| self.size(axis).powi(2)).sum::<f64>().sqrt()
    }

    /// Returns the distance between rest handles along an axis.
    #[must_use]
    pub(crate) fn spacing(&self, axis: usize) -> f64 {
        self.size(axis) / self.basis.spans(self.dims[axis]) as f64
    }

    /// Returns the step of the handle index along an axis.
    #[must_use]
    pub(crate) fn stride(&self, axis: usize) -> usize {
        self.dims[..axis].iter().product()
    }

    /// Returns column, row (and layer) of a handle.
    #[must_use]
    pub(crate) fn handle_coords(&self, index: usize) -> [usize; D] {
        std::array::from_fn(|axis| index / self.stride(axis) % self.dims[axis])
    }

    /// Returns the same grid over the box before its rotation.
    #[must_use]
    pub(crate) fn upright(&self) -> Self {
        Self { angle: 0.0, ..self.clone() }
    }

    /// Rotates a vector by the angle of the box.
    #[must_use]
    pub(crate) fn rotated(&self, vector: [f64; D]) -> [f64; D] {
        if self.angle == 0.0 { vector } else { rotated(vector, self.angle.sin_cos()) }
    }

    /// Rotates a vector by minus the angle of the box.
    #[must_use]
    pub(crate) fn rotated_back(&self, vector: [f64; D]) -> [f64; D] {
        if self.angle == 0.0 { vector } else { rotated(vector, (-self.angle).sin_cos()) }
    }

    /// Converts a vector in box sizes, along the axes of the box.
    #[must_use]
    pub(crate) fn scaled_to_box(&self, vector: [f64; D]) -> [f64; D] {
        self.rotated(std::array::from_fn(|axis| vector[axis] * self.size(axis)))
    }

    /// Rotates a point back about the centre of the box, as if the box were not rotated.
    #[must_use]
    pub(crate) fn upright_from_point(&self, point: [f64; D]) -> [f64; D] {
        self.rotated_about_center(point, -self.angle)
    }

    /// Rotates a point with the box about its centre.
    #[must_use]
    pub(crate) fn point_from_upright(&self, point: [f64; D]) -> [f64; D] {
        self.rotated_about_center(point, self.angle)
    }

    fn rotated_about_center(&self, point: [f64; D], angle: f64) -> [f64; D] {
        if angle == 0.0 {
            return point;
        }
        let center: [f64; D] = std::array::from_fn(|axis| 0.5 * (self.lo[axis] + self.hi[axis]));
        let lever: [f64; D] = rotated(std::array::from_fn(|axis| point[axis] - center[axis]), angle.sin_cos());
        std::array::from_fn(|axis| center[axis] + lever[axis])
    }

    /// Returns the rest position of a handle; B-spline handles start one spacing outside the box.
    #[must_use]
    pub(crate) fn rest_handle(&self, index: usize) -> [f64; D] {
        let place = self.handle_coords(index);
        let shift = self.basis.margin() as f64;
        self.point_from_spans(std::array::from_fn(|axis| place[axis] as f64 - shift))
    }

    /// Returns the point at this number of spans along each axis of the box.
    #[must_use]
    pub(crate) fn point_from_spans(&self, spans: [f64; D]) -> [f64; D] {
        self.point_from_upright(std::array::from_fn(|axis| self.lo[axis] + spans[axis] * self.spacing(axis)))
    }

    /// Returns the point at coordinates of the box, 0 to 1 per axis.
    #[must_use]
    pub(crate) fn point_from_unit(&self, unit: [f64; D]) -> [f64; D] {
        self.point_from_upright(std::array::from_fn(|axis| self.lo[axis] + unit[axis] * self.size(axis)))
    }

    /// Returns all rest handles, in index order.
    #[must_use]
    pub(crate) fn rest_handles(&self) -> Vec<[f64; D]> {
        (0..self.handle_count()).map(|index| self.rest_handle(index)).collect()
    }

    /// Returns the lattice with all handles at rest: the identity.
    #[must_use]
    pub fn at_rest(&self) -> Lattice<D> {
        Lattice { grid: self.clone(), handles: self.rest_handles() }
    }

    /// Returns the coordinates of a point in the box, 0 to 1 per axis; not clamped.
    #[must_use]
    pub(crate) fn unit_from_point(&self, point: [f64; D]) -> [f64; D] {
        let point = self.upright_from_point(point);
        std::array::from_fn(|axis| {
            let size = self.size(axis);
            if size > 0.0 { (point[axis] - self.lo[axis]) / size } else { 0.0 }
        })
    }

    /// Returns the point of the box nearest to `point`.
    #[must_use]
    pub(crate) fn clamp_to_box(&self, point: [f64; D]) -> [f64; D] {
        let upright = self.upright_from_point(point);
        let inside = std::array::from_fn(|axis| upright[axis].max(self.lo[axis]).min(self.hi[axis]));
        // Points of the box keep their bits.
        if inside == upright { point } else { self.point_from_upright(inside) }
    }

    /// Returns the basis functions of every axis at a point.
    pub(crate) fn axes<const N: usize>(&self, point: [f64; D]) -> [AxisTerms<N>; D] {
        let unit = self.unit_from_point(point);
        std::array::from_fn(|axis| AxisTerms::at(self.basis, self.dims[axis], unit[axis]))
    }

    /// Calls `visit` for every handle with a weight at a point. Outside the box the polynomials are extended.
    pub(crate) fn for_each_weight(&self, point: [f64; D], mut visit: impl FnMut(HandleWeight<D>)) {
        let turn = (self.angle != 0.0).then(|| self.angle.sin_cos());
        let visit = |term: HandleWeight<D>| {
            let gradient = turn.map_or(term.gradient, |turn| rotated(term.gradient, turn));
            visit(HandleWeight { gradient, ..term });
        };
        match self.basis.support() {
            Support::Simplex => self.visit_simplex(point, visit),
            Support::Tensor { .. } => self.visit_tensor::<MAX_LOCAL>(point, visit),
            Support::Global if self.dims.iter().all(|&count| count <= USUAL) => {
                self.visit_tensor::<USUAL>(point, visit);
            }
            Support::Global => self.visit_tensor::<MAX_HANDLES>(point, visit),
        }
    }

    fn visit_tensor<const N: usize>(&self, point: [f64; D], mut visit: impl FnMut(HandleWeight<D>)) {
        let mut axes = self.axes::<N>(point);
        (0..D).for_each(|axis| axes[axis].scale_slopes(1.0 / self.size(axis)));
        let mut at = [0; D];
        loop {
            let row = self.row_factors(&axes, at);
            for (i, (value, slope)) in axes[0].values().iter().zip(axes[0].slopes()).enumerate() {
                let mut gradient = row.gradient.map(|slant| slant * value);
                gradient[0] = row.weight * slope;
                visit(HandleWeight { handle: row.handle + i, weight: row.weight * value, gradient });
            }
            let Some(axis) = (1..D).find(|&axis| at[axis] + 1 < axes[axis].values().len()) else { return };
            at[..axis].fill(0);
            at[axis] += 1;
        }
    }

    /// Returns a key of the handles with a weight at a point: points with equal keys have the same handles in the same order.
    pub(crate) fn support(&self, point: [f64; D]) -> [usize; 2] {
        if !self.basis.is_local() {
            return [0; 2];
        }
        let unit = self.unit_from_point(point);
        let spans = |axis: usize| self.basis.spans(self.dims[axis]);
        let cells: [(usize, f64); D] = std::array::from_fn(|axis| axis::cell(spans(axis), unit[axis]));
        let cell = (0..D).map(|axis| cells[axis].0 * self.stride(axis)).sum();
        if self.basis.support() != Support::Simplex {
            return [cell, 0];
        }
        let order = Self::descending(&cells);
        [cell, order.iter().fold(0, |code, axis| code * D + axis)]
    }

    /// Orders the axes by local coordinate, largest first.
    fn descending(cells: &[(usize, f64); D]) -> [usize; D] {
        let mut order: [usize; D] = std::array::from_fn(|axis| axis);
        order.sort_by(|&a, &b| cells[b].1.total_cmp(&cells[a].1));
        order
    }

    /// Returns the common factors of a row of handles: its first handle, and the products of the functions of all axes but x.
    fn row_factors<const N: usize>(&self, axes: &[AxisTerms<N>; D], at: [usize; D]) -> HandleWeight<D> {
        let mut row = HandleWeight { handle: axes[0].first, weight: 1.0, gradient: [1.0; D] };
        for axis in 1..D {
            let value = axes[axis].values()[at[axis]];
            row.handle += (axes[axis].first + at[axis]) * self.stride(axis);
            row.weight *= value;
            for (other, slot) in row.gradient.iter_mut().enumerate() {
                *slot *= if other == axis { axes[axis].slopes()[at[axis]] } else { value };
            }
        }
        row
    }

    /// Barycentric cells: each is cut along its diagonal (in 3D into six) by the order of the local coordinates.
    fn visit_simplex(&self, point: [f64; D], mut visit: impl FnMut(HandleWeight<D>)) {
        let unit = self.unit_from_point(point);
        let cells: [(usize, f64); D] = std::array::from_fn(|axis| axis::cell(self.dims[axis] - 1, unit[axis]));
        let order = Self::descending(&cells);
        let mut handle: usize = (0..D).map(|axis| cells[axis].0 * self.stride(axis)).sum();
        // The path 00 → 10 → 11 takes the largest coordinate first; weights are the drops along it.
        for corner in 0..=D {
            let mut gradient = [0.0; D];
            let mut weight = 1.0;
            if corner > 0 {
                let axis = order[corner - 1];
                handle += self.stride(axis);
                weight = cells[axis].1;
                gradient[axis] = 1.0 / self.spacing(axis);
            }
            if corner < D {
                let axis = order[corner];
                weight -= cells[axis].1;
                gradient[axis] = -1.0 / self.spacing(axis);
            }
            visit(HandleWeight { handle, weight, gradient });
        }
    }

    /// Returns the row of W at a point: handles and weights, sparse if the basis is local.
    #[must_use]
    pub(crate) fn weights(&self, point: [f64; D]) -> Vec<(usize, f64)> {
        let mut row = Vec::new();
        self.for_each_weight(point, |term| row.push((term.handle, term.weight)));
        row
    }
}

/// Rotates a vector in the plane of the first two axes, by an angle with this sine and cosine.
fn rotated<const D: usize>(mut vector: [f64; D], (sin, cos): (f64, f64)) -> [f64; D] {
    if D > 1 {
        (vector[0], vector[1]) = (cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]);
    }
    vector
}
