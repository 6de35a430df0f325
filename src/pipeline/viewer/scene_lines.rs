//! Lines, distortion and faces of cells of lattices in the scene, as the camera sees them.
//!
//! In: a placed lattice, a camera. Out: points of the screen, numbers per point.

use super::folded_outlines::PIECES;
use crate::lattice::SceneLattice;
use crate::screen::Camera;
use crate::solve::symmetric_eigen;
use crate::space::ScreenPoint;
use glam::DVec3;
use std::collections::BTreeSet;

/// Returns where a point is on the screen; `None` if it is not in front of the camera.
pub(super) fn in_view(camera: &Camera, point: DVec3) -> Option<ScreenPoint> {
    let place = camera.project_exact(point);
    (place.w > 0.0 && place.depth >= camera.near()).then(|| place.point())
}

/// Returns the warped lines of a lattice up to where they leave the view, and the distortion at their points.
pub(super) fn lines(placed: &SceneLattice, camera: &Camera) -> (Vec<Vec<ScreenPoint>>, Vec<Vec<f64>>) {
    let SceneLattice { frame, lattice } = placed;
    let grid = &lattice.grid;
    let spans = grid.dims.map(|count| grid.basis.spans(count));
    let (mut lines, mut distortion) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for line in 0..(spans[u] + 1) * (spans[v] + 1) {
            let along = |k: usize| {
                let mut cells = [0.0; 3];
                cells[axis] = k as f64 / PIECES as f64;
                cells[u] = (line % (spans[u] + 1)) as f64;
                cells[v] = (line / (spans[u] + 1)) as f64;
                let at = grid.point_from_unit(std::array::from_fn(|a| cells[a] / spans[a] as f64));
                let carried = lattice.evaluate_with_gradient(at);
                let place = in_view(camera, frame.scene_from_box(carried.point.into()))?;
                Some((place, stretch(&carried.gradient)))
            };
            let (points, stretches) = (0..=spans[axis] * PIECES).map_while(along).unzip();
            lines.push(points);
            distortion.push(stretches);
        }
    }
    (lines, distortion)
}

/// Returns the ratio of the largest and smallest singular value of a gradient.
fn stretch(gradient: &[[f64; 3]; 3]) -> f64 {
    let product = |a: usize, b: usize| gradient.iter().map(|row| row[a] * row[b]).sum::<f64>();
    let square: [[f64; 3]; 3] = std::array::from_fn(|a| std::array::from_fn(|b| product(a, b)));
    let (squares, _) = symmetric_eigen(&square);
    let (least, most) =
        squares.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), square| (least.min(*square), most.max(*square)));
    (most / least.max(1e-12)).max(1.0).sqrt()
}

/// Returns the warped outlines of the faces around cells between handles, without those between two of the cells, as far as they
/// are in view.
pub(super) fn faces(placed: &SceneLattice, cells: &[[usize; 3]], camera: &Camera) -> Vec<Vec<ScreenPoint>> {
    let all: BTreeSet<[usize; 3]> = cells.iter().copied().collect();
    let is_inner = |mut cell: [usize; 3], axis: usize, is_far: bool| {
        let beyond = if is_far { cell[axis].checked_add(1) } else { cell[axis].checked_sub(1) };
        beyond.is_some_and(|beyond| {
            cell[axis] = beyond;
            all.contains(&cell)
        })
    };
    let sides = || (0..3).flat_map(|axis| [(axis, false), (axis, true)]);
    let outer = all.iter().flat_map(|&cell| sides().map(move |side| (cell, side)));
    let outer = outer.filter(|&(cell, (axis, is_far))| !is_inner(cell, axis, is_far));
    outer.filter_map(|(cell, side)| face(placed, cell, side, camera)).collect()
}

/// Returns the warped outline of the near or far face of a cell along an axis; `None` if it is not all in view.
fn face(
    placed: &SceneLattice,
    cell: [usize; 3],
    (axis, is_far): (usize, bool),
    camera: &Camera,
) -> Option<Vec<ScreenPoint>> {
    let SceneLattice { frame, lattice } = placed;
    let grid = &lattice.grid;
    let mut first = cell.map(|place| place as f64 - grid.basis.margin() as f64);
    first[axis] += f64::from(u8::from(is_far));
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let point = |k: usize| {
        let [from, to] = [corners[k / PIECES], corners[(k / PIECES + 1) % 4]];
        let t = (k % PIECES) as f64 / PIECES as f64;
        let mut cells = first;
        cells[u] += from[0] + (to[0] - from[0]) * t;
        cells[v] += from[1] + (to[1] - from[1]) * t;
        let unit = |axis: usize| cells[axis] / grid.basis.spans(grid.dims[axis]) as f64;
        let image = lattice.evaluate(grid.point_from_unit(std::array::from_fn(unit)));
        in_view(camera, frame.scene_from_box(image.into()))
    };
    (0..4 * PIECES).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::stretch;

    #[test]
    fn distortion_is_the_ratio_of_the_stretches_however_the_axes_are_turned() {
        let turned = |scales: [f64; 3]| {
            let (turn, scale) = (glam::DMat3::from_rotation_y(0.7), glam::DMat3::from_diagonal(scales.into()));
            let gradient = turn * scale * glam::DMat3::from_rotation_x(-1.1);
            stretch(&gradient.transpose().to_cols_array_2d())
        };
        for (scales, ratio) in [([1.0; 3], 1.0), ([2.0, 0.5, 1.0], 4.0), ([-3.0, 1.0, 1.5], 3.0)] {
            assert!((turned(scales) - ratio).abs() < 1e-9, "{scales:?}: {}", turned(scales));
        }
        assert!(turned([1.0, 1.0, 0.0]) > 1e3);
    }
}
