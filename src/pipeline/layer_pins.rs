//! What screen and world layers share of their pins: what they take along, and how they and a whole layer fade.
//!
//! In: pins and solutions. Out: regions, weights; solutions nearer to rest, and what their reports may still claim.

use crate::shot::{OffsetUnit, Pin};
use crate::solve::{MissReason, PinMiss, Region, Solution, SolveReport, Solver};

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

/// Brings the handles to rest as the last pin of a layer fades out: what does not warp at all then does not jump
/// before. The report tells what is left of the warp; `pins` are rest points and targets.
pub(super) fn fade<const D: usize>(
    solution: &mut Solution<D>,
    (solver, pins): (&Solver<D>, &[[[f64; D]; 2]]),
    presence: f64,
) {
    let Solution { lattice, report } = solution;
    let rest = lattice.grid.rest_handles();
    for (handle, rest) in lattice.handles.iter_mut().zip(rest) {
        *handle = std::array::from_fn(|axis| rest[axis] + (handle[axis] - rest[axis]) * presence);
    }
    let off_by = |[at, target]: &[[f64; D]; 2]| {
        let image = lattice.displace(*at);
        (0..D).map(|axis| (image[axis] - target[axis]).powi(2)).sum::<f64>().sqrt()
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
