//! Where energy `area` looks at the lattice: points that stand for the model.
//!
//! In: a shape and a grid. Out: places with areas. The number of sub-cell samples depends on the grid only, so a solve
//! costs the same for a hundred vertices and for a million.

mod clip;
mod moments;

use super::Shape;
use super::small::area_of;
use super::small::minus;
use crate::lattice::{Basis, Grid};
use moments::Subcells;

/// A point that stands for a piece of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample<const D: usize> {
    /// Where.
    pub(crate) at: [f64; D],
    /// Area of the piece.
    pub(crate) area: f64,
    /// How stiff it is.
    pub(crate) stiffness: f64,
}

/// Sub-cells a lattice span and axis: with them a solve is within 4e-4 of a cell of one with fifteen (docs/METHOD.md).
const SUBCELLS: usize = 3;
/// From this number of spans on two are enough for that.
const MANY_SPANS: usize = 12;
/// Most sub-cells an axis of a Bernstein grid: its functions are about √n spans wide, so more see nothing new.
const BERNSTEIN_LIMIT: usize = 64;

/// Sub-cells of a grid, per axis.
pub(crate) fn subcell_dims<const D: usize>(grid: &Grid<D>) -> [usize; D] {
    grid.dims.map(|count| {
        let spans = grid.basis.spans(count);
        let wanted = spans * if spans < MANY_SPANS { SUBCELLS } else { SUBCELLS - 1 };
        if grid.basis == Basis::Bernstein { wanted.min(BERNSTEIN_LIMIT) } else { wanted }
    })
}

/// One sample a triangle: centroid and unsigned area. An empty shape: the box, evenly.
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

/// Up to 2 D samples an occupied sub-cell, with the area, centroid and covariance of what the model has inside it.
/// A shape with nothing inside the box: the box, evenly.
pub(crate) fn subcell_samples<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Vec<Sample<D>> {
    let samples = Subcells::of(grid, shape).samples();
    if samples.is_empty() { even_samples(grid) } else { samples }
}

/// The middle of every sub-cell.
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
