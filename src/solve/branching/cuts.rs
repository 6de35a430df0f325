//! The parts of triangles in the cells of a grid.
//!
//! In: a shape and a grid. Out: one [`Cut`] per intersecting pair of triangle and cell. Parts outside the box belong to the
//! nearest cell, because they move with it.

use crate::lattice::Grid;
use crate::solve::linalg::small_matrix::{area_of, minus};
use crate::solve::problem::Shape;
use crate::solve::samples::Polygon;

/// Parts with a smaller area, as a fraction of a cell, are ignored, unless the whole triangle is that small.
const MIN_AREA: f64 = 1e-9;

/// The part of a triangle that lies in a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut<const D: usize> {
    /// Index of the triangle.
    pub(super) triangle: usize,
    /// Index of the cell, x fastest.
    pub(super) cell: usize,
    /// Area of the part.
    pub(super) area: f64,
    /// The part itself.
    pub(super) polygon: Polygon<D>,
}

impl<const D: usize> Cut<D> {
    /// The mean of the corners.
    pub(super) fn middle(&self) -> [f64; D] {
        let corners = self.polygon.corners();
        std::array::from_fn(|d| corners.iter().map(|corner| corner[d]).sum::<f64>() / corners.len() as f64)
    }
}

/// All cuts, in the order of the triangles.
pub(super) fn cuts<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Vec<Cut<D>> {
    let side = (0..D).map(|axis| grid.spacing(axis)).fold(f64::INFINITY, f64::min);
    let least = MIN_AREA * side * side;
    let mut cuts: Vec<Cut<D>> = Vec::new();
    for (triangle, corners) in shape.triangles.iter().enumerate() {
        let corners = corners.map(|corner| shape.points[corner as usize]);
        let first = cuts.len();
        let is_small = area(&corners) <= least;
        cut_by_cells(grid, &mut Polygon::triangle(corners), (0, 0), &mut |cell, polygon| {
            let area = area(polygon.corners());
            if area > least || is_small {
                cuts.push(Cut { triangle, cell, area, polygon: *polygon });
            }
        });
        debug_assert!(cuts.len() > first, "a triangle lies in some cell");
    }
    cuts
}

/// Cuts a polygon into the slabs of each axis in turn. `cell` is the contribution of the previous axes to the index of the cell.
fn cut_by_cells<const D: usize>(
    grid: &Grid<D>,
    polygon: &mut Polygon<D>,
    (axis, cell): (usize, usize),
    visit: &mut dyn FnMut(usize, &Polygon<D>),
) {
    if axis == D {
        return visit(cell, polygon);
    }
    let spans = |axis: usize| grid.basis.spans(grid.dims[axis]);
    let stride: usize = (0..axis).map(spans).product();
    let place = |x: f64| ((x - grid.lo[axis]) / grid.spacing(axis)).clamp(0.0, (spans(axis) - 1) as f64) as usize;
    let [low, high] = polygon.range(axis).map(place);
    for slab in low..=high {
        if slab == high {
            return cut_by_cells(grid, polygon, (axis + 1, cell + slab * stride), visit);
        }
        let border = grid.lo[axis] + (slab + 1) as f64 * grid.spacing(axis);
        let mut below = polygon.split_off(axis, border);
        if !below.corners().is_empty() {
            cut_by_cells(grid, &mut below, (axis + 1, cell + slab * stride), visit);
        }
        if polygon.corners().is_empty() {
            return;
        }
    }
}

/// Area of a convex polygon.
fn area<const D: usize>(corners: &[[f64; D]]) -> f64 {
    let Some((first, rest)) = corners.split_first() else { return 0.0 };
    rest.windows(2).map(|pair| 0.5 * area_of(&minus(&pair[0], first), &minus(&pair[1], first))).sum()
}
