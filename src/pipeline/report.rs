//! Tells what the solves of a frame amount to.
//!
//! In: a solved [`Moment`]. Out: a [`FrameReport`] with one entry a solved layer and warnings in words.

use super::{FrameReport, LayerReport, Moment, Setup};

/// A pin further than this from its target is told to the user, pixels.
const PIN_TOLERANCE_PX: f64 = 0.05;

/// What the solves of a frame say.
#[must_use]
pub fn report(setup: &Setup, frame: i32, moment: &Moment) -> FrameReport {
    let mut report = FrameReport { frame, ..FrameReport::default() };
    let height_px = f64::from(setup.shot.size.height);
    for (layer, state) in setup.shot.layers.iter().zip(&moment.layers) {
        let Some(solution) = &state.solution else { continue };
        let solve = solution.report.clone();
        for (pin, error) in state.pins.iter().zip(&solve.pin_errors) {
            let error_px = error * height_px;
            if error_px > PIN_TOLERANCE_PX {
                let name = &layer.pins[pin.pin].name;
                let text = format!("layer '{}': pin '{name}' is {error_px:.2} px off its target", layer.name);
                report.warnings.push(text);
            }
        }
        report.warnings.extend(solve.warnings.iter().map(|text| format!("layer '{}': {text}", layer.name)));
        let pin_error_px = solve.pin_errors.iter().fold(0.0, |a: f64, &b| a.max(b)) * height_px;
        report.layers.push(LayerReport { layer: layer.name.clone(), pin_error_px, solve });
    }
    report
}
