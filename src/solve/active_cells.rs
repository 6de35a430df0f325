//! Finds the active cells of a grid: those that a triangle or stroke of the model touches. Only folds in active cells are visible.
//!
//! In: a grid and a shape. Out: one flag per cell. Parts of the model outside the box mark the nearest cell, because they move
//! with it.
//! Method: separating axis test of each triangle against the cells of its bounding box.

use super::linalg::small_matrix::{dot, minus};
use super::problem::Shape;
use crate::lattice::Grid;
use rayon::prelude::*;

/// Triangles per task.
const CHUNK: usize = 1 << 15;

/// Returns one flag per cell, x fastest. A shape without triangles and strokes marks every cell. In 3D, where only the normals of
/// the edges are tested, a large triangle may also mark cells up to one cell away from it.
pub(crate) fn active_cells<const D: usize>(grid: &Grid<D>, shape: &Shape<D>) -> Vec<bool> {
    if shape.triangles.is_empty() && shape.strokes.is_empty() {
        return vec![true; grid.cell_count()];
    }
    let per_cell: [f64; D] = std::array::from_fn(|axis| 1.0 / grid.spacing(axis));
    let spread = |triangles: &[[u32; 3]]| {
        let mut is_active = vec![false; grid.cell_count()];
        for triangle in triangles {
            mark((grid, per_cell), triangle.map(|corner| shape.points[corner as usize]), &mut is_active);
        }
        is_active
    };
    let mut is_active = vec![false; grid.cell_count()];
    for part in shape.triangles.par_chunks(CHUNK).map(spread).collect::<Vec<_>>() {
        is_active.iter_mut().zip(part).for_each(|(all, one)| *all |= one);
    }
    for [a, b] in shape.strokes.iter().flat_map(|stroke| stroke.windows(2).map(|ends| [ends[0], ends[1]])) {
        let [a, b] = [a, b].map(|end| shape.points[end as usize]);
        mark((grid, per_cell), [a, b, b], &mut is_active);
    }
    is_active
}

/// Marks the cells that a triangle touches. `per_cell` holds the reciprocal of the cell size along each axis.
fn mark<const D: usize>((grid, per_cell): (&Grid<D>, [f64; D]), corners: [[f64; D]; 3], is_active: &mut [bool]) {
    // Corners in units of cells, clamped to the box.
    let spans = grid.dims.map(|count| grid.basis.spans(count));
    let corners = corners.map(|corner| -> [f64; D] {
        let corner = grid.upright_from_point(corner);
        std::array::from_fn(|axis| ((corner[axis] - grid.lo[axis]) * per_cell[axis]).max(0.0).min(spans[axis] as f64))
    });
    let cells = corners
        .map(|corner| -> [usize; D] { std::array::from_fn(|axis| (corner[axis] as usize).min(spans[axis] - 1)) });
    let number_of = |place: &[usize; D]| (0..D).rev().fold(0, |index, axis| index * spans[axis] + place[axis]);
    if cells[0] == cells[1] && cells[0] == cells[2] {
        is_active[number_of(&cells[0])] = true;
        return;
    }
    let low: [usize; D] = std::array::from_fn(|axis| cells[0][axis].min(cells[1][axis]).min(cells[2][axis]));
    let high: [usize; D] = std::array::from_fn(|axis| cells[0][axis].max(cells[1][axis]).max(cells[2][axis]));
    let count: usize = (0..D).map(|axis| high[axis] - low[axis] + 1).product();
    for mut number in 0..count {
        let place: [usize; D] = std::array::from_fn(|axis| {
            let side = high[axis] - low[axis] + 1;
            let place = low[axis] + number % side;
            number /= side;
            place
        });
        if !is_apart(&corners, &place) {
            is_active[number_of(&place)] = true;
        }
    }
}

/// Whether an edge of the triangle separates the triangle from the unit cell at `place` (separating axis test).
fn is_apart<const D: usize>(corners: &[[f64; D]; 3], place: &[usize; D]) -> bool {
    let middle: [f64; D] = std::array::from_fn(|axis| place[axis] as f64 + 0.5);
    (0..3).any(|k| {
        let (from, to, third) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let (edge, inwards) = (minus(&to, &from), minus(&third, &from));
        // Normal of the edge in the plane of the triangle, pointing to the third corner.
        let square = dot(&edge, &edge);
        let share = if square > 0.0 { dot(&edge, &inwards) / square } else { 0.0 };
        let normal: [f64; D] = std::array::from_fn(|d| inwards[d] - share * edge[d]);
        let radius: f64 = normal.iter().map(|x| 0.5 * x.abs()).sum();
        dot(&normal, &minus(&middle, &from)) + radius < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;

    #[test]
    fn triangles_occupy_the_cells_they_touch_and_from_outside_the_nearest() {
        let grid = Grid { dims: [5, 5], basis: Basis::Bilinear, lo: [0.0, 0.0], hi: [4.0, 4.0], angle: 0.0 };
        let points = vec![[0.5, 0.5], [3.4, 0.5], [0.5, 3.4], [9.0, 2.5], [9.0, 2.6], [8.0, 2.6]];
        let found = active_cells(&grid, &Shape::of_triangles(points, vec![[0, 1, 2], [3, 4, 5]]));
        let rows: Vec<String> =
            found.chunks(4).map(|row| row.iter().map(|&is| if is { '#' } else { '.' }).collect()).collect();
        assert_eq!(rows, ["####", "###.", "##.#", "#..."]);
        assert!(active_cells(&grid, &Shape::default()).iter().all(|&is| is));
    }
}
