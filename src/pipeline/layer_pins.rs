//! What screen and world layers share: what pins take along, which handles are moved, and how pins and a whole layer
//! fade.
//!
//! In: pins, keys and solutions. Out: regions, weights, handles; solutions nearer to rest, and what their reports claim.

use crate::lattice::Grid;
use crate::shot::{HandleTrack, Layer, OffsetUnit, Pin, PinTargets};
use crate::solve::{HandlePin, MissReason, PinMiss, PointPin, Region, Solution, SolveReport, Solver};

/// A pin that fades has ten to this power of its weight at the end.
const LEAST_WEIGHT_EXPONENT: f64 = -8.0;

/// What a pin takes along; `diagonal` of the lattice's box.
pub(super) fn region(pin: &Pin, diagonal: f64) -> Option<Region> {
    let unit = match pin.unit {
        OffsetUnit::Frame => 1.0,
        OffsetUnit::Box => diagonal,
    };
    pin.region.map(|region| Region { radius: region.radius * unit, grip: region.grip, starch: region.starch })
}

/// Weight of a pin that fades: in powers of ten, down to where the shape holds the pin and not the pin the shape.
pub(super) fn faded_weight(presence: f64) -> f64 {
    10.0_f64.powf(LEAST_WEIGHT_EXPONENT * (1.0 - presence))
}

/// Where the layer's keys move handles of its grid.
pub(super) fn moved_handles<const D: usize>(layer: &Layer, grid: &Grid<D>, targets: &PinTargets) -> Vec<HandlePin<D>> {
    let handle = |(track, offset): (&HandleTrack, &[f64; 3])| {
        let index = (0..D).map(|axis| track.index[axis] * grid.stride(axis)).sum();
        let rest = grid.rest_handle(index);
        HandlePin { index, target: std::array::from_fn(|axis| rest[axis] + offset[axis] * grid.size(axis)) }
    };
    layer.handles.iter().zip(&targets.handles).map(handle).collect()
}

/// Brings the handles to rest as the last pin of a layer fades out: what does not warp at all then does not jump
/// before. The report tells what is left of the warp.
pub(super) fn fade<const D: usize>(
    solution: &mut Solution<D>,
    (solver, pins): (&Solver<D>, &[PointPin<D>]),
    presence: f64,
) {
    let Solution { lattice, report } = solution;
    let rest = lattice.grid.rest_handles();
    for (handle, rest) in lattice.handles.iter_mut().zip(rest) {
        *handle = std::array::from_fn(|axis| rest[axis] + (handle[axis] - rest[axis]) * presence);
    }
    let off_by = |pin: &PointPin<D>| {
        let image = lattice.displace(pin.at);
        (0..D).map(|axis| (image[axis] - pin.target[axis]).powi(2)).sum::<f64>().sqrt()
    };
    report.pin_errors = pins.iter().map(off_by).collect();
    let off = report.pin_errors.iter().enumerate().filter(|(_, distance)| **distance > 0.0);
    let miss = |(pin, &distance): (usize, &f64)| PinMiss { pin, distance, reason: MissReason::Fading };
    report.pin_misses = off.map(miss).collect();
    let folds = solver.folds(lattice);
    report.folded_cells = folds.cells.len();
    report.folded_model_cells = folds.occupied_count;
    report.least_cell_det = folds.least_det;
    *report = unmeasured(std::mem::take(report));
}

/// A report whose distortion says "not measured", not "none".
pub(super) fn unmeasured(report: SolveReport) -> SolveReport {
    SolveReport { least_det: f64::NAN, angular: f64::NAN, area: f64::NAN, ..report }
}
