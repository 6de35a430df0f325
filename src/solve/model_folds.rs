//! Folds of a plain lattice where it holds the model.
//!
//! In: a shape at rest, a lattice over it. Out: [`Folds`] whose active cells are those that fold on a triangle of the shape.

use super::active_cells::active_cells;
use super::branching::polygons_in_cells;
use super::folds_on_polygons::CellPolygons;
use super::problem::Shape;
use crate::lattice::{Folds, Grid, Lattice, Support};

/// What of a grid holds the model.
#[derive(Clone, Debug, Default)]
pub(crate) struct ModelCells<const D: usize> {
    /// One flag per cell, x fastest.
    is_active: Vec<bool>,
    /// Corners of the triangles of the model in the upright grid; empty if strokes are part of it, whose cells count as a whole.
    triangles: Vec<[[f64; D]; 3]>,
}

impl<const D: usize> ModelCells<D> {
    pub(crate) fn of(grid: &Grid<D>, shape: &Shape<D>) -> Self {
        let corners =
            |triangle: &[u32; 3]| triangle.map(|corner| grid.upright_from_point(shape.points[corner as usize]));
        let triangles = shape.triangles.iter().filter(|_| shape.strokes.is_empty()).map(corners).collect();
        Self { is_active: active_cells(grid, shape), triangles }
    }

    /// Returns the folds of a lattice over the same grid. Those count as active that fold on a triangle; with bases that are not
    /// piecewise polynomials, those that hold one.
    pub(crate) fn folds(&self, lattice: &Lattice<D>) -> Folds<D> {
        self.folds_and_active(lattice).0
    }

    /// Same as [`Self::folds`], with the active ones of the folded cells.
    pub(crate) fn folds_and_active(&self, lattice: &Lattice<D>) -> (Folds<D>, Vec<[usize; D]>) {
        let grid = &lattice.grid;
        let whole = lattice.folds(&self.is_active);
        let number = |place: &[usize; D]| grid.cell_between_handles(place);
        let width = match grid.basis.support() {
            Support::Tensor { width } if whole.active_count > 0 && !self.triangles.is_empty() => width,
            Support::Tensor { .. } | Support::Simplex | Support::Global => {
                let active = whole.cells.iter().filter(|place| self.is_active[number(place)]).copied().collect();
                return (whole, active);
            }
        };
        let mut is_other = self.is_active.clone();
        let folded: Vec<usize> = whole.cells.iter().map(number).filter(|&cell| self.is_active[cell]).collect();
        folded.iter().for_each(|&cell| is_other[cell] = false);
        // The bound over whole cells is tight only without the folded ones.
        let others = if is_other.contains(&true) {
            lattice.active_folds(&is_other, f64::INFINITY).min_det
        } else {
            f64::INFINITY
        };
        let mut polygons = CellPolygons::within(grid, folded.iter().copied());
        let near = self.near(grid, &folded);
        polygons_in_cells(&grid.upright(), &near).for_each(|(cell, polygon)| polygons.add(cell, &polygon));
        let (folded, least) = polygons.folds(lattice, width, others);
        let min_det = if folded.is_empty() && others == f64::INFINITY && least == f64::INFINITY {
            1.0
        } else {
            others.min(least)
        };
        (Folds { active_count: folded.len(), min_det, ..whole }, folded)
    }

    /// Returns the triangles of which the bounding box reaches some cells, in the upright grid.
    fn near(&self, grid: &Grid<D>, cells: &[usize]) -> Shape<D> {
        let spans = grid.dims.map(|count| grid.basis.spans(count));
        let place = |corner: [f64; D]| -> [usize; D] {
            std::array::from_fn(|d| (((corner[d] - grid.lo[d]) / grid.spacing(d)).max(0.0) as usize).min(spans[d] - 1))
        };
        let is_near = |corners: &[[f64; D]; 3]| {
            let places = corners.map(place);
            let low: [usize; D] = std::array::from_fn(|d| places[0][d].min(places[1][d]).min(places[2][d]));
            let high: [usize; D] = std::array::from_fn(|d| places[0][d].max(places[1][d]).max(places[2][d]));
            cells.iter().any(|&cell| {
                let place = grid.cell_coords(cell);
                (0..D).all(|d| (low[d]..=high[d]).contains(&place[d]))
            })
        };
        let points: Vec<[f64; D]> =
            self.triangles.iter().filter(|corners| is_near(corners)).flatten().copied().collect();
        let triangles = (0..points.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        Shape::of_triangles(points, triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    /// The folds over a bar, in a single cell in which det J is 3 (x − ¼)² − 0.05: it folds for x between 0.121 and 0.379.
    fn folds_over<const D: usize>(bar: &Shape<D>, angle: f64) -> Folds<D> {
        let grid = Grid { dims: [4; D], basis: Basis::Bspline, lo: [0.0; D], hi: [1.0; D], angle };
        let mut lattice = grid.at_rest();
        for handle in &mut lattice.handles {
            let mut upright = grid.upright_from_point(*handle);
            upright[0] = (upright[0] - 0.25).powi(3) - 1.05 * upright[0];
            *handle = upright;
        }
        let points = bar.points.iter().map(|point| grid.point_from_upright(*point)).collect();
        let bar = Shape { points, ..bar.clone() };
        ModelCells::of(&grid, &bar).folds(&lattice)
    }

    /// A bar from one place along the first axis to another, across the others.
    fn bar<const D: usize>([low, high]: [f64; 2]) -> Shape<D> {
        let corner = |x: f64, y: f64| std::array::from_fn(|d| [x, y, y][d]);
        let points = vec![corner(low, 0.2), corner(high, 0.2), corner(high, 0.8), corner(low, 0.8)];
        Shape::of_triangles(points, vec![[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn a_cell_counts_only_if_it_folds_on_the_model() {
        for angle in [0.0, 0.5] {
            let beside = folds_over(&bar::<2>([0.6, 0.8]), angle);
            assert_eq!((beside.cells.len(), beside.active_count), (1, 0), "it folds beside the model");
            // 0.3175 at its left side.
            assert!((0.29..0.3176).contains(&beside.min_det), "{beside:?}");
            let folded = folds_over(&bar::<2>([0.2, 0.6]), angle);
            assert_eq!(folded.active_count, 1);
            assert!((-0.06..-0.049).contains(&folded.min_det), "{folded:?}");
            let touched = folds_over(&bar::<2>([0.375, 0.6]), angle);
            assert!(touched.active_count == 1 && touched.min_det < 0.0, "{touched:?}");
        }
    }

    #[test]
    fn in_space_too_and_lines_count_with_their_whole_cells() {
        let beside = folds_over(&bar::<3>([0.6, 0.8]), 0.0);
        assert!(beside.active_count == 0 && beside.min_det > 0.2, "{beside:?}");
        assert_eq!(folds_over(&bar::<3>([0.3, 0.8]), 0.0).active_count, 1);
        let line = Shape { strokes: vec![vec![0, 1]], triangles: Vec::new(), ..bar::<2>([0.6, 0.8]) };
        assert_eq!(folds_over(&line, 0.0).active_count, 1);
    }
}
