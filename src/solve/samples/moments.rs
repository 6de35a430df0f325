//! Area, centroid and covariance of a model inside every sub-cell of a grid, and the points that match them.
//!
//! In: triangles (any orientation, slivers, overlaps) and the sub-cells of a box. Out: samples.
//! Triangles inside one sub-cell add their moments; only those across borders are cut.

use super::clip::Polygon;
use super::{Sample, subcell_dims};
use crate::lattice::Grid;
use crate::solve::Shape;
use crate::solve::small::{area_of, minus, symmetric_root};
use rayon::prelude::*;

/// Triangles one task takes. Fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 1 << 15;

/// Moments about the middle of a sub-cell.
#[derive(Clone, Copy, Debug)]
struct Moments<const D: usize> {
    area: f64,
    first: [f64; D],
    second: [[f64; D]; D],
}

impl<const D: usize> Moments<D> {
    const NONE: Self = Self { area: 0.0, first: [0.0; D], second: [[0.0; D]; D] };

    fn add(&mut self, other: &Self) {
        self.area += other.area;
        for a in 0..D {
            self.first[a] += other.first[a];
            (0..D).for_each(|b| self.second[a][b] += other.second[a][b]);
        }
    }

    /// Adds a triangle whose corners are relative to the middle: ∫xxᵀ = A/12 (Σ v vᵀ + 9 c cᵀ).
    fn add_triangle(&mut self, corners: [[f64; D]; 3]) {
        let [v0, v1, v2] = corners;
        let area = 0.5 * area_of(&minus(&v1, &v0), &minus(&v2, &v0));
        let sum: [f64; D] = std::array::from_fn(|d| v0[d] + v1[d] + v2[d]);
        let (third, twelfth) = (area / 3.0, area / 12.0);
        self.area += area;
        for a in 0..D {
            self.first[a] += third * sum[a];
            for b in 0..D {
                let squares = v0[a] * v0[b] + v1[a] * v1[b] + v2[a] * v2[b];
                self.second[a][b] += twelfth * (squares + sum[a] * sum[b]);
            }
        }
    }

    /// Points middle + c ± s_k with s_k the columns of √D·Σ^½: 2 D equal areas with the same first and second moments.
    fn samples(&self, middle: [f64; D], samples: &mut Vec<Sample<D>>) {
        let mean = self.first.map(|x| x / self.area);
        let covariance =
            std::array::from_fn(|a| std::array::from_fn(|b| self.second[a][b] / self.area - mean[a] * mean[b]));
        let root = symmetric_root::<D>(&covariance);
        let (spread, area) = ((D as f64).sqrt(), self.area / (2 * D) as f64);
        for column in 0..D {
            for sign in [-spread, spread] {
                let at = std::array::from_fn(|d| middle[d] + mean[d] + sign * root[d][column]);
                samples.push(Sample { at, area });
            }
        }
    }
}

/// The sub-cells of a grid.
#[derive(Clone, Copy, Debug)]
struct Layout<const D: usize> {
    dims: [usize; D],
    lo: [f64; D],
    side: [f64; D],
}

impl<const D: usize> Layout<D> {
    fn of(grid: &Grid<D>) -> Self {
        let dims = subcell_dims(grid);
        Self { dims, lo: grid.lo, side: std::array::from_fn(|axis| grid.size(axis) / dims[axis] as f64) }
    }

    fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Cell coordinate of a place; below 0 or from `dims` on it lies outside.
    fn cell(&self, axis: usize, x: f64) -> f64 {
        ((x - self.lo[axis]) / self.side[axis]).floor()
    }

    fn border(&self, axis: usize, cell: usize) -> f64 {
        self.lo[axis] + cell as f64 * self.side[axis]
    }

    fn middle(&self, place: [usize; D]) -> [f64; D] {
        std::array::from_fn(|axis| self.border(axis, place[axis]) + 0.5 * self.side[axis])
    }

    fn number(&self, place: [usize; D]) -> usize {
        (0..D).rev().fold(0, |number, axis| number * self.dims[axis] + place[axis])
    }

    fn place(&self, number: usize) -> [usize; D] {
        std::array::from_fn(|axis| number / self.dims[..axis].iter().product::<usize>() % self.dims[axis])
    }
}

/// Moments of a shape in all sub-cells.
#[derive(Clone, Debug)]
pub(super) struct Subcells<const D: usize> {
    layout: Layout<D>,
    cells: Vec<Moments<D>>,
}

impl<const D: usize> Subcells<D> {
    /// Spreads a shape over the sub-cells of a grid; what lies outside the box is left out.
    pub(super) fn of(grid: &Grid<D>, shape: &Shape<D>) -> Self {
        let layout = Layout::of(grid);
        let empty = Self { layout, cells: vec![Moments::NONE; layout.count()] };
        let spread = |triangles: &[[u32; 3]]| {
            let mut part = empty.clone();
            triangles.iter().for_each(|t| part.add_triangle(t.map(|corner| shape.points[corner as usize])));
            part
        };
        if shape.triangles.len() <= CHUNK {
            return spread(&shape.triangles);
        }
        let parts: Vec<Self> = shape.triangles.par_chunks(CHUNK).map(spread).collect();
        let mut total = empty;
        for part in &parts {
            total.cells.iter_mut().zip(&part.cells).for_each(|(cell, other)| cell.add(other));
        }
        total
    }

    fn add_triangle(&mut self, corners: [[f64; D]; 3]) {
        let mut place = [0; D];
        for axis in 0..D {
            let cells = corners.map(|corner| self.layout.cell(axis, corner[axis]));
            let most = self.layout.dims[axis] as f64;
            let low = cells[0].min(cells[1]).min(cells[2]);
            let high = cells[0].max(cells[1]).max(cells[2]);
            if high < 0.0 || low > most {
                return;
            }
            if low != high || low < 0.0 || low >= most {
                return self.cut(Polygon::triangle(corners), 0, [0; D]);
            }
            place[axis] = low as usize;
        }
        self.add_piece(corners, place);
    }

    fn add_piece(&mut self, corners: [[f64; D]; 3], place: [usize; D]) {
        let middle = self.layout.middle(place);
        self.cells[self.layout.number(place)].add_triangle(corners.map(|corner| minus(&corner, &middle)));
    }

    /// Cuts a polygon into the slabs of one axis after the other.
    fn cut(&mut self, polygon: Polygon<D>, axis: usize, mut place: [usize; D]) {
        if axis == D {
            let corners = polygon.corners();
            for k in 2..corners.len() {
                self.add_piece([corners[0], corners[k - 1], corners[k]], place);
            }
            return;
        }
        let [low, high] = polygon.range(axis).map(|x| self.layout.cell(axis, x));
        let most = self.layout.dims[axis] as f64;
        if high < 0.0 || low > most {
            return;
        }
        let mut rest = polygon;
        if low < 0.0 {
            rest = rest.split(axis, self.layout.lo[axis])[1];
        }
        let last = high.min(most - 1.0) as usize;
        for cell in low.max(0.0) as usize..=last {
            place[axis] = cell;
            if cell as f64 == high {
                return self.cut(rest, axis + 1, place);
            }
            let [below, above] = rest.split(axis, self.layout.border(axis, cell + 1));
            self.cut(below, axis + 1, place);
            rest = above;
        }
    }

    /// The samples of all occupied sub-cells, in cell order.
    pub(super) fn samples(&self) -> Vec<Sample<D>> {
        let total: f64 = self.cells.iter().map(|cell| cell.area).sum();
        // A touch of rounding at a border is no piece of the model.
        let least = 1e-12 * total;
        let mut samples = Vec::new();
        for (number, cell) in self.cells.iter().enumerate() {
            if cell.area > least {
                cell.samples(self.layout.middle(self.layout.place(number)), &mut samples);
            }
        }
        samples
    }
}
