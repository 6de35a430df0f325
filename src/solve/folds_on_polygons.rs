//! Folds of a lattice on parts of its cells: the polygons of the model in them. Thin parts leave most of a cell empty, so a cell that
//! folds somewhere counts only if it folds on one of these.
//!
//! In: a lattice, folded cells with their polygons. Out: a lower bound of det J on the polygons of each.

use super::samples::Polygon;
use crate::lattice::{Grid, Lattice, PartOfCell};
use std::collections::BTreeMap;

/// The polygons of the model in some cells, each scaled to its cell as the unit cell. Ordered by the index of the cell.
pub(super) struct CellPolygons<'a, const D: usize> {
    grid: &'a Grid<D>,
    of_cells: BTreeMap<usize, Vec<Polygon<D>>>,
}

impl<'a, const D: usize> CellPolygons<'a, D> {
    /// Starts with no polygons, for cells given by their indices.
    pub(super) fn within(grid: &'a Grid<D>, cells: impl Iterator<Item = usize>) -> Self {
        Self { grid, of_cells: cells.map(|cell| (cell, Vec::new())).collect() }
    }

    /// Adds a polygon of the upright grid that lies in a cell, unless the cell is none of these.
    pub(super) fn add(&mut self, cell: usize, polygon: &Polygon<D>) {
        let grid = self.grid;
        let Some(polygons) = self.of_cells.get_mut(&cell) else { return };
        let place = grid.cell_coords(cell);
        polygons
            .push(polygon.mapped(|corner| {
                std::array::from_fn(|d| (corner[d] - grid.lo[d]) / grid.spacing(d) - place[d] as f64)
            }));
    }

    /// Returns the cells between handles that fold on their polygons, and a lower bound of det J on all polygons, which is tight only if it
    /// may be less than `wanted`. `width`: number of handles that act at a coordinate.
    pub(super) fn folds(self, lattice: &Lattice<D>, width: usize, wanted: f64) -> (Vec<[usize; D]>, f64) {
        let (mut cells, mut min_det) = (Vec::new(), f64::INFINITY);
        let margin = self.grid.basis.margin();
        for (cell, polygons) in self.of_cells.into_iter().filter(|(_, polygons)| !polygons.is_empty()) {
            let least = lattice.min_in_part(PartOfCell { cell, width, part: polygons }, wanted.min(min_det), halves);
            if least <= 0.0 {
                cells.push(self.grid.cell_coords(cell).map(|place| place + margin));
            }
            min_det = min_det.min(least);
        }
        (cells, min_det)
    }
}

/// The halves of polygons in the unit cell along an axis, each scaled to the unit cell.
fn halves<const D: usize>(polygons: Vec<Polygon<D>>, axis: usize) -> [Option<Vec<Polygon<D>>>; 2] {
    let (mut below, mut above) = (Vec::new(), Vec::new());
    for mut polygon in polygons {
        let lower = polygon.split_off(axis, 0.5);
        for (half, part, shift) in [(&mut below, lower, 0.0), (&mut above, polygon, 1.0)] {
            if !part.corners().is_empty() {
                half.push(part.mapped(|mut corner| {
                    corner[axis] = 2.0 * corner[axis] - shift;
                    corner
                }));
            }
        }
    }
    [below, above].map(|half| (!half.is_empty()).then_some(half))
}
