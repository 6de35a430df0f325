//! Layers that move a whole picture whose border rests: compliant settings for the solve, and a [`WholeWarp`] after it.
//!
//! In: a layer's settings and pins, its solved lattice. Out: the modified settings; the warp, and a report that describes it.

use super::layer_pins::unmeasured;
use crate::pipeline::PinState;
use crate::plate::{WholePin, WholeWarp};
use crate::shot::{PinTargets, Rotation};
use crate::solve::{
    ConstraintOwner, Guard, Lambdas, PinHold, PinResidual, ResidualReason, Scaling, Settings, Solution, SolveReport,
};
use crate::space::ScreenPoint;

/// λmp, dimensionless. Pins are met up to about a fiftieth of their displacement if the lattice is fine enough; a
/// coarser lattice takes what it can without swinging out elsewhere (docs/METHOD.md, "Whole pictures").
const PINS: f64 = 3e3;
/// λgp of the border handles, dimensionless.
const BORDER: f64 = 1e3;
/// Distance from its target above which a pin is reported, frame heights.
const PIN_TOLERANCE: f64 = 1e-5;

/// Returns settings under which pins and border constrain the lattice softly.
pub(in crate::pipeline) fn compliant(settings: &Settings) -> Settings {
    let lambdas = match settings.scaling {
        Scaling::Dimensionless => Lambdas { pins: PINS, handles: BORDER, ..settings.lambdas },
        Scaling::Plain => settings.lambdas,
    };
    Settings { pin_hold: PinHold::Soft, guard: Guard::Report, lambdas, ..settings.clone() }
}

/// Converts the active pins of a layer to those of its whole picture; `weights`: one per active pin, 0 to 1.
pub(in crate::pipeline) fn whole_pins(states: &[PinState], targets: &PinTargets, weights: &[f64]) -> Vec<WholePin> {
    let pin = |(state, &weight): (&PinState, &f64)| {
        let target = &targets.pins[state.pin];
        let rotation = match target.rotation {
            Some(Rotation::InView(angle)) => Some(angle),
            _ => None,
        };
        WholePin { rest: state.rest, target: state.target, weight, rotation, log_scale: target.log_scale }
    };
    states.iter().zip(weights).map(pin).collect()
}

/// Returns the warp of the whole picture by a solved lattice, and replaces the lattice by the part that the warp uses.
pub(in crate::pipeline) fn finish(solution: &mut Solution<2>, pins: &[WholePin]) -> WholeWarp {
    let whole = WholeWarp::fit(&solution.lattice, pins);
    solution.lattice = whole.lattice.clone();
    let misses = pins.iter().zip(&whole.ends).map(|(pin, end)| (pin.target - *end).0.length());
    let pin_errors: Vec<f64> = misses.collect();
    let off = pin_errors.iter().enumerate().filter(|(_, miss)| **miss > PIN_TOLERANCE);
    let residual = |(pin, &distance): (usize, &f64)| {
        let reason = match nearest(&whole.ends, pin) {
            Some(other) if pins[pin].weight >= 1.0 => ResidualReason::Conflict(ConstraintOwner::Pin(other)),
            None if pins[pin].weight >= 1.0 => ResidualReason::Overloaded,
            _ => ResidualReason::Fading,
        };
        PinResidual { pin, distance, reason }
    };
    let pin_residuals = off.map(residual).collect();
    let report = std::mem::take(&mut solution.report);
    solution.report = unmeasured(SolveReport {
        pin_errors,
        pin_residuals,
        folded_cells: 0,
        folded_model_cells: 0,
        min_cell_det: f64::NAN,
        handle_errors: Vec::new(),
        ..report
    });
    whole
}

/// Returns the pin whose image is nearest to that of the given pin, and which therefore obstructs it.
fn nearest(ends: &[ScreenPoint], pin: usize) -> Option<usize> {
    let apart = |other: usize| (ends[pin] - ends[other]).0.length();
    (0..ends.len()).filter(|&other| other != pin).min_by(|&a, &b| apart(a).total_cmp(&apart(b)))
}
