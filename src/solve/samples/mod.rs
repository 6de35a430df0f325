//! Samples of the model, at which energy `area` evaluates the gradient of the lattice.
//!
//! In: a shape and a grid. Out: positions with areas. The number of sub-cell samples depends on the grid only, so a solve costs
//! the same for a hundred vertices as for a million.

mod clip;
mod moments;
mod sample;

pub(crate) use clip::Polygon;
pub(crate) use sample::{Sample, subcell_dims};

use super::linalg::small_matrix::{area_of, minus};
use super::problem::Shape;
use crate::lattice::Grid;
use moments::Subcells;

/// Returns one sample per triangle, its centroid with the unsigned area; for an empty shape, even samples of the box.
pub(crate) fn centroid_samples<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Vec<Sample<D>> {
    let samples: Vec<Sample<D>> = shape
        .triangles
        .iter()
        .enumerate()
        .map(|(number, triangle)| {
            let [a, b, c] = triangle.map(|corner| &shape.points[corner as usize]);
            let at = std::array::from_fn(|d| (a[d] + b[d] + c[d]) / 3.0);
            Sample { at, area: 0.5 * area_of(&minus(b, a), &minus(c, a)), stiffness: shape.stiffness_of(number) }
        })
        .filter(|sample| sample.area > 0.0)
        .collect();
    if samples.is_empty() { even_samples(grid) } else { samples }
}

/// Returns 2 D samples for each sub-cell that contains some of the model, with the area, centroid and covariance of that part. A
/// shape outside the box gets even samples of the box.
pub(crate) fn subcell_samples<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Vec<Sample<D>> {
    let samples = Subcells::of(grid, shape).samples();
    if samples.is_empty() { even_samples(grid) } else { samples }
}

/// Same as [`subcell_samples`] for polygons in one cell of the grid, each with its stiffness. They may lie outside the box and then get
/// no samples; no sample leaves its sub-cell. Areas of at most `least` in a sub-cell are ignored.
pub(crate) fn samples_of_cell<'a, const D: usize>(
    grid: &Grid<D>,
    cell: usize,
    polygons: impl Iterator<Item = (&'a Polygon<D>, f64)>,
    least: f64,
) -> Vec<Sample<D>> {
    let mut samples = Subcells::in_cell(grid, cell, polygons).samples_inside(least);
    // Rounding can move a sliver across the border of its cell.
    let own = grid.cell_coords(cell);
    let first = (0..D).map(|axis| own[axis] * grid.stride(axis)).sum::<usize>();
    samples.retain(|sample| grid.support(sample.at) == [first, 0]);
    samples
}

/// Returns the centres of all sub-cells, with a total area of 1.
fn even_samples<const D: usize>(grid: &Grid<D>) -> Vec<Sample<D>> {
    let dims = subcell_dims(grid);
    let count: usize = dims.iter().product();
    let middle = |number: usize| {
        std::array::from_fn(|axis| {
            let before: usize = dims[..axis].iter().product();
            let place = (number / before % dims[axis]) as f64 + 0.5;
            grid.lo[axis] + place / dims[axis] as f64 * grid.size(axis)
        })
    };
    (0..count).map(|number| Sample { at: middle(number), area: 1.0 / count as f64, stiffness: 1.0 }).collect()
}
