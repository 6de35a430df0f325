//! Functions common to screen and world layers: regions of pins, moved handles, and the fading of pins and whole layers.
//!
//! In: pins, keys and solutions. Out: regions, weights, handles; solutions faded towards rest, with matching reports.

use crate::lattice::Grid;
use crate::shot::{HandleTrack, Layer, OffsetUnit, Pin, PinTargets};
use crate::solve::{
    BranchedLattice, HandlePin, PinResidual, PointPin, Region, ResidualReason, Solution, SolveReport, Solver,
};

/// Exponent of ten of the factor on a pin's weight when it has faded out.
const MIN_WEIGHT_EXPONENT: f64 = -8.0;

/// Returns the region that moves with a pin; `diagonal`: that of the lattice's box.
pub(in crate::pipeline) fn region(pin: &Pin, diagonal: f64) -> Option<Region> {
    let unit = match pin.unit {
        OffsetUnit::Frame => 1.0,
        OffsetUnit::Box => diagonal,
    };
    pin.region.map(|region| Region {
        radius: region.radius * unit,
        rigidity: region.rigidity,
        stiffness: region.stiffness,
    })
}

/// Returns the weight of a fading pin, which falls exponentially until the pin follows the shape instead of holding it.
pub(in crate::pipeline) fn faded_weight(presence: f64) -> f64 {
    10.0_f64.powf(MIN_WEIGHT_EXPONENT * (1.0 - presence))
}

/// Returns the handles of the layer's grid that are moved by keys, with their targets.
pub(in crate::pipeline) fn moved_handles<const D: usize>(
    layer: &Layer,
    grid: &Grid<D>,
    targets: &PinTargets,
) -> Vec<HandlePin<D>> {
    let handle = |(track, offset): (&HandleTrack, &[f64; 3])| {
        let index = (0..D).map(|axis| track.index[axis] * grid.stride(axis)).sum();
        let (rest, by) = (grid.rest_handle(index), grid.scaled_to_box(std::array::from_fn(|axis| offset[axis])));
        HandlePin { index, target: std::array::from_fn(|axis| rest[axis] + by[axis]) }
    };
    layer.handles.iter().zip(&targets.handles).map(handle).collect()
}

/// Returns the handles at the border of a whole picture that hold its edge in place, at rest, except those moved by
/// keys. As many rings are held as influence the border: for B-splines this holds slope and curvature too, otherwise
/// the value alone.
pub(in crate::pipeline) fn held_border(grid: &Grid<2>, moved: &[HandlePin<2>]) -> Vec<HandlePin<2>> {
    let rings = grid.basis.border_rings();
    let is_outer = |index: usize| {
        let place = grid.handle_coords(index);
        (0..2).any(|axis| place[axis] < rings || place[axis] + rings >= grid.dims[axis])
    };
    let is_free = |index: &usize| moved.iter().all(|handle| handle.index != *index);
    let outer = (0..grid.handle_count()).filter(|&index| is_outer(index)).filter(is_free);
    outer.map(|index| HandlePin { index, target: grid.rest_handle(index) }).collect()
}

/// Fades the handles to rest together with the last pin of a layer, so that the layer does not jump when the pin
/// vanishes. The report describes the faded warp.
pub(in crate::pipeline) fn fade<const D: usize>(
    solution: &mut Solution<D>,
    (solver, pins): (&Solver<D>, &[PointPin<D>]),
    presence: f64,
) {
    let Solution { lattice, branches, report } = solution;
    let rest = lattice.grid.rest_handles();
    for (handle, rest) in lattice.handles.iter_mut().zip(rest) {
        *handle = std::array::from_fn(|axis| rest[axis] + (handle[axis] - rest[axis]) * presence);
    }
    *branches = branches.take().map(|branches| branches.faded(presence));
    let off_by = |pin: &PointPin<D>| {
        let image = branches.as_ref().map_or_else(|| lattice.deform(pin.at), |branches| branches.pin_image(pin));
        (0..D).map(|axis| (image[axis] - pin.target[axis]).powi(2)).sum::<f64>().sqrt()
    };
    report.pin_errors = pins.iter().map(off_by).collect();
    let off = report.pin_errors.iter().enumerate().filter(|(_, distance)| **distance > 0.0);
    let miss = |(pin, &distance): (usize, &f64)| PinResidual { pin, distance, reason: ResidualReason::Fading };
    report.pin_residuals = off.map(miss).collect();
    let folds = branches.as_ref().map_or_else(|| solver.folds(lattice), BranchedLattice::folds);
    report.folded_cells = folds.cells.len();
    report.folded_model_cells = folds.active_count;
    report.min_cell_det = folds.min_det;
    *report = unmeasured(std::mem::take(report));
}

/// Marks the distortion in a report as not measured, as opposed to zero.
pub(in crate::pipeline) fn unmeasured(report: SolveReport) -> SolveReport {
    SolveReport { min_det: f64::NAN, angular: f64::NAN, area: f64::NAN, ..report }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Basis;
    use crate::space::ScreenPoint;

    /// Returns the largest displacement of the border when every handle that is not held moves.
    fn border_moves(basis: Basis) -> f64 {
        let grid = Grid { dims: [8, 9], basis, lo: [0.0, 0.0], hi: [1.6, 1.0], angle: 0.0 };
        let mut lattice = grid.at_rest();
        let held: Vec<usize> = held_border(&grid, &[]).iter().map(|handle| handle.index).collect();
        let free = (0..grid.handle_count()).filter(|index| !held.contains(index));
        free.for_each(|index| lattice.handles[index][0] += 0.2);
        assert!((lattice.warp(ScreenPoint::new(0.8, 0.5)).0.x - 0.8).abs() > 0.05, "{basis:?}: the inside is free");
        let along = (0..=32).map(|k| f64::from(k) / 32.0);
        let border = along.flat_map(|t| [[1.6 * t, 0.0], [1.6 * t, 1.0], [0.0, t], [1.6, t]]);
        border.map(|[x, y]| (lattice.warp(ScreenPoint::new(x, y)).0.x - x).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_border_of_a_whole_picture_stays() {
        for basis in [Basis::Bspline, Basis::Bernstein, Basis::Bilinear, Basis::Barytri] {
            assert!(border_moves(basis) < 1e-12, "{basis:?}: {}", border_moves(basis));
        }
    }

    #[test]
    fn handles_with_keys_are_not_held() {
        let grid = Grid { dims: [8, 9], basis: Basis::Bspline, lo: [0.0, 0.0], hi: [1.6, 1.0], angle: 0.0 };
        let moved = [HandlePin { index: 0, target: [1.0, 1.0] }];
        assert_eq!(held_border(&grid, &moved).len() + 1, held_border(&grid, &[]).len());
        assert_eq!(held_border(&grid, &[]).len(), 72 - 2 * 3);
    }
}
